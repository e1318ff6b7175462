/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_nve_ellipsoid.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "atom.h"
#include "comm.h"
#include "ellgran_contact.h"
#include "ellgran_shape.h"
#include "error.h"
#include "fix_wall_gran.h"
#include "force.h"
#include "memory.h"
#include "modify.h"
#include "pair_gran.h"
#include "update.h"

using namespace LAMMPS_NS;
using namespace FixConst;
using LIGGGHTS::ContactModels::EllgranContact;

namespace {

const int CHANGES = 6, LOADS = 6, STATE = CHANGES + LOADS;

/*
 * In restart files: 1 and the time step of the last step, 0 if there was none; of a particle what velocity (3) and angular momentum (3)
 * that the last forces saw have more than those in the file, and force (3) and torque (3) when the last step began, the first of
 * them infinite if they are not known. Raise it as VERSION of fix_ellgran_restart_format.h says.
 */
const double FORMAT = 1.0;

// the tangential or rolling model that sums up a displacement of its own
template<typename Owner>
std::string spring_of(Owner *owner)
{
  if (!owner->contact_match("tangential", "off") && !owner->contact_match("tangential", "no_history") &&
      !owner->contact_match("tangential", "tfd"))
    return owner->contact_match("tangential", "history") ? "tangential history" : "its tangential model";
  const char *const rolling[] = {"epsd", "epsd2", "epsd3", "luding"};
  for (int k = 0; k < 4; k++)
    if (owner->contact_match("rolling_friction", rolling[k])) return std::string("rolling_friction ") + rolling[k];
  return std::string();
}

}

FixNVEEllipsoid::FixNVEEllipsoid(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg),
    workspace_(NULL),
    word_(DEFAULT),
    keeper_(NULL),
    swapped_(false),
    extrapolated_(false),
    ghosts_wanted_(false),
    step_bits_(0),
    time_step_before_(0.0),
    said_half_(false),
    said_inertia_(false),
    changes_(NULL),
    loads_before_(NULL),
    motion_changes_(NULL)
{
  for (int k = 3; k < narg; k += 2) {
    char message[300];
    if (strcmp(arg[k], "velocities") != 0) {
      snprintf(message, sizeof(message),
               "unknown word '%s': after the group comes 'velocities step' or 'velocities half'", arg[k]);
      refuse(message);
    }
    const char *const of = k + 1 < narg ? arg[k + 1] : "";
    if (strcmp(of, "step") != 0 && strcmp(of, "half") != 0) {
      snprintf(message, sizeof(message), "'velocities %s' must be 'velocities step' or 'velocities half'", of);
      refuse(message);
    }
    word_ = strcmp(of, "step") == 0 ? STEP : HALF;
  }
  if (!atom->superquadric_flag) refuse("needs atom_style superquadric");
  time_integrate = 1;
  check(ellgran_workspace_new(&workspace_));
  if (word_ == HALF) return;
  create_attribute = 1;
  comm_forward = CHANGES;
  restart_global = 1;
  restart_peratom = 1;
  FixNVEEllipsoid::grow_arrays(atom->nmax);
  atom->add_callback(0);
  atom->add_callback(1);
  forget();
}

FixNVEEllipsoid::~FixNVEEllipsoid()
{
  if (word_ != HALF) {
    atom->delete_callback(id, 0);
    atom->delete_callback(id, 1);
    memory->destroy(changes_);
    memory->destroy(loads_before_);
    memory->destroy(motion_changes_);
  }
  ellgran_workspace_free(workspace_);
}

// What this fix kept for all is kept by the next one from now on.
void FixNVEEllipsoid::pre_delete(bool unfixflag)
{
  if (!unfixflag || word_ == HALF) return;
  const std::vector<FixNVEEllipsoid *> all = all_of_step(modify);
  if (all.size() < 2 || all.front() != this) return;
  for (int i = 0; i < atom->nlocal; i++) {
    memcpy(all[1]->changes_[i], changes_[i], CHANGES * sizeof(double));
    memcpy(all[1]->loads_before_[i], loads_before_[i], LOADS * sizeof(double));
  }
}

int FixNVEEllipsoid::setmask()
{
  int mask = INITIAL_INTEGRATE | FINAL_INTEGRATE;
  if (word_ != HALF) mask |= PRE_EXCHANGE | PRE_FORCE;
  return mask;
}

void FixNVEEllipsoid::refuse(const char *message) const
{
  error->fix_error(FLERR, const_cast<FixNVEEllipsoid *>(this), message);
}

void FixNVEEllipsoid::init()
{
  if (force->ftm2v != 1.0)
    refuse("in these units force is not mass times acceleration: use units si, cgs, micro or lj");
  // with no levels of its own it would move nothing, and nobody would say so
  if (strcmp(update->integrate_style, "verlet") != 0) {
    char message[200];
    snprintf(message, sizeof(message), "needs run_style verlet, and not %s", update->integrate_style);
    refuse(message);
  }
  // its implicit drag is a part of LIGGGHTS' own integrators
  if (modify->n_fixes_style("couple/cfd/force/implicit") > 0)
    refuse("does not go with fix couple/cfd/force/implicit: use nve/superquadric");
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->mask[i] & groupbit) ellgran_check_blockiness(lmp, style, i);
  warn_of_other_inertia();

  swapped_ = extrapolated_ = false;
  keeper_ = NULL;
  if (word_ == HALF) return;
  const std::string spring = own_spring();
  if (!spring.empty()) {
    char message[400];
    snprintf(message, sizeof(message),
             "%s sums up a displacement from the velocities that forces see, and 'velocities step' would damp it: use tangential tfd "
             "and rolling_friction off or cdt, or 'velocities half'",
             spring.c_str());
    if (word_ == STEP) refuse(message);
    if (comm->me == 0 && !said_half_) {
      FILE *const streams[] = {screen, logfile};
      for (int k = 0; k < 2; k++)
        if (streams[k]) fprintf(streams[k], "Fix %s nve/ellipsoid: velocities half, since %s sums up a displacement\n", id, spring.c_str());
    }
    said_half_ = true;
    forget();
    return;
  }
  const std::vector<FixNVEEllipsoid *> all = all_of_step(modify);
  keeper_ = all.front();
  // a minimisation changes forces while no time passes
  if (update->whichflag == 2) forget();
  if (this != keeper_) return;
  step_bits_ = 0;
  for (size_t k = 0; k < all.size(); k++) step_bits_ |= all[k]->groupbit;
  ghosts_wanted_ = EllgranContact::any_has_friction();
  // particles that no fix of this style moves any more have the velocities that there are
  for (int i = 0; i < atom->nlocal; i++)
    if (!(atom->mask[i] & step_bits_)) FixNVEEllipsoid::set_arrays(i);
  if (atom->nmax > 0) memset(motion_changes_[0], 0, static_cast<size_t>(atom->nmax) * CHANGES * sizeof(double));
}

// 'set' changes the mass without the moments of inertia, and the latter by themselves; those that count here follow from mass and shape.
void FixNVEEllipsoid::warn_of_other_inertia()
{
  int other = 0;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & groupbit)) continue;
    const double *const a = atom->shape[i];
    for (int k = 0; k < 3; k++) {
      const double b = a[(k + 1) % 3], c = a[(k + 2) % 3];
      const double solid = 0.2 * atom->rmass[i] * (b * b + c * c);
      if (!(fabs(atom->inertia[i][k] - solid) <= 1e-6 * solid)) other = std::max(other, atom->tag[i]);
    }
  }
  int particle = 0;
  MPI_Allreduce(&other, &particle, 1, MPI_INT, MPI_MAX, world);
  if (particle == 0 || said_inertia_) return;
  said_inertia_ = true;
  if (comm->me != 0) return;
  char message[400];
  snprintf(message, sizeof(message),
           "Fix %s nve/ellipsoid: particle %d turns as a solid ellipsoid of its mass and shape, and has other moments of inertia, with which "
           "'set omegax' and its like gave it its angular momentum: set its density, and neither mass nor inertiax, inertiay, inertiaz",
           id, particle);
  error->warning(FLERR, message);
}

std::vector<FixNVEEllipsoid *> FixNVEEllipsoid::all_of_step(Modify *modify)
{
  std::vector<FixNVEEllipsoid *> all;
  for (int k = 0; k < modify->nfix; k++) {
    FixNVEEllipsoid *const found = dynamic_cast<FixNVEEllipsoid *>(modify->fix[k]);
    if (found && found->word_ != HALF) all.push_back(found);
  }
  return all;
}

std::string FixNVEEllipsoid::own_spring() const
{
  std::string found;
  if (PairGran *const pair = static_cast<PairGran *>(force->pair_match("gran", 0))) found = spring_of(pair);
  for (int k = 0; k < modify->nfix && found.empty(); k++)
    if (FixWallGran *const wall = dynamic_cast<FixWallGran *>(modify->fix[k])) found = spring_of(wall);
  return found;
}

// Nothing is known of the steps before: the velocities that the forces saw are those that there are.
void FixNVEEllipsoid::forget()
{
  for (int i = 0; i < atom->nlocal; i++) FixNVEEllipsoid::set_arrays(i);
  time_step_before_ = 0.0;
}

EllgranMotion FixNVEEllipsoid::motion(int group_mask) const
{
  EllgranMotion motion = ELLGRAN_INIT(EllgranMotion);
  motion.count = igroup == atom->firstgroup && group_mask == groupbit ? atom->nfirst : atom->nlocal;
  if (motion.count == 0) return motion;
  motion.positions = atom->x[0];
  motion.velocities = atom->v[0];
  motion.angular_momenta = atom->angmom[0];
  motion.forces = atom->f[0];
  motion.torques = atom->torque[0];
  motion.masses = atom->rmass;
  motion.semi_axes = atom->shape[0];
  motion.semi_axes_stride = 3 * sizeof(double);
  motion.quaternions = atom->quaternion[0];
  motion.quaternions_stride = 4 * sizeof(double);
  motion.masks = atom->mask;
  motion.group_mask = group_mask;
  motion.identifiers = atom->tag;
  motion.identifier_bytes = sizeof(atom->tag[0]);
  if (keeper_) {
    motion.velocity_changes = keeper_->changes_[0];
    motion.loads_before = keeper_->loads_before_[0];
    motion.time_step_before = time_step_before_;
  }
  return motion;
}

void FixNVEEllipsoid::check(int status) const
{
  if (status == ELLGRAN_SUCCESS) return;
  char message[600];
  snprintf(message, sizeof(message), "fix %s nve/ellipsoid: %s", id, ellgran_last_error());
  error->one(FLERR, message);
}

// LIGGGHTS computes forces anew when a run starts. They must be those with which the last run ended: of the velocities that these saw, on
// ghosts too. What reads velocities when all is set up shall see those of the step.
void FixNVEEllipsoid::setup_pre_exchange()
{
  // write_restart calls this too, and no run begins
  if (keeper_ && update->setupflag) keeper_->swap(1.0);
}

void FixNVEEllipsoid::setup_pre_force(int)
{
  if (!keeper_) return;
  // 'run ... pre no' exchanges no particles: ghosts still have the velocities of the last forces
  keeper_->swap(1.0);
  pre_force(0);
}

void FixNVEEllipsoid::setup(int)
{
  if (keeper_ && all_of_step(modify).back() == this) keeper_->swap(-1.0);
}

// Of all particles: changes are 0 where no fix of this style moves them.
void FixNVEEllipsoid::swap(double sign)
{
  if (swapped_ == (sign > 0.0)) return;
  swapped_ = !swapped_;
  for (int i = 0; i < atom->nlocal; i++)
    for (int k = 0; k < 3; k++) {
      atom->v[i][k] += sign * changes_[i][k];
      atom->angmom[i][k] += sign * changes_[i][3 + k];
    }
  EllgranMotion grains = motion(step_bits_);
  if (grains.count > 0) check(ellgran_angular_velocities(workspace_, &grains, atom->omega[0]));
}

// LIGGGHTS keeps angular velocities beside angular momenta: contact models and outputs read them.
void FixNVEEllipsoid::initial_integrate(int)
{
  if (keeper_) keeper_->extrapolated_ = true;
  const EllgranMotion grains = motion(groupbit);
  if (grains.count > 0) {
    check(ellgran_start_step(workspace_, &grains, update->dt));
    check(ellgran_angular_velocities(workspace_, &grains, atom->omega[0]));
  }
  time_step_before_ = update->dt;
}

void FixNVEEllipsoid::final_integrate()
{
  const EllgranMotion grains = motion(groupbit);
  if (grains.count > 0) {
    check(ellgran_finish_step(workspace_, &grains, update->dt));
    check(ellgran_angular_velocities(workspace_, &grains, atom->omega[0]));
  }
  if (keeper_) keeper_->extrapolated_ = false;
}

void FixNVEEllipsoid::pre_force(int)
{
  if (this != keeper_ || !ghosts_wanted_) return;
  find_motion_changes();
  comm->forward_comm_fix(this);
}

// Angular velocities are linear in angular momenta. Piece by piece, since what a piece takes stays in the nearest cache, and all at once it does not.
void FixNVEEllipsoid::find_motion_changes()
{
  const EllgranMotion grains = motion(step_bits_);
  if (grains.count == 0) return;
  const size_t PIECE = 128, count = atom->nlocal;
  double momenta[3 * PIECE], spins[3 * PIECE];
  for (size_t first = 0; first < count; first += PIECE) {
    const size_t here = std::min(PIECE, count - first);
    for (size_t i = 0; i < here; i++)
      for (int k = 0; k < 3; k++) momenta[3 * i + k] = changes_[first + i][3 + k];
    // of those that this fix does not move
    std::fill_n(spins, 3 * here, 0.0);
    if (first < grains.count) {
      EllgranMotion piece = grains;
      piece.count = std::min(PIECE, grains.count - first);
      piece.angular_momenta = momenta;
      piece.masses += first;
      piece.semi_axes += 3 * first;
      piece.quaternions += 4 * first;
      piece.masks += first;
      piece.identifiers = atom->tag + first;
      check(ellgran_angular_velocities(workspace_, &piece, spins));
    }
    for (size_t i = 0; i < here; i++)
      for (int k = 0; k < 3; k++) {
        motion_changes_[first + i][k] = changes_[first + i][k];
        motion_changes_[first + i][3 + k] = spins[3 * i + k];
      }
  }
}

void FixNVEEllipsoid::lend_velocities(LAMMPS *lmp, EllgranParticles &particles)
{
  const std::vector<FixNVEEllipsoid *> all = all_of_step(lmp->modify);
  FixNVEEllipsoid *const keeper = all.empty() ? NULL : all.front()->keeper_;
  if (!keeper || particles.count == 0) return;
  particles.velocity_changes = keeper->motion_changes_[0];
  if (keeper->extrapolated_ || keeper->swapped_) return;
  // velocities are as integrated: those of the last forces
  EllgranMotion grains = keeper->motion(keeper->step_bits_);
  std::vector<double> &velocities = keeper->velocities_, &momenta = keeper->momenta_, &spins = keeper->angular_velocities_;
  velocities.assign(particles.velocities, particles.velocities + 3 * particles.count);
  spins.assign(particles.angular_velocities, particles.angular_velocities + 3 * particles.count);
  momenta.resize(3 * particles.owned_count);
  const Atom *const atom = lmp->atom;
  for (size_t i = 0; i < particles.owned_count; i++)
    for (int k = 0; k < 3; k++) {
      velocities[3 * i + k] += keeper->changes_[i][k];
      momenta[3 * i + k] = atom->angmom[i][k] + keeper->changes_[i][3 + k];
    }
  if (grains.count > 0) {
    grains.angular_momenta = &momenta[0];
    keeper->check(ellgran_angular_velocities(keeper->workspace_, &grains, &spins[0]));
  }
  particles.velocities = &velocities[0];
  particles.angular_velocities = &spins[0];
}

double FixNVEEllipsoid::memory_usage()
{
  const double kept = word_ == HALF ? 0.0 : static_cast<double>(STATE + CHANGES) * atom->nmax;
  return (kept + velocities_.capacity() + momenta_.capacity() + angular_velocities_.capacity()) * sizeof(double);
}

void FixNVEEllipsoid::grow_arrays(int count)
{
  memory->grow(changes_, count, CHANGES, "nve/ellipsoid:changes");
  memory->grow(loads_before_, count, LOADS, "nve/ellipsoid:loads_before");
  memory->grow(motion_changes_, count, CHANGES, "nve/ellipsoid:motion_changes");
  // of ghosts that nobody has told of yet
  if (count > 0) memset(motion_changes_[0], 0, static_cast<size_t>(count) * CHANGES * sizeof(double));
}

void FixNVEEllipsoid::copy_arrays(int from, int to, int)
{
  memcpy(changes_[to], changes_[from], CHANGES * sizeof(double));
  memcpy(loads_before_[to], loads_before_[from], LOADS * sizeof(double));
}

void FixNVEEllipsoid::set_arrays(int particle)
{
  memset(changes_[particle], 0, CHANGES * sizeof(double));
  memset(loads_before_[particle], 0, LOADS * sizeof(double));
  loads_before_[particle][0] = HUGE_VAL;  // not known
}

int FixNVEEllipsoid::pack_exchange(int particle, double *buffer)
{
  memcpy(buffer, changes_[particle], CHANGES * sizeof(double));
  memcpy(buffer + CHANGES, loads_before_[particle], LOADS * sizeof(double));
  return STATE;
}

int FixNVEEllipsoid::unpack_exchange(int particle, double *buffer)
{
  memcpy(changes_[particle], buffer, CHANGES * sizeof(double));
  memcpy(loads_before_[particle], buffer + CHANGES, LOADS * sizeof(double));
  return STATE;
}

// returns the values of one particle
int FixNVEEllipsoid::pack_comm(int count, int *particles, double *buffer, int, int *)
{
  for (int k = 0; k < count; k++) memcpy(buffer + CHANGES * k, motion_changes_[particles[k]], CHANGES * sizeof(double));
  return CHANGES;
}

void FixNVEEllipsoid::unpack_comm(int count, int first, double *buffer)
{
  for (int k = 0; k < count; k++) memcpy(motion_changes_[first + k], buffer + CHANGES * k, CHANGES * sizeof(double));
}

int FixNVEEllipsoid::size_restart(int)
{
  return 1 + STATE;
}

int FixNVEEllipsoid::maxsize_restart()
{
  return 1 + STATE;
}

int FixNVEEllipsoid::pack_restart(int particle, double *buffer)
{
  buffer[0] = 1 + STATE;
  return 1 + pack_exchange(particle, buffer + 1);
}

void FixNVEEllipsoid::unpack_restart(int particle, int place)
{
  // 'velocities half' under the ID of a fix of the file that kept them
  if (word_ == HALF) return;
  double *extra = atom->extra[particle];
  for (int k = 0; k < place; k++) extra += static_cast<int>(*extra);
  // not refuse(), which waits for all ranks: those without grains do not come here
  if (static_cast<int>(extra[0]) != 1 + STATE)
    error->one(FLERR, "fix nve/ellipsoid: the restart file is damaged: it has other values per particle than its format");
  unpack_exchange(particle, extra + 1);
}

void FixNVEEllipsoid::write_restart(FILE *fp)
{
  if (comm->me != 0) return;
  const double values[2] = {FORMAT, time_step_before_};
  const int size = sizeof(values);
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(values, sizeof(double), 2, fp);
}

void FixNVEEllipsoid::restart(char *state)
{
  double values[2];
  memcpy(values, state, sizeof(values));
  if (values[0] > FORMAT) {
    char message[400];
    snprintf(message, sizeof(message),
             "the restart file has format version %g of this fix. This is ellgran %s, which reads version %g: use the ellgran that wrote "
             "the file, or give the fix another ID",
             values[0], ellgran_version(), FORMAT);
    refuse(message);
  }
  time_step_before_ = values[1];
}
