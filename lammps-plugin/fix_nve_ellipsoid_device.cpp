// SPDX-License-Identifier: GPL-2.0-or-later

#include "fix_nve_ellipsoid_device.h"

#include "pair_gran_ellipsoid_device.h"

#include "atom_kokkos.h"
#include "atom_masks.h"
#include "error.h"
#include "force.h"
#include "modify.h"
#include "update.h"
#include "utils.h"

#include <cstring>

using namespace LAMMPS_NS;
using namespace FixConst;

namespace {

const char CALLER[] = "Fix nve/ellipsoid/kk";

constexpr uint64_t MOTION = V_MASK | ANGMOM_MASK;
constexpr uint64_t READ = X_MASK | MOTION | F_MASK | TORQUE_MASK | RMASS_MASK | TAG_MASK | ELLIPSOID_MASK | BONUS_MASK;

}    // namespace

FixNVEEllipsoidDevice::FixNVEEllipsoidDevice(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), atomKK(nullptr), pair(nullptr), of_step(true), swapped(false), is_new(true), time_step_before(0.0)
{
  if (!lmp->kokkos)
    error->all(FLERR, "{}: style nve/ellipsoid/kk needs LAMMPS to run with KOKKOS: start it with '-k on g 1', or use nve/ellipsoid",
               CALLER);
  atomKK = static_cast<AtomKokkos *>(atom);
  for (int k = 3; k < narg; k += 2) {
    if (std::strcmp(arg[k], "velocities") != 0)
      error->all(FLERR, "{}: unknown word '{}': after the group comes 'velocities step' or 'velocities half'", CALLER, arg[k]);
    const char *of = (k + 1 < narg) ? arg[k + 1] : "";
    of_step = std::strcmp(of, "step") == 0;
    if (!of_step && std::strcmp(of, "half") != 0)
      error->all(FLERR, "{}: 'velocities {}' must be 'velocities step' or 'velocities half'", CALLER, of);
  }
  if (igroup != 0) error->all(FLERR, "{}: on a GPU all grains move: its group must be 'all'", CALLER);
  time_integrate = 1;
  // What is kept of an atom, and of its contacts, is found by its ID: LAMMPS then refuses `reset_atoms id`.
  stores_ids = 1;
  kokkosable = 1;
  execution_space = Device;
  datamask_read = datamask_modify = EMPTY_MASK;
}

int FixNVEEllipsoidDevice::setmask()
{
  int mask = INITIAL_INTEGRATE | FINAL_INTEGRATE;
  // For what is to be done when a run starts.
  if (of_step) mask |= PRE_EXCHANGE | PRE_FORCE;
  return mask;
}

void FixNVEEllipsoidDevice::init()
{
  if (force->ftm2v != 1.0)
    error->all(FLERR, "{}: in units {} force is not mass times acceleration: use si, cgs, micro, nano or lj", CALLER,
               update->unit_style);
  if (utils::strmatch(update->integrate_style, "^respa")) error->all(FLERR, "{} does not support rRESPA: use 'run_style verlet'", CALLER);
  pair = PairGranEllipsoidDevice::of(lmp, CALLER);
  for (const auto *fix : modify->get_fix_list())
    if (fix != this && dynamic_cast<const FixNVEEllipsoidDevice *>(fix))
      error->all(FLERR, "{}: fixes {} and {} would move the same grains: remove one", CALLER, id, fix->id);
  swapped = false;
  if (is_new) pair->grains.forget_steps();
  is_new = false;
}

/* As fix nve/ellipsoid on the host: when a run starts forces are computed anew from the velocities that the last ones saw. */

void FixNVEEllipsoidDevice::setup_pre_exchange()
{
  if (update->setupflag) swap(1.0);
}

void FixNVEEllipsoidDevice::setup_pre_force(int)
{
  swap(1.0);
}

void FixNVEEllipsoidDevice::setup(int)
{
  swap(-1.0);
}

void FixNVEEllipsoidDevice::swap(double sign)
{
  if (!of_step || swapped == (sign > 0.0)) return;
  swapped = !swapped;
  atomKK->sync(Device, MOTION | TAG_MASK);
  pair->grains.add_changes(sign);
  atomKK->modified(Device, MOTION);
}

void FixNVEEllipsoidDevice::initial_integrate(int)
{
  atomKK->sync(Device, READ);
  pair->grains.start_step(update->dt, time_step_before);
  time_step_before = update->dt;
  atomKK->modified(Device, X_MASK | MOTION | BONUS_MASK);
}

void FixNVEEllipsoidDevice::final_integrate()
{
  atomKK->sync(Device, READ);
  pair->grains.finish_step(update->dt, time_step_before);
  atomKK->modified(Device, MOTION);
}
