// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_step_velocity.h"

#include "ellgran_substitute.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "memory.h"
#include "modify.h"
#include "update.h"
#include "utils.h"

#include <algorithm>

using namespace LAMMPS_NS;
using namespace FixConst;

namespace {

bool prescribes_motion(const Fix *fix)
{
  return utils::strmatch(fix->style, "^move");
}

double square(const double *v)
{
  return v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
}

}    // namespace

FixEllgranStepVelocity::FixEllgranStepVelocity(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), moved_bits(0), rigid_bits(0), difference(nullptr), start(nullptr)
{
  nevery = 1;
  create_attribute = 1;
  comm_forward = 3;
  maxexchange = 3;
  FixEllgranStepVelocity::grow_arrays(atom->nmax);
  atom->add_callback(Atom::GROW);
  for (int i = 0; i < atom->nlocal; i++) FixEllgranStepVelocity::set_arrays(i);
}

FixEllgranStepVelocity::~FixEllgranStepVelocity()
{
  atom->delete_callback(id, Atom::GROW);
  memory->destroy(difference);
  memory->destroy(start);
}

bool FixEllgranStepVelocity::needed(Modify *modify)
{
  for (const auto *fix : modify->get_fix_list())
    if (fix->rigid_flag || prescribes_motion(fix)) return true;
  return false;
}

int FixEllgranStepVelocity::setmask()
{
  return POST_INTEGRATE | END_OF_STEP;
}

void FixEllgranStepVelocity::init()
{
  moved_bits = rigid_bits = 0;
  for (const auto *fix : modify->get_fix_list()) {
    if (fix->rigid_flag) rigid_bits |= fix->groupbit;
    if (prescribes_motion(fix)) moved_bits |= fix->groupbit;
  }
}

void FixEllgranStepVelocity::setup(int)
{
  end_of_step();
}

void FixEllgranStepVelocity::end_of_step()
{
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & (moved_bits | rigid_bits))) continue;
    std::copy_n(atom->x[i], 3, start[i]);
    std::copy_n(atom->v[i], 3, start[i] + 3);
  }
}

void FixEllgranStepVelocity::post_integrate()
{
  const double per_step = 1.0 / update->dt;
  for (int i = 0; i < atom->nlocal; i++) {
    double *found = difference[i];
    found[0] = found[1] = found[2] = 0.0;
    const int mask = atom->mask[i];
    if (!(mask & (moved_bits | rigid_bits))) continue;
    double change[3];
    for (int k = 0; k < 3; k++) {
      found[k] = (atom->x[i][k] - start[i][k]) * per_step - atom->v[i][k];
      change[k] = atom->v[i][k] - start[i][3 + k];
    }
    // A motion may be given with a velocity that is not its own: a belt that stays and conveys. The velocity
    // over the step then does not lie between those at its ends.
    if (!(mask & rigid_bits) && square(found) > square(change)) found[0] = found[1] = found[2] = 0.0;
  }
}

const double *FixEllgranStepVelocity::velocities(bool with_ghosts)
{
  // When a run starts forces are computed anew from the velocities of that instant; no step led there.
  if ((moved_bits | rigid_bits) == 0 || update->setupflag || update->whichflag == 2) return nullptr;
  if (with_ghosts) comm->forward_comm(this);
  const int count = atom->nlocal + (with_ghosts ? atom->nghost : 0);
  if (count == 0) return nullptr;
  result.resize(3 * static_cast<std::size_t>(atom->nmax));
  for (int i = 0; i < count; i++)
    for (int k = 0; k < 3; k++) result[3 * i + k] = atom->v[i][k] + difference[i][k];
  return result.data();
}

double FixEllgranStepVelocity::memory_usage()
{
  return (9.0 * atom->nmax + static_cast<double>(result.capacity())) * sizeof(double);
}

void FixEllgranStepVelocity::grow_arrays(int nmax)
{
  memory->grow(difference, nmax, 3, "ellgran_step_velocity:difference");
  memory->grow(start, nmax, 6, "ellgran_step_velocity:start");
}

void FixEllgranStepVelocity::copy_arrays(int i, int j, int)
{
  std::copy_n(difference[i], 3, difference[j]);
  std::copy_n(start[i], 6, start[j]);
}

void FixEllgranStepVelocity::set_arrays(int i)
{
  std::fill_n(difference[i], 3, 0.0);
  std::copy_n(atom->x[i], 3, start[i]);
  std::copy_n(atom->v[i], 3, start[i] + 3);
}

int FixEllgranStepVelocity::pack_exchange(int i, double *buffer)
{
  std::copy_n(difference[i], 3, buffer);
  return 3;
}

int FixEllgranStepVelocity::unpack_exchange(int i, double *buffer)
{
  std::copy_n(buffer, 3, difference[i]);
  return 3;
}

int FixEllgranStepVelocity::pack_forward_comm(int n, int *indices, double *buffer, int, int *)
{
  for (int k = 0; k < n; k++) std::copy_n(difference[indices[k]], 3, buffer + 3 * k);
  return 3 * n;
}

void FixEllgranStepVelocity::unpack_forward_comm(int n, int first, double *buffer)
{
  for (int k = 0; k < n; k++) std::copy_n(buffer + 3 * k, 3, difference[first + k]);
}

void FixEllgranStepVelocity::set_molecule(int, tagint, int, double *, double *, double *)
{
  error->all(FLERR, "Molecule update not implemented for fix {}", style);
}

FixEllgranStepVelocity *LAMMPS_NS::add_step_velocity(Modify *modify, const std::string &prefix)
{
  std::string id = prefix;
  for (int number = 2; modify->get_fix_by_id(id); number++) id = prefix + std::to_string(number);
  const SubstituteFix<FixEllgranStepVelocity> substitute(modify, "DUMMY");
  return static_cast<FixEllgranStepVelocity *>(modify->add_fix(id + " all DUMMY", 0));
}
