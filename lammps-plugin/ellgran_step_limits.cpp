// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_step_limits.h"

#include "atom.h"
#include "error.h"
#include "fmt/format.h"
#include "update.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <limits>

using namespace LAMMPS_NS;

namespace {

constexpr double NONE = std::numeric_limits<double>::infinity();

// Fewer steps than these in a collision do not resolve it.
constexpr double STEPS_OF_A_COLLISION = 10.0;

}    // namespace

EllgranStepLimits::EllgranStepLimits(LAMMPS *lmp, const std::string &caller_name) :
    Pointers(lmp), caller(caller_name), rayleigh{NONE, 0, 0}, collision{NONE, 0, 0},
    critical{NONE, 0, 0}, speed(0.0)
{
}

void EllgranStepLimits::find(const EllgranAtoms &atoms, const EllgranLaws *laws,
                             const std::vector<EllgranLawParameters> &parameters,
                             const std::vector<uint8_t> &used)
{
  rayleigh = collision = critical = {NONE, 0, 0};
  double fastest = 0.0;
  for (int i = 0; i < atom->nlocal; i++) {
    const double *v = atom->v[i];
    fastest = std::max(fastest, v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  }
  fastest = std::sqrt(fastest);
  MPI_Allreduce(&fastest, &speed, 1, MPI_DOUBLE, MPI_MAX, world);

  const int ntypes = atom->ntypes;
  const std::vector<EllgranBody> grains = atoms.smallest_grains();
  // Hale's form of the Hertz factors may not be defined for such a contact. Whether there ever is one the forces will tell.
  const auto is_defined = [this](int32_t status) {
    if (status != ELLGRAN_SUCCESS && status != ELLGRAN_ERROR_HALE)
      error->all(FLERR, "{}: {}", caller, ellgran_last_error());
    return status == ELLGRAN_SUCCESS;
  };
  const auto lower = [](Limit &limit, double time, int i, int j) {
    if (time < limit.time) limit = {time, i, j};
  };
  for (int i = 1; i <= ntypes; i++) {
    const EllgranBody &one = grains[i];
    if (one.mass == 0.0) continue;
    for (int j = i; j <= ntypes; j++) {
      const EllgranBody &other = grains[j];
      const std::size_t pair = static_cast<std::size_t>(i - 1) * ntypes + (j - 1);
      if (other.mass == 0.0 || !used[pair]) continue;
      double time = NONE, step = NONE;
      if (!is_defined(ellgran_two_grain_limits(laws, &one, &other, 2.0 * speed, &time, &step))) continue;
      lower(collision, time, i, j);
      lower(critical, step, i, j);
    }
    const std::size_t own = static_cast<std::size_t>(i - 1) * (ntypes + 1);
    if (!used[own]) continue;
    double time = 0.0;
    if (is_defined(ellgran_rayleigh_time(&parameters[own], &one, &time))) lower(rayleigh, time, i, i);
  }
}

std::string EllgranStepLimits::describe() const
{
  if (critical.time == NONE) return "";
  std::string text = fmt::format("time step {:.4g}: critical {:.4g} for a contact of types {} and {}", update->dt,
                                 critical.time, critical.i, critical.j);
  if (collision.time < NONE)
    text += fmt::format(", shortest collision {:.4g} (types {} and {}, speed {:.4g})", collision.time,
                        collision.i, collision.j, 2.0 * speed);
  else
    text += ", nothing moves yet";
  if (rayleigh.time < NONE)
    text += fmt::format(", Rayleigh time {:.4g} (type {})", rayleigh.time, rayleigh.i);
  return text;
}

std::string EllgranStepLimits::excess() const
{
  const double dt = update->dt;
  if (dt > critical.time)
    return fmt::format("the time step {:.4g} is longer than {:.4g}, with which a contact of types {} and {} is still "
                       "stable: grains will gain energy and be lost: reduce the time step, the stiffness or the damping",
                       dt, critical.time, critical.i, critical.j);
  if (STEPS_OF_A_COLLISION * dt > collision.time)
    return fmt::format("a collision of types {} and {} at the present speeds takes {:.4g}, fewer than {} time steps of "
                       "{:.4g}: reduce the time step to {:.4g}",
                       collision.i, collision.j, collision.time, STEPS_OF_A_COLLISION, dt,
                       collision.time / STEPS_OF_A_COLLISION);
  if (dt > rayleigh.time)
    return fmt::format("the time step {:.4g} is longer than the Rayleigh time {:.4g} of the smallest grain of type {}: "
                       "reduce it to a fifth of that",
                       dt, rayleigh.time, rayleigh.i);
  return "";
}
