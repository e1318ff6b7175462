// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_step_velocity.h"

#include "ellgran_substitute.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "memory.h"
#include "modify.h"
#include "neighbor.h"
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;
using namespace FixConst;

namespace {

bool prescribes_motion(const Fix *fix)
{
  return utils::strmatch(fix->style, "^move");
}

// The components of the box, in the order of `domain->h`.
constexpr int EDGES[6] = {Fix::BOX_CHANGE_X,  Fix::BOX_CHANGE_Y,  Fix::BOX_CHANGE_Z,
                          Fix::BOX_CHANGE_YZ, Fix::BOX_CHANGE_XZ, Fix::BOX_CHANGE_XY};
constexpr int ALL_EDGES = Fix::BOX_CHANGE_SIZE | Fix::BOX_CHANGE_SHAPE;

constexpr int DIFFERENCES = 6, STARTS = 10, EXCHANGED = DIFFERENCES + 3;

double square(const double *v)
{
  return v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
}

}    // namespace

FixEllgranStepVelocity::FixEllgranStepVelocity(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), atoms(lmp, "Fix move or rigid"), moved_bits(0), rigid_bits(0), moving_edges(0), edges{}, edge_rates{}, difference(nullptr), start(nullptr)
{
  nevery = 1;
  create_attribute = 1;
  comm_forward = DIFFERENCES;
  maxexchange = EXCHANGED;
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
    if (fix->rigid_flag || prescribes_motion(fix) || (fix->box_change & ALL_EDGES)) return true;
  return false;
}

int FixEllgranStepVelocity::setmask()
{
  return POST_INTEGRATE | POST_FORCE | END_OF_STEP;
}

void FixEllgranStepVelocity::init()
{
  moved_bits = rigid_bits = moving_edges = 0;
  for (const auto *fix : modify->get_fix_list()) {
    if (fix->rigid_flag) rigid_bits |= fix->groupbit;
    if (prescribes_motion(fix)) moved_bits |= fix->groupbit;
    // With 'remap v' velocities alone change, where an atom crosses a boundary.
    if (domain->deform_vremap && utils::strmatch(fix->style, "^deform")) continue;
    moving_edges |= fix->box_change & ALL_EDGES;
  }
}

void FixEllgranStepVelocity::setup(int)
{
  post_force(0);
  end_of_step();
}

void FixEllgranStepVelocity::check(int32_t status) const
{
  if (status != ELLGRAN_SUCCESS) error->one(FLERR, "Fix move or rigid: {}", ellgran_last_error());
}

void FixEllgranStepVelocity::store_start(int i)
{
  if (!moving_edges) std::copy_n(atom->x[i], 3, start[i]);
  std::copy_n(atom->v[i], 3, start[i] + 3);
  if (atom->ellipsoid[i] >= 0) std::copy_n(atoms.body(i, atom->rmass[i]).quaternion, 4, start[i] + 6);
}

/* A fix may move the atoms with the box at the end of the step, before or after this one has its turn there. */

void FixEllgranStepVelocity::post_force(int)
{
  if (!moving_edges) return;
  std::copy_n(domain->h, 6, edges);
  for (int i = 0; i < atom->nlocal; i++) std::copy_n(atom->x[i], 3, start[i]);
}

void FixEllgranStepVelocity::end_of_step()
{
  if ((moved_bits | rigid_bits) == 0) return;
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->mask[i] & (moved_bits | rigid_bits)) store_start(i);
}

void FixEllgranStepVelocity::post_integrate()
{
  if ((moved_bits | rigid_bits | moving_edges) == 0) return;
  const double time = update->dt;
  // With 'timestep 0' a box may still change from step to step: as with 'change_box' no velocity is found of that.
  if (time == 0.0) {
    std::fill_n(edge_rates, 6, 0.0);
    std::copy_n(domain->h, 6, edges);
    for (int i = 0; i < atom->nlocal; i++) {
      std::fill_n(difference[i], DIFFERENCES, 0.0);
      std::copy_n(atom->x[i], 3, start[i]);
    }
    return;
  }
  for (int k = 0; k < 6; k++) edge_rates[k] = (moving_edges & EDGES[k]) ? (domain->h[k] - edges[k]) / time : 0.0;
  std::copy_n(domain->h, 6, edges);
  for (int i = 0; i < atom->nlocal; i++) {
    double *found = difference[i];
    std::fill_n(found, DIFFERENCES, 0.0);
    const int mask = atom->mask[i];
    if (!(mask & (moved_bits | rigid_bits))) {
      for (int k = 0; moving_edges && k < 3; k++) found[k] = (atom->x[i][k] - start[i][k]) / time - atom->v[i][k];
      if (moving_edges) std::copy_n(atom->x[i], 3, start[i]);
      continue;
    }
    if (atom->ellipsoid[i] < 0) continue;
    const bool rigid = mask & rigid_bits;

    double change[3];
    for (int k = 0; k < 3; k++) {
      found[k] = (atom->x[i][k] - start[i][k]) / time - atom->v[i][k];
      change[k] = atom->v[i][k] - start[i][3 + k];
    }
    if (moving_edges) std::copy_n(atom->x[i], 3, start[i]);
    // A motion may be given with a velocity that is not its own: a belt that stays and conveys. The velocity
    // over the step then does not lie between those at its ends.
    if (!rigid && square(found) > square(change)) std::fill_n(found, 3, 0.0);

    // Likewise a roller that spins and does not turn.
    const EllgranBody body = atoms.body(i, atom->rmass[i]);
    if (!rigid && std::equal(body.quaternion, body.quaternion + 4, start[i] + 6)) continue;
    double omega[3];
    check(ellgran_mean_angular_velocity(start[i] + 6, body.quaternion, time, omega));
    for (int k = 0; k < 3; k++) omega[k] -= body.angular_velocity[k];
    check(ellgran_angular_momentum(&body, omega, found + 3));
  }
}

/* A tilted box may be flipped when atoms change processors: other vectors of the same lattice are its edges then. */

void FixEllgranStepVelocity::follow_flip()
{
  const double *const h = domain->h;
  const double along_y = std::round((h[3] - edges[3]) / h[1]);
  const double along_x_of_z = std::round((h[4] - edges[4] - along_y * edges[5]) / h[0]);
  const double along_x_of_y = std::round((h[5] - edges[5]) / h[0]);
  if (along_y == 0.0 && along_x_of_z == 0.0 && along_x_of_y == 0.0) return;
  edge_rates[3] += along_y * edge_rates[1];
  edge_rates[4] += along_y * edge_rates[5] + along_x_of_z * edge_rates[0];
  edge_rates[5] += along_x_of_y * edge_rates[0];
  std::copy_n(h, 6, edges);
}

/* An atom that was found outside of the box when atoms changed processors became another image of itself, which came with the
   velocity of the edges between them. */

void FixEllgranStepVelocity::follow_images()
{
  const double *const h = domain->h, *const rates = edge_rates;
  for (int i = 0; i < atom->nlocal; i++) {
    double gone[3];
    for (int k = 0; k < 3; k++) gone[k] = start[i][k] - atom->x[i][k];
    const double along_z = std::round(gone[2] / h[2]);
    const double along_y = std::round((gone[1] - along_z * h[3]) / h[1]);
    const double along_x = std::round((gone[0] - along_z * h[4] - along_y * h[5]) / h[0]);
    if (along_x == 0.0 && along_y == 0.0 && along_z == 0.0) continue;
    difference[i][0] -= along_x * rates[0] + along_y * rates[5] + along_z * rates[4];
    difference[i][1] -= along_y * rates[1] + along_z * rates[3];
    difference[i][2] -= along_z * rates[2];
    std::copy_n(atom->x[i], 3, start[i]);
  }
}

void FixEllgranStepVelocity::replace_velocities(EllgranParticles &particles, bool with_ghosts)
{
  // When a run starts forces are computed anew from the velocities of that instant; no step led there.
  if ((moved_bits | rigid_bits | moving_edges) == 0 || update->setupflag || update->whichflag == 2) return;
  if (moving_edges && neighbor->ago == 0) {
    follow_flip();
    follow_images();
  }
  if (with_ghosts) comm->forward_comm(this);
  const int count = atom->nlocal + (with_ghosts ? atom->nghost : 0);
  velocities.resize(3 * static_cast<std::size_t>(atom->nmax));
  angular_momenta.resize(velocities.size());
  for (int i = 0; i < count; i++)
    for (int k = 0; k < 3; k++) {
      velocities[3 * i + k] = atom->v[i][k] + difference[i][k];
      angular_momenta[3 * i + k] = atom->angmom[i][k] + difference[i][3 + k];
    }
  if (particles.velocity_changes) keep_velocities_of_step(particles, count);
  particles.velocities = velocities.data();
  particles.angular_momenta = angular_momenta.data();
}

/* `fix move` has the velocities of the step in `v`. Those of a rigid body are known at the half step alone. */

void FixEllgranStepVelocity::keep_velocities_of_step(EllgranParticles &particles, int count)
{
  changes.assign(particles.velocity_changes, particles.velocity_changes + DIFFERENCES * static_cast<std::size_t>(count));
  for (int i = 0; i < count; i++) {
    if (!(atom->mask[i] & moved_bits) || (atom->mask[i] & rigid_bits)) continue;
    for (int k = 0; k < 3; k++) {
      velocities[3 * i + k] = atom->v[i][k];
      angular_momenta[3 * i + k] = atom->angmom[i][k];
    }
    for (int k = 0; k < DIFFERENCES; k++) changes[DIFFERENCES * static_cast<std::size_t>(i) + k] = -difference[i][k];
  }
  particles.velocity_changes = changes.data();
}

double FixEllgranStepVelocity::memory_usage()
{
  const double counts = static_cast<double>(DIFFERENCES + STARTS) * atom->nmax +
      static_cast<double>(velocities.capacity() + angular_momenta.capacity() + changes.capacity());
  return counts * sizeof(double);
}

void FixEllgranStepVelocity::grow_arrays(int nmax)
{
  memory->grow(difference, nmax, DIFFERENCES, "ellgran_step_velocity:difference");
  memory->grow(start, nmax, STARTS, "ellgran_step_velocity:start");
}

void FixEllgranStepVelocity::copy_arrays(int i, int j, int)
{
  std::copy_n(difference[i], DIFFERENCES, difference[j]);
  std::copy_n(start[i], STARTS, start[j]);
}

void FixEllgranStepVelocity::set_arrays(int i)
{
  std::fill_n(difference[i], DIFFERENCES, 0.0);
  std::copy_n(atom->x[i], 3, start[i]);
}

int FixEllgranStepVelocity::pack_exchange(int i, double *buffer)
{
  std::copy_n(difference[i], DIFFERENCES, buffer);
  std::copy_n(start[i], EXCHANGED - DIFFERENCES, buffer + DIFFERENCES);
  return EXCHANGED;
}

int FixEllgranStepVelocity::unpack_exchange(int i, double *buffer)
{
  std::copy_n(buffer, DIFFERENCES, difference[i]);
  std::copy_n(buffer + DIFFERENCES, EXCHANGED - DIFFERENCES, start[i]);
  return EXCHANGED;
}

/* An image has in addition the velocity of the edges that lie between it and the atom: `pbc` counts them, in the order of
   `domain->h`. LAMMPS hands out images of images in turn, so that all boundaries add up. */

int FixEllgranStepVelocity::pack_forward_comm(int n, int *indices, double *buffer, int pbc_flag, int *pbc)
{
  double across[3] = {0.0, 0.0, 0.0};
  if (pbc_flag) {
    across[0] = pbc[0] * edge_rates[0] + pbc[5] * edge_rates[5] + pbc[4] * edge_rates[4];
    across[1] = pbc[1] * edge_rates[1] + pbc[3] * edge_rates[3];
    across[2] = pbc[2] * edge_rates[2];
  }
  for (int k = 0; k < n; k++) {
    double *const one = buffer + DIFFERENCES * static_cast<std::size_t>(k);
    std::copy_n(difference[indices[k]], DIFFERENCES, one);
    for (int c = 0; c < 3; c++) one[c] += across[c];
  }
  return DIFFERENCES * n;
}

void FixEllgranStepVelocity::unpack_forward_comm(int n, int first, double *buffer)
{
  for (int k = 0; k < n; k++)
    std::copy_n(buffer + DIFFERENCES * k, DIFFERENCES, difference[first + k]);
}

void FixEllgranStepVelocity::set_molecule(int, tagint, int, double *, double *, double *)
{
  error->all(FLERR, "Molecule update not implemented for fix {}", style);
}

FixEllgranStepVelocity *LAMMPS_NS::place_step_velocity(Modify *modify, FixEllgranStepVelocity *now, const std::string &prefix,
                                                       std::string &id)
{
  if (now && !modify->get_fix_by_id(id)) now = nullptr;
  bool is_before = false, changes_after = false;
  for (const auto *fix : modify->get_fix_list()) {
    if (is_before && (fix->box_change & ALL_EDGES)) changes_after = true;
    if (fix == now) is_before = true;
  }
  if (changes_after) {
    modify->delete_fix(id);
    now = nullptr;
  }
  if (now || !FixEllgranStepVelocity::needed(modify)) return now;
  id = prefix;
  for (int number = 2; modify->get_fix_by_id(id); number++) id = prefix + std::to_string(number);
  const SubstituteFix<FixEllgranStepVelocity> substitute(modify, "DUMMY");
  return static_cast<FixEllgranStepVelocity *>(modify->add_fix(id + " all DUMMY", 0));
}
