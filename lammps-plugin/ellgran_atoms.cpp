// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_atoms.h"

#include "atom.h"
#include "atom_vec_ellipsoid.h"
#include "atom_vec_hybrid.h"
#include "error.h"
#include "force.h"
#include "math_extra.h"
#include "modify.h"
#include "update.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

using namespace LAMMPS_NS;

namespace {

// Since 30 Mar 2026 LAMMPS keeps superellipsoids in an array of their own, with wider entries.
// The templates let one source serve the releases before and after.

template <class Vec, class = void> struct HasSuper : std::false_type {};
template <class Vec>
struct HasSuper<Vec, std::void_t<decltype(std::declval<Vec &>().bonus_super)>> : std::true_type {};

template <class AtomClass, class Vec> bool uses_super(const AtomClass *atom, const Vec *)
{
  if constexpr (HasSuper<Vec>::value)
    return atom->superellipsoid_flag != 0;
  else
    return false;
}

template <class Entry> const double *exponents_of(const Entry *entry)
{
  return entry->block;
}

template <class Vec>
void super_arrays(const Vec *vec, const double *&semi_axes, const double *&quaternions,
                  const double *&exponents, std::size_t &stride)
{
  if constexpr (HasSuper<Vec>::value) {
    const auto *entries = vec->bonus_super;
    if (entries) {
      semi_axes = entries->shape;
      quaternions = entries->quat;
      exponents = exponents_of(entries);
    }
    stride = sizeof(*entries);
  }
}

const double *entry(const double *first, std::size_t stride, int index)
{
  return reinterpret_cast<const double *>(reinterpret_cast<const char *>(first) + stride * index);
}

// Not Atom::style_match(): its signature differs between releases, and a plugin for another release
// must load, so that it can say what is wrong.
const AtomVecEllipsoid *ellipsoid_style(AtomVec *avec)
{
  if (const auto *vec = dynamic_cast<AtomVecEllipsoid *>(avec)) return vec;
  if (const auto *hybrid = dynamic_cast<AtomVecHybrid *>(avec))
    for (int k = 0; k < hybrid->nstyles; k++)
      if (const auto *vec = dynamic_cast<AtomVecEllipsoid *>(hybrid->styles[k])) return vec;
  return nullptr;
}

// Of so many atoms one may have its shape far from that of the atom before it: the few that have come or gone since the last sorting.
constexpr int TOLERABLE_JUMPS = 8;

// Puts the entries of the owned atoms in the order of these, where neighbours in one array are no neighbours in the other.
template <class Entry> void sort_entries(Entry *entries, int *index_of_atom, int atoms)
{
  int jumps = 0, before = 0;
  for (int i = 0; i < atoms; i++) {
    if (index_of_atom[i] < 0) continue;
    if (std::abs(index_of_atom[i] - before) > 1) jumps++;
    before = index_of_atom[i];
  }
  if (jumps <= atoms / TOLERABLE_JUMPS) return;
  int place = 0;
  for (int i = 0; i < atoms; i++) {
    const int index = index_of_atom[i];
    if (index < 0) continue;
    if (index != place) {
      index_of_atom[entries[place].ilocal] = index;
      index_of_atom[i] = place;
      std::swap(entries[place], entries[index]);
    }
    place++;
  }
}

template <class Vec> void sort_all_entries(Vec *vec, bool super, int *index_of_atom, int atoms)
{
  if constexpr (HasSuper<Vec>::value)
    if (super) return sort_entries(vec->bonus_super, index_of_atom, atoms);
  sort_entries(vec->bonus, index_of_atom, atoms);
}

// Densities of two grains of one scene that differ by this factor are a mistake.
constexpr double IMPLAUSIBLE_RATIO = 1.0e4;

// The greatest density that is no mistake: 50 times that of osmium, since steps are lengthened by heavier grains. Infinite
// in systems of units of which nothing is known.
double greatest_density(const char *units)
{
  if (std::strcmp(units, "si") == 0) return 1.0e6;
  if (std::strcmp(units, "cgs") == 0 || std::strcmp(units, "micro") == 0) return 1.0e3;
  return std::numeric_limits<double>::infinity();
}

// Pointer to the first value of a per-atom array; LAMMPS may not have allocated it yet.
double *rows(double **array)
{
  return array ? array[0] : nullptr;
}

}    // namespace

EllgranAtoms::EllgranAtoms(LAMMPS *lmp, const std::string &caller_name) :
    Pointers(lmp), caller(caller_name)
{
}

bool EllgranAtoms::has_enclosing_radius() const
{
  const auto *vec = ellipsoid_style(atom->avec);
  return vec && uses_super(atom, vec) && atom->radius_flag;
}

/* What may write shapes in a run: `fix set`, and whatever runs a user's own code. */

bool EllgranAtoms::shapes_may_change() const
{
  for (const char *style : {"^set$", "^python", "^external"})
    if (!modify->get_fix_by_style(style).empty()) return true;
  return false;
}

EllgranAtoms::Shapes EllgranAtoms::shapes() const
{
  Shapes found{nullptr, nullptr, nullptr, sizeof(AtomVecEllipsoid::Bonus)};
  const auto *vec = ellipsoid_style(atom->avec);
  if (!vec) return found;
  if (uses_super(atom, vec)) {
    super_arrays(vec, found.semi_axes, found.quaternions, found.exponents, found.stride);
  } else if (vec->bonus) {
    found.semi_axes = vec->bonus->shape;
    found.quaternions = vec->bonus->quat;
  }
  return found;
}

const double *EllgranAtoms::semi_axes(const Shapes &found, int i) const
{
  const int index = atom->ellipsoid[i];
  return (index < 0) ? nullptr : entry(found.semi_axes, found.stride, index);
}

void EllgranAtoms::require_atom_style() const
{
  const char *in_use = atom->atom_style ? atom->atom_style : "none";
  if (!atom->ellipsoid_flag || !ellipsoid_style(atom->avec))
    error->all(FLERR,
               "{} requires ellipsoids, but the atom style is '{}': "
               "use 'atom_style ellipsoid' and give every atom a shape",
               caller, in_use);
  if (!atom->angmom_flag || !atom->torque_flag || !atom->rmass_flag)
    error->all(FLERR,
               "{} requires per-atom angular momentum, torque and mass, which atom style '{}' does "
               "not have: use 'atom_style ellipsoid'",
               caller, in_use);
  if (!atom->tag_enable)
    error->all(FLERR, "{} requires atom IDs: remove 'atom_modify id no'", caller);
  if (force->ftm2v != 1.0)
    error->all(FLERR,
               "{}: in units {} mass times acceleration is not a force, as contact laws need: use units si, cgs, "
               "micro, nano or lj",
               caller, update->unit_style);
}

void EllgranAtoms::require_shapes(int group_bit) const
{
  const Shapes found = shapes();
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & group_bit)) continue;
    const auto id = static_cast<long long>(atom->tag[i]);
    const int type = atom->type[i];
    const double *axes = semi_axes(found, i);
    if (!axes)
      error->one(FLERR,
                 "{}: particle {} of type {} is not an ellipsoid: give it a shape in the Ellipsoids "
                 "section of the data file or with 'set type {} shape Dx Dy Dz'",
                 caller, id, type, type);
    for (int k = 0; k < 3; k++)
      if (!std::isfinite(axes[k]) || axes[k] <= 0.0)
        error->one(FLERR,
                   "{}: particle {} of type {} has semi-axes {} {} {}: each must be a finite "
                   "positive length",
                   caller, id, type, axes[0], axes[1], axes[2]);
    if (found.exponents) {
      const double *block = entry(found.exponents, found.stride, atom->ellipsoid[i]);
      if (block[0] != 2.0 || block[1] != 2.0)
        error->one(FLERR,
                   "{}: particle {} of type {} is a superellipsoid with block {} {}: only "
                   "ellipsoids, block 2 2, are supported",
                   caller, id, type, block[0], block[1]);
    }
    if (!std::isfinite(atom->rmass[i]) || atom->rmass[i] <= 0.0)
      error->one(FLERR, "{}: particle {} of type {} has mass {}: it must be finite and positive",
                 caller, id, type, atom->rmass[i]);
  }
}

std::vector<EllgranBody> EllgranAtoms::smallest_grains() const
{
  struct VolumeOnRank {
    double volume;
    int rank;
  };
  // Three semi-axes and the mass of a type.
  constexpr int WIDTH = 4;

  const Shapes found = shapes();
  const int count = atom->ntypes + 1;
  int me = 0;
  MPI_Comm_rank(world, &me);
  std::vector<VolumeOnRank> mine(count, {std::numeric_limits<double>::infinity(), me}), least(count);
  std::vector<int> index(count, -1);
  for (int i = 0; i < atom->nlocal; i++) {
    const double *axes = semi_axes(found, i);
    if (!axes) continue;
    const double volume = axes[0] * axes[1] * axes[2];
    const int type = atom->type[i];
    if (volume < mine[type].volume) {
      mine[type].volume = volume;
      index[type] = i;
    }
  }
  MPI_Allreduce(mine.data(), least.data(), count, MPI_DOUBLE_INT, MPI_MINLOC, world);

  std::vector<double> values(static_cast<std::size_t>(count) * WIDTH, 0.0);
  for (int type = 1; type < count; type++)
    if (least[type].rank == me && index[type] >= 0) {
      double *row = &values[static_cast<std::size_t>(type) * WIDTH];
      std::copy_n(semi_axes(found, index[type]), 3, row);
      std::sort(row, row + 3, [](double a, double b) { return a > b; });
      row[3] = atom->rmass[index[type]];
    }
  MPI_Allreduce(MPI_IN_PLACE, values.data(), count * WIDTH, MPI_DOUBLE, MPI_SUM, world);

  std::vector<EllgranBody> grains(count, ELLGRAN_INIT(EllgranBody));
  for (int type = 1; type < count; type++) {
    const double *row = &values[static_cast<std::size_t>(type) * WIDTH];
    EllgranBody &grain = grains[type];
    grain.quaternion[0] = 1.0;
    std::copy_n(row, 3, grain.semi_axes);
    grain.mass = row[3];
    grain.particle_type = type;
    grain.identifier = type;
  }
  return grains;
}

std::string EllgranAtoms::implausible_masses() const
{
  const Shapes found = shapes();
  const int count = atom->ntypes + 1;
  // Per type: least density, minus greatest density, and 1 as long as each mass is exactly 1.
  std::vector<double> least(count, std::numeric_limits<double>::infinity());
  std::vector<double> minus_greatest(count, std::numeric_limits<double>::infinity());
  std::vector<double> never_set(count, 1.0);
  for (int i = 0; i < atom->nlocal; i++) {
    const double *axes = semi_axes(found, i);
    if (!axes) continue;
    double volume = 0.0;
    if (ellgran_volumes(1, axes, &volume) != ELLGRAN_SUCCESS)
      error->one(FLERR, "{}: particle {} of type {}: {}", caller, static_cast<long long>(atom->tag[i]), atom->type[i],
                 ellgran_last_error());
    const double density = atom->rmass[i] / volume;
    const int type = atom->type[i];
    least[type] = std::min(least[type], density);
    minus_greatest[type] = std::min(minus_greatest[type], -density);
    if (atom->rmass[i] != 1.0) never_set[type] = 0.0;
  }
  for (auto *values : {&least, &minus_greatest, &never_set})
    MPI_Allreduce(MPI_IN_PLACE, values->data(), count, MPI_DOUBLE, MPI_MIN, world);

  const auto smallest = std::min_element(least.begin(), least.end());
  const auto largest = std::min_element(minus_greatest.begin(), minus_greatest.end());
  const auto least_type = static_cast<int>(smallest - least.begin());
  const auto greatest_type = static_cast<int>(largest - minus_greatest.begin());
  const double lowest = *smallest, highest = -*largest;
  const std::string cure =
      "give 'set type N shape Dx Dy Dz' first and 'set type N density ...' after it";
  for (int type = 1; type < count; type++)
    if (never_set[type] > 0.0 && std::isfinite(least[type]))
      return fmt::format("each grain of type {} has a mass of exactly 1 (densities {:.4g} to {:.4g}), which is "
                         "what LAMMPS gives to grains whose density was never set: {}",
                         type, least[type], -minus_greatest[type], cure);
  if (highest > greatest_density(update->unit_style))
    return fmt::format("a grain of type {} has a density of {:.4g} in units {}: a density that is set before the "
                       "shape becomes the mass: {}",
                       greatest_type, highest, update->unit_style, cure);
  if (highest > IMPLAUSIBLE_RATIO * lowest)
    return fmt::format("the densities of the grains differ by a factor of {:.4g}: {:.4g} for a grain of type {}, "
                       "{:.4g} for one of type {}: a density that is set before the shape becomes the mass: {}",
                       highest / lowest, lowest, least_type, highest, greatest_type, cure);
  return "";
}

std::vector<double> EllgranAtoms::largest_semi_axes() const
{
  std::vector<double> largest(atom->ntypes + 1, 0.0);
  const Shapes found = shapes();
  for (int i = 0; i < atom->nlocal; i++)
    if (const double *axes = semi_axes(found, i)) {
      double &of_type = largest[atom->type[i]];
      of_type = std::max({of_type, axes[0], axes[1], axes[2]});
    }
  return largest;
}

bool EllgranAtoms::all_spheres() const
{
  const Shapes found = shapes();
  for (int i = 0; i < atom->nlocal; i++) {
    const double *axes = semi_axes(found, i);
    if (!axes || axes[0] != axes[1] || axes[0] != axes[2]) return false;
  }
  return true;
}

void EllgranAtoms::pack_shapes(int n, const int *indices, double *buffer) const
{
  const Shapes found = shapes();
  for (int k = 0; k < n; k++, buffer += SHAPE_SIZE) {
    std::fill_n(buffer, SHAPE_SIZE, 0.0);
    const int i = indices[k];
    if (const double *axes = semi_axes(found, i)) std::copy_n(axes, 3, buffer);
    buffer[3] = atom->rmass[i];
    buffer[4] = atom->type[i];
  }
}

void EllgranAtoms::unpack_shapes(int n, int first, const double *buffer)
{
  const Shapes found = shapes();
  for (int i = first; i < first + n; i++, buffer += SHAPE_SIZE) {
    // LAMMPS hands the array out for writing; only the view of it here is constant.
    if (const double *axes = semi_axes(found, i)) std::copy_n(buffer, 3, const_cast<double *>(axes));
    atom->rmass[i] = buffer[3];
    atom->type[i] = static_cast<int>(buffer[4]);
  }
}

void EllgranAtoms::set_grain(int i, const double *axes, const double *quaternion, double mass)
{
  // The mass first: LAMMPS keeps moments of inertia of superellipsoids, and makes them of mass and shape.
  atom->rmass[i] = mass;
  auto *vec = const_cast<AtomVecEllipsoid *>(ellipsoid_style(atom->avec));
  vec->set_shape(i, axes[0], axes[1], axes[2]);
  const Shapes found = shapes();
  std::copy_n(quaternion, 4, const_cast<double *>(entry(found.quaternions, found.stride, atom->ellipsoid[i])));
  std::fill_n(atom->angmom[i], 3, 0.0);
}

/* LAMMPS counts them where it reads, sets or deletes some, not where a command inserts them or a boundary loses them. */

void EllgranAtoms::count_ellipsoids() const
{
  bigint owned = std::count_if(atom->ellipsoid, atom->ellipsoid + atom->nlocal, [](int index) { return index >= 0; });
  MPI_Allreduce(&owned, &atom->nellipsoids, 1, MPI_LMP_BIGINT, MPI_SUM, world);
}

/* Their velocities are those that have just led them here. */

void EllgranAtoms::require_finite(double viscous_dissipation, double tangential_work) const
{
  if (std::isfinite(viscous_dissipation) && std::isfinite(tangential_work)) return;
  const auto finite = [](const double *v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); };
  for (int i = 0; i < atom->nlocal; i++)
    for (const auto &[values, name] : {std::pair(atom->x[i], "position"), std::pair(atom->v[i], "velocity"),
                                       std::pair(atom->angmom[i], "angular momentum")})
      if (!finite(values))
        error->one(FLERR, "{}: particle {}: {} = ({} {} {}) is not finite", caller, atom->tag[i], name, values[0], values[1], values[2]);
  error->one(FLERR, "{}: the energy dissipated is not finite: the run has become unstable, often because the time step is too large",
             caller);
}

EllgranParticles EllgranAtoms::view() const
{
  const Shapes found = shapes();
  EllgranParticles particles = ELLGRAN_INIT(EllgranParticles);
  particles.owned_count = atom->nlocal;
  particles.count = static_cast<std::size_t>(atom->nlocal) + atom->nghost;
  particles.positions = rows(atom->x);
  particles.velocities = rows(atom->v);
  particles.angular_momenta = rows(atom->angmom);
  particles.masses = atom->rmass;
  particles.types = atom->type;
  particles.shape_indices = atom->ellipsoid;
  particles.semi_axes = found.semi_axes;
  particles.semi_axes_stride = found.stride;
  particles.quaternions = found.quaternions;
  particles.quaternions_stride = found.stride;
  particles.identifiers = atom->tag;
  particles.identifier_bytes = sizeof(tagint);
  particles.forces = rows(atom->f);
  particles.torques = rows(atom->torque);
  return particles;
}

void EllgranAtoms::sort_shapes() const
{
  auto *vec = const_cast<AtomVecEllipsoid *>(ellipsoid_style(atom->avec));
  if (vec && !lmp->kokkos) sort_all_entries(vec, uses_super(atom, vec), atom->ellipsoid, atom->nlocal);
}

EllgranBody EllgranAtoms::body(int i, double contact_mass, const double *velocity,
                               const double *angular_momentum) const
{
  if (!velocity) velocity = atom->v[i];
  if (!angular_momentum) angular_momentum = atom->angmom[i];
  const Shapes found = shapes();
  const double *axes = semi_axes(found, i);
  if (!axes)
    error->one(FLERR, "{}: particle {} of type {} is not an ellipsoid", caller,
               static_cast<long long>(atom->tag[i]), atom->type[i]);
  const double *quaternion = entry(found.quaternions, found.stride, atom->ellipsoid[i]);

  EllgranBody body = ELLGRAN_INIT(EllgranBody);
  for (int k = 0; k < 3; k++) {
    body.position[k] = atom->x[i][k];
    body.velocity[k] = velocity[k];
    body.semi_axes[k] = axes[k];
  }
  for (int k = 0; k < 4; k++) body.quaternion[k] = quaternion[k];
  body.mass = contact_mass;
  body.particle_type = atom->type[i];
  body.identifier = atom->tag[i];

  // LAMMPS keeps angular momentum; the principal moments are those of a solid ellipsoid, as in
  // fix nve/asphere.
  double moments[3];
  if (ellgran_moments_of_inertia(1, axes, &atom->rmass[i], moments) != ELLGRAN_SUCCESS)
    error->one(FLERR, "{}: particle {} of type {}: {}", caller, static_cast<long long>(atom->tag[i]), atom->type[i],
               ellgran_last_error());
  double to_world[4] = {quaternion[0], quaternion[1], quaternion[2], quaternion[3]};
  double momentum[3] = {angular_momentum[0], angular_momentum[1], angular_momentum[2]};
  MathExtra::mq_to_omega(momentum, to_world, moments, body.angular_velocity);
  return body;
}
