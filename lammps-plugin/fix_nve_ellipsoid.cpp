// SPDX-License-Identifier: GPL-2.0-or-later

#include "fix_nve_ellipsoid.h"

#include "ellgran_kokkos.h"
#include "ellgran_restart_format.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "force.h"
#include "group.h"
#include "input.h"
#include "memory.h"
#include "modify.h"
#include "respa.h"
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <cstring>
#include <limits>

using namespace LAMMPS_NS;
using namespace FixConst;

namespace {

constexpr int CHANGES = 6, LOADS = 6, STATE = CHANGES + LOADS;

// Forces and torques that are not known.
constexpr double UNKNOWN = std::numeric_limits<double>::infinity();

}    // namespace

FixNVEEllipsoid::FixNVEEllipsoid(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), atoms(lmp, "Fix nve/ellipsoid"), workspace(nullptr), of_step(true), keeper(nullptr),
    step_bits(0), groups_change(false), swapped(false), time_step_before(0.0), changes(nullptr), loads_before(nullptr)
{
  for (int k = 3; k < narg; k += 2) {
    if (std::strcmp(arg[k], "velocities") != 0)
      error->all(FLERR, "Fix nve/ellipsoid: unknown word '{}': after the group comes 'velocities step' or 'velocities half'",
                 arg[k]);
    const char *of = (k + 1 < narg) ? arg[k + 1] : "";
    of_step = std::strcmp(of, "step") == 0;
    if (!of_step && std::strcmp(of, "half") != 0)
      error->all(FLERR, "Fix nve/ellipsoid: 'velocities {}' must be 'velocities step' or 'velocities half'", of);
  }
  dynamic_group_allow = 1;
  time_integrate = 1;
  atoms.require_atom_style();
  if (ellgran_workspace_new(&workspace) != ELLGRAN_SUCCESS)
    error->all(FLERR, "Fix nve/ellipsoid: {}", ellgran_last_error());
  if (!of_step) return;
  create_attribute = 1;
  comm_forward = CHANGES;
  maxexchange = STATE;
  restart_global = 1;
  restart_peratom = 1;
  FixNVEEllipsoid::grow_arrays(atom->nmax);
  atom->add_callback(Atom::GROW);
  atom->add_callback(Atom::RESTART);
  forget();
}

FixNVEEllipsoid::~FixNVEEllipsoid()
{
  if (of_step) {
    leave_to_another();
    atom->delete_callback(id, Atom::GROW);
    atom->delete_callback(id, Atom::RESTART);
    memory->destroy(changes);
    memory->destroy(loads_before);
  }
  ellgran_workspace_free(workspace);
}

int FixNVEEllipsoid::setmask()
{
  int mask = INITIAL_INTEGRATE | FINAL_INTEGRATE | INITIAL_INTEGRATE_RESPA | FINAL_INTEGRATE_RESPA;
  // For what is to be done when a run starts, and for atoms that leave a dynamic group.
  if (of_step) mask |= PRE_EXCHANGE | PRE_FORCE | POST_FORCE;
  return mask;
}

void FixNVEEllipsoid::init()
{
  require_host_kokkos(lmp, "Fix nve/ellipsoid");
  if (force->ftm2v != 1.0)
    error->all(FLERR, "Fix nve/ellipsoid: in units {} force is not mass times acceleration: use si, cgs, micro, nano or lj",
               update->unit_style);
  atoms.require_shapes(groupbit);
  keeper = of_step ? keeper_of(modify) : nullptr;
  swapped = false;
  if (!of_step) return;
  step_bits = 0;
  groups_change = false;
  for (const auto *fix : all_of_step(modify)) {
    step_bits |= fix->groupbit;
    if (group->dynamic[fix->igroup]) groups_change = true;
  }
  if (!keeper && comm->me == 0)
    error->warning(FLERR, "Fix nve/ellipsoid: with run_style respa forces see velocities of the half step");
  // A minimisation changes forces while no time passes, `rerun` brings other atoms, and rRESPA knows nothing of what is kept here.
  if (!keeper || update->whichflag == 2 || (input->command && std::strcmp(input->command, "rerun") == 0)) forget();
  if (this == keeper) forget_others();
}

std::vector<FixNVEEllipsoid *> FixNVEEllipsoid::all_of_step(Modify *modify)
{
  std::vector<FixNVEEllipsoid *> all;
  for (auto *fix : modify->get_fix_by_style("^nve/ellipsoid$")) {
    auto *found = dynamic_cast<FixNVEEllipsoid *>(fix);
    if (found && found->of_step) all.push_back(found);
  }
  return all;
}

FixNVEEllipsoid *FixNVEEllipsoid::keeper_of(Modify *modify)
{
  const auto all = all_of_step(modify);
  if (all.empty() || utils::strmatch(all.front()->update->integrate_style, "^respa")) return nullptr;
  return all.front();
}

/* What this fix kept for all is kept by the next one from now on. */

void FixNVEEllipsoid::leave_to_another()
{
  const auto all = all_of_step(modify);
  if (all.size() < 2 || all.front() != this) return;
  FixNVEEllipsoid *const next = all[1];
  for (int i = 0; i < atom->nlocal; i++) {
    std::copy_n(changes[i], CHANGES, next->changes[i]);
    std::copy_n(loads_before[i], LOADS, next->loads_before[i]);
  }
}

/* Nothing is known of the steps before: the velocities that the forces saw are those that there are. */

void FixNVEEllipsoid::forget()
{
  for (int i = 0; i < atom->nlocal; i++) FixNVEEllipsoid::set_arrays(i);
  time_step_before = 0.0;
}

/* Atoms that no fix of this style moves any more have the velocities that there are. */

void FixNVEEllipsoid::forget_others()
{
  for (int i = 0; i < atom->nlocal; i++)
    if (!(atom->mask[i] & step_bits)) FixNVEEllipsoid::set_arrays(i);
}

/* LAMMPS computes forces anew when a run starts. They must be those with which the last run ended: of the velocities that
   these saw, on images too. What reads velocities when all is set up shall see those of the step. */

void FixNVEEllipsoid::setup_pre_exchange()
{
  // `write_data` calls this too, and no run begins.
  if (keeper && update->setupflag) keeper->swap(1.0);
}

void FixNVEEllipsoid::setup_pre_force(int)
{
  // 'run ... pre no' exchanges no atoms: images still have the velocities of the last forces.
  if (keeper) keeper->swap(1.0);
}

void FixNVEEllipsoid::setup(int)
{
  if (keeper && all_of_step(modify).back() == this) keeper->swap(-1.0);
}

/* Of all atoms: changes are 0 where no fix of this style moves them, and a dynamic group may change between the two swaps. */

void FixNVEEllipsoid::swap(double sign)
{
  if (this != keeper || swapped == (sign > 0.0)) return;
  swapped = !swapped;
  for (int i = 0; i < atom->nlocal; i++)
    for (int k = 0; k < 3; k++) {
      atom->v[i][k] += sign * changes[i][k];
      atom->angmom[i][k] += sign * changes[i][3 + k];
    }
}

void FixNVEEllipsoid::with_integrated_velocities(Modify *modify, const std::function<void()> &action)
{
  FixNVEEllipsoid *const found = keeper_of(modify);
  if (!found || !found->swapped) {
    action();
    return;
  }
  found->swap(-1.0);
  action();
  found->swap(1.0);
}

void FixNVEEllipsoid::lend_changes(EllgranParticles &particles, bool with_ghosts)
{
  if (with_ghosts) comm->forward_comm(this);
  if (atom->nlocal + atom->nghost == 0) return;
  particles.velocity_changes = changes[0];
  if (!update->setupflag || update->whichflag != 1 || swapped) return;
  velocities.assign(particles.velocities, particles.velocities + 3 * particles.count);
  angular_momenta.assign(particles.angular_momenta, particles.angular_momenta + 3 * particles.count);
  for (int i = 0; i < atom->nlocal; i++)
    for (int k = 0; k < 3; k++) {
      velocities[3 * i + k] += changes[i][k];
      angular_momenta[3 * i + k] += changes[i][3 + k];
    }
  particles.velocities = velocities.data();
  particles.angular_momenta = angular_momenta.data();
}

EllgranMotion FixNVEEllipsoid::motion() const
{
  const EllgranParticles particles = atoms.view();
  EllgranMotion motion = ELLGRAN_INIT(EllgranMotion);
  motion.count = (igroup == atom->firstgroup) ? atom->nfirst : atom->nlocal;
  if (motion.count == 0) return motion;
  motion.positions = atom->x[0];
  motion.velocities = atom->v[0];
  motion.angular_momenta = atom->angmom[0];
  motion.forces = atom->f[0];
  motion.torques = atom->torque[0];
  motion.masses = particles.masses;
  motion.shape_indices = particles.shape_indices;
  motion.semi_axes = particles.semi_axes;
  motion.semi_axes_stride = particles.semi_axes_stride;
  // The atoms are this fix' to move.
  motion.quaternions = const_cast<double *>(particles.quaternions);
  motion.quaternions_stride = particles.quaternions_stride;
  motion.masks = atom->mask;
  motion.group_mask = groupbit;
  motion.identifiers = particles.identifiers;
  motion.identifier_bytes = particles.identifier_bytes;
  if (keeper) {
    motion.velocity_changes = keeper->changes[0];
    motion.loads_before = keeper->loads_before[0];
    motion.time_step_before = time_step_before;
  }
  return motion;
}

void FixNVEEllipsoid::start(double time_step)
{
  // When the run started a dynamic group may have lost atoms after forces were computed.
  if (this == keeper && groups_change) forget_others();
  const EllgranMotion grains = motion();
  if (ellgran_start_step(workspace, &grains, time_step) != ELLGRAN_SUCCESS)
    error->one(FLERR, "Fix nve/ellipsoid: {}", ellgran_last_error());
  time_step_before = time_step;
}

void FixNVEEllipsoid::finish(double time_step)
{
  const EllgranMotion grains = motion();
  if (ellgran_finish_step(workspace, &grains, time_step) != ELLGRAN_SUCCESS)
    error->one(FLERR, "Fix nve/ellipsoid: {}", ellgran_last_error());
}

void FixNVEEllipsoid::initial_integrate(int)
{
  start(update->dt);
}

/* LAMMPS makes dynamic groups anew when forces are known. From velocities of the half step any integrator goes on. */

void FixNVEEllipsoid::post_force(int)
{
  if (this != keeper || !groups_change) return;
  for (int i = 0; i < atom->nlocal; i++) {
    if (atom->mask[i] & step_bits) continue;
    for (int k = 0; k < 3; k++) {
      atom->v[i][k] -= changes[i][k];
      atom->angmom[i][k] -= changes[i][3 + k];
    }
    FixNVEEllipsoid::set_arrays(i);
  }
}

void FixNVEEllipsoid::final_integrate()
{
  finish(update->dt);
}

double FixNVEEllipsoid::step_of_level(int level) const
{
  return static_cast<Respa *>(update->integrate)->step[level];
}

void FixNVEEllipsoid::initial_integrate_respa(int, int level, int)
{
  // The innermost level moves the grains, the others kick.
  if (level == 0)
    start(step_of_level(level));
  else
    finish(step_of_level(level));
}

void FixNVEEllipsoid::final_integrate_respa(int level, int)
{
  finish(step_of_level(level));
}

double FixNVEEllipsoid::memory_usage()
{
  const double counts = (of_step ? static_cast<double>(STATE) * atom->nmax : 0.0) +
      static_cast<double>(velocities.capacity() + angular_momenta.capacity());
  return counts * sizeof(double);
}

void FixNVEEllipsoid::grow_arrays(int nmax)
{
  memory->grow(changes, nmax, CHANGES, "nve/ellipsoid:changes");
  memory->grow(loads_before, nmax, LOADS, "nve/ellipsoid:loads_before");
}

void FixNVEEllipsoid::copy_arrays(int i, int j, int)
{
  std::copy_n(changes[i], CHANGES, changes[j]);
  std::copy_n(loads_before[i], LOADS, loads_before[j]);
}

void FixNVEEllipsoid::set_arrays(int i)
{
  std::fill_n(changes[i], CHANGES, 0.0);
  std::fill_n(loads_before[i], LOADS, 0.0);
  loads_before[i][0] = UNKNOWN;
}

int FixNVEEllipsoid::pack_exchange(int i, double *buffer)
{
  std::copy_n(loads_before[i], LOADS, std::copy_n(changes[i], CHANGES, buffer));
  return STATE;
}

int FixNVEEllipsoid::unpack_exchange(int i, double *buffer)
{
  std::copy_n(buffer, CHANGES, changes[i]);
  std::copy_n(buffer + CHANGES, LOADS, loads_before[i]);
  return STATE;
}

int FixNVEEllipsoid::pack_forward_comm(int n, int *indices, double *buffer, int, int *)
{
  // Of a length that the compiler knows `memcpy` is a few moves; `copy_n` calls a function.
  for (int k = 0; k < n; k++) std::memcpy(buffer + CHANGES * k, changes[indices[k]], CHANGES * sizeof(double));
  return CHANGES * n;
}

void FixNVEEllipsoid::unpack_forward_comm(int n, int first, double *buffer)
{
  if (n > 0) std::copy_n(buffer, CHANGES * static_cast<std::size_t>(n), changes[first]);
}

int FixNVEEllipsoid::size_restart(int)
{
  return 1 + STATE;
}

int FixNVEEllipsoid::maxsize_restart()
{
  return 1 + STATE;
}

int FixNVEEllipsoid::pack_restart(int i, double *buffer)
{
  buffer[0] = 1 + pack_exchange(i, buffer + 1);
  return 1 + STATE;
}

void FixNVEEllipsoid::unpack_restart(int nlocal, int nth)
{
  // 'velocities half' under the ID of a fix of the file that had velocities of the step.
  if (!of_step) return;
  double *extra = atom->extra[nlocal];
  for (int k = 0; k < nth; k++) extra += static_cast<int>(*extra);
  if (static_cast<int>(extra[0]) != 1 + STATE)
    error->one(FLERR,
               "Fix nve/ellipsoid: the restart file has {} values of an atom where there are {}: atoms were added since read_restart, before "
               "this fix was given, or the file is damaged",
               extra[0], 1 + STATE);
  unpack_exchange(nlocal, extra + 1);
}

void FixNVEEllipsoid::write_restart(FILE *fp)
{
  if (comm->me != 0) return;
  const double values[2] = {EllgranRestart::MOTION_FORMAT, time_step_before};
  const int size = sizeof(values);
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(values, sizeof(double), 2, fp);
}

void FixNVEEllipsoid::restart(char *buffer)
{
  double values[2];
  std::memcpy(values, buffer, sizeof(values));
  if (values[0] > EllgranRestart::MOTION_FORMAT)
    error->all(FLERR,
               "Fix nve/ellipsoid: the restart file has format version {} of this fix. This is ellgran {}, which reads "
               "version {}: use the ellgran that wrote the file, or give the fix another ID",
               values[0], ellgran_version(), EllgranRestart::MOTION_FORMAT);
  time_step_before = values[1];
}

void FixNVEEllipsoid::set_molecule(int, tagint, int, double *, double *, double *)
{
  error->all(FLERR, "Molecule update not implemented for fix {}", style);
}
