// SPDX-License-Identifier: GPL-2.0-or-later

#include "fix_nve_ellipsoid_device.h"

#include "ellgran_restart_format.h"
#include "pair_gran_ellipsoid_device.h"

#include "atom_kokkos.h"
#include "atom_masks.h"
#include "comm.h"
#include "error.h"
#include "force.h"
#include "memory.h"
#include "modify.h"
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <unordered_map>

using namespace LAMMPS_NS;
using namespace FixConst;

namespace {

const char CALLER[] = "Fix nve/ellipsoid/kk";

constexpr uint64_t MOTION = V_MASK | ANGMOM_MASK;
constexpr uint64_t READ = X_MASK | MOTION | F_MASK | TORQUE_MASK | RMASS_MASK | TAG_MASK | ELLIPSOID_MASK | BONUS_MASK;

constexpr int STATE = EllgranDeviceGrains::KEPT_OF_STEPS;

// Forces and torques that are not known, as in fix nve/ellipsoid.
constexpr double UNKNOWN = std::numeric_limits<double>::infinity();

}    // namespace

FixNVEEllipsoidDevice::FixNVEEllipsoidDevice(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), atomKK(nullptr), pair(nullptr), of_step(true), swapped(false), is_new(true), time_step_before(0.0),
    of_steps(nullptr), ids_at_end(nullptr), held(false), runs(false)
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
  if (!of_step) return;
  create_attribute = 1;
  maxexchange = STATE + 1;
  restart_global = 1;
  restart_peratom = 1;
  // Nothing of an atom has to be sent or sorted on the GPU: with one rank no atom leaves it, with several LAMMPS sends them from the host.
  sort_device = 1;
  exchange_comm_device = (comm->nprocs == 1) ? 1 : 0;
  FixNVEEllipsoidDevice::grow_arrays(atom->nmax);
  atom->add_callback(Atom::GROW);
  atom->add_callback(Atom::RESTART);
  for (int i = 0; i < atom->nlocal; i++) FixNVEEllipsoidDevice::set_arrays(i);
}

FixNVEEllipsoidDevice::~FixNVEEllipsoidDevice()
{
  if (!of_step) return;
  atom->delete_callback(id, Atom::GROW);
  atom->delete_callback(id, Atom::RESTART);
  memory->destroy(of_steps);
  memory->destroy(ids_at_end);
}

/* LAMMPS compares the names of fixes when it hands out what a restart file has for each atom. */

void FixNVEEllipsoidDevice::post_constructor()
{
  delete[] style;
  style = utils::strdup("nve/ellipsoid");
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
  // A minimisation, and a fix that was not there in the last run, know nothing of the step before.
  if (is_new && !held) pair->grains.forget_steps();
  is_new = false;
}

/* The pair style may be another one than in the last run. */

void FixNVEEllipsoidDevice::follow_atoms(PairGranEllipsoidDevice *pair_now)
{
  pair = pair_now;
  if (of_step && !is_new && !held && atoms_have_changed()) take_from_device();
}

bool FixNVEEllipsoidDevice::atoms_have_changed() const
{
  if (!pair->grains.has_list()) return false;
  return atom->nlocal != pair->grains.owned_in_list() || !std::equal(ids_at_end, ids_at_end + atom->nlocal, atom->tag);
}

/* From the GPU to the atoms: in a run by the IDs that they have, between runs by those that they had when the last one ended. */

void FixNVEEllipsoidDevice::take_from_device()
{
  atomKK->sync(Host, TAG_MASK);
  const auto values = pair->grains.steps();
  std::unordered_map<tagint, std::size_t> place;
  if (!values.empty()) {
    const auto &rows = pair->grains.rows();
    for (int k = 0; k < rows.owned; k++) place[rows.ids[k]] = k;
  }
  for (int i = 0; i < atom->nlocal; i++) {
    const auto found = place.find(runs ? atom->tag[i] : ids_at_end[i]);
    if (found == place.end())
      FixNVEEllipsoidDevice::set_arrays(i);
    else
      std::copy_n(&values[STATE * found->second], STATE, of_steps[i]);
  }
  held = true;
}

void FixNVEEllipsoidDevice::give_to_device()
{
  if (!held) return;
  std::vector<double> values(static_cast<std::size_t>(STATE) * atom->nlocal);
  for (int i = 0; i < atom->nlocal; i++) std::copy_n(of_steps[i], STATE, &values[static_cast<std::size_t>(STATE) * i]);
  pair->grains.set_steps(values);
  held = false;
}

void FixNVEEllipsoidDevice::pre_exchange()
{
  if (comm->nprocs > 1) take_from_device();
}

void FixNVEEllipsoidDevice::post_run()
{
  if (!of_step) return;
  // With one rank the GPU can be asked later.
  if (comm->nprocs > 1) take_from_device();
  std::copy_n(atom->tag, atom->nlocal, ids_at_end);
  runs = false;
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
  runs = true;
}

void FixNVEEllipsoidDevice::swap(double sign)
{
  if (!of_step || swapped == (sign > 0.0)) return;
  swapped = !swapped;
  atomKK->sync(Device, MOTION | TAG_MASK);
  // Atoms are yet to be exchanged, and what they have goes with them.
  const bool goes_with_them = held;
  give_to_device();
  held = goes_with_them;
  pair->grains.add_changes(sign);
  atomKK->modified(Device, MOTION);
}

void FixNVEEllipsoidDevice::initial_integrate(int)
{
  atomKK->sync(Device, READ);
  held = false;
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

double FixNVEEllipsoidDevice::memory_usage()
{
  return of_step ? static_cast<double>(atom->nmax) * (STATE * sizeof(double) + sizeof(tagint)) : 0.0;
}

void FixNVEEllipsoidDevice::grow_arrays(int nmax)
{
  memory->grow(of_steps, nmax, STATE, "nve/ellipsoid:of_steps");
  memory->grow(ids_at_end, nmax, "nve/ellipsoid:ids_at_end");
}

void FixNVEEllipsoidDevice::copy_arrays(int i, int j, int)
{
  std::copy_n(of_steps[i], STATE, of_steps[j]);
  ids_at_end[j] = ids_at_end[i];
}

void FixNVEEllipsoidDevice::set_arrays(int i)
{
  std::fill_n(of_steps[i], STATE, 0.0);
  of_steps[i][STATE / 2] = UNKNOWN;
  ids_at_end[i] = 0;
}

int FixNVEEllipsoidDevice::pack_exchange(int i, double *buffer)
{
  std::copy_n(of_steps[i], STATE, buffer);
  buffer[STATE] = ubuf(ids_at_end[i]).d;
  return STATE + 1;
}

/* A rank to which no atom of a restart file belonged may get some before the first step. */

int FixNVEEllipsoidDevice::unpack_exchange(int i, double *buffer)
{
  held = true;
  std::copy_n(buffer, STATE, of_steps[i]);
  ids_at_end[i] = static_cast<tagint>(ubuf(buffer[STATE]).i);
  return STATE + 1;
}

int FixNVEEllipsoidDevice::size_restart(int)
{
  return 1 + STATE;
}

int FixNVEEllipsoidDevice::maxsize_restart()
{
  return 1 + STATE;
}

int FixNVEEllipsoidDevice::pack_restart(int i, double *buffer)
{
  buffer[0] = 1 + STATE;
  std::copy_n(of_steps[i], STATE, buffer + 1);
  return 1 + STATE;
}

void FixNVEEllipsoidDevice::unpack_restart(int i, int nth)
{
  // 'velocities half' under the ID of a fix of the file that had velocities of the step.
  if (!of_step) return;
  double *extra = atom->extra[i];
  for (int k = 0; k < nth; k++) extra += static_cast<int>(*extra);
  if (static_cast<int>(extra[0]) != 1 + STATE)
    error->one(FLERR, "{}: the restart file is damaged: {} values of an atom where there are {}", CALLER, extra[0], 1 + STATE);
  std::copy_n(extra + 1, STATE, of_steps[i]);
  held = true;
}

void FixNVEEllipsoidDevice::write_restart(FILE *fp)
{
  if (!held && pair) take_from_device();
  if (comm->me != 0) return;
  const double values[2] = {EllgranRestart::MOTION_FORMAT, time_step_before};
  const int size = sizeof(values);
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(values, sizeof(double), 2, fp);
}

void FixNVEEllipsoidDevice::restart(char *buffer)
{
  double values[2];
  std::memcpy(values, buffer, sizeof(values));
  if (values[0] > EllgranRestart::MOTION_FORMAT)
    error->all(FLERR,
               "{}: the restart file has format version {} of this fix. This is ellgran {}, which reads version {}: use the ellgran that "
               "wrote the file, or give the fix another ID",
               CALLER, values[0], ellgran_version(), EllgranRestart::MOTION_FORMAT);
  time_step_before = values[1];
}
