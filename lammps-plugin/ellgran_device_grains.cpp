// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_device_grains.h"

#include "atom_kokkos.h"
#include "atom_masks.h"
#include "atom_vec_ellipsoid_kokkos.h"
#include "error.h"
#include "neighbor.h"

#include <algorithm>
#include <limits>

using namespace LAMMPS_NS;

namespace {

// Pairs of the list with a wider gap than this share of the mean smallest semi-axis are looked at again only when a grain
// has moved by half of it.
constexpr double MARGIN = 0.05;

// Forces and torques that are not known, as in fix nve/ellipsoid.
constexpr double UNKNOWN = std::numeric_limits<double>::infinity();

using Policy = Kokkos::RangePolicy<LMPDeviceType>;

// Views that only grow: LAMMPS adds images with each list.
template <class View> void fit(View &view, const char *label, size_t count)
{
  if (view.extent(0) < count || !view.data())
    view = View(Kokkos::view_alloc(Kokkos::WithoutInitializing, std::string(label)), count + count / 8 + 1);
}

}    // namespace

EllgranDeviceGrains::EllgranDeviceGrains(LAMMPS *lmp, const std::string &caller_name) :
    Pointers(lmp), caller(caller_name), gpu(nullptr), scene(nullptr), of_step(false), changes_known(false), listed_count(-1), listed_owned(0), margin(0.0)
{
}

EllgranDeviceGrains::~EllgranDeviceGrains()
{
  ellgran_gpu_scene_free(scene);
  ellgran_gpu_free(gpu);
}

void EllgranDeviceGrains::check(int32_t status) const
{
  if (status != ELLGRAN_SUCCESS) error->one(FLERR, "{}: {}", caller, ellgran_last_error());
}

/* That of KOKKOS: what it starts before and after comes before and after. The tests' KOKKOS for the host has none. */

void *EllgranDeviceGrains::stream() const
{
#ifdef KOKKOS_ENABLE_CUDA
  return LMPDeviceType().cuda_stream();
#else
  return nullptr;
#endif
}

void EllgranDeviceGrains::set_laws(const EllgranLaws *laws)
{
  // The GPU of KOKKOS, whose context this thread has.
  if (!gpu) check(ellgran_gpu_open_current(&gpu));
  ellgran_gpu_scene_free(scene);
  scene = nullptr;
  listed_count = -1;
  check(ellgran_gpu_scene_new(gpu, laws, ELLGRAN_GPU_ANY_SHAPES, &scene));
}

/* Those of a run before, which were of the half step, tell nothing of the step before. */

void EllgranDeviceGrains::use_velocities_of_step(bool yes)
{
  if (yes != of_step) changes_known = false;
  of_step = yes;
}

EllgranGpuGrains EllgranDeviceGrains::grains() const
{
  auto *const atoms = static_cast<AtomKokkos *>(atom);
  EllgranGpuGrains grains = ELLGRAN_INIT(EllgranGpuGrains);
  grains.owned_count = listed_owned;
  grains.count = listed_count;
  grains.positions = atoms->k_x.view_device().data();
  grains.velocities = velocities.data();
  grains.angular_momenta = momenta.data();
  grains.velocity_changes = of_step ? changes.data() : nullptr;
  grains.masses = masses.data();
  grains.semi_axes = semi_axes.data();
  grains.quaternions = quaternions.data();
  grains.types = types.data();
  grains.identifiers = atoms->k_tag.view_device().data();
  return grains;
}

EllgranGpuMotion EllgranDeviceGrains::motion(double time_step_before) const
{
  auto *const atoms = static_cast<AtomKokkos *>(atom);
  EllgranGpuMotion motion = ELLGRAN_INIT(EllgranGpuMotion);
  motion.count = listed_owned;
  motion.positions = atoms->k_x.view_device().data();
  motion.velocities = velocities.data();
  motion.angular_momenta = momenta.data();
  motion.quaternions = quaternions.data();
  motion.semi_axes = semi_axes.data();
  motion.masses = masses.data();
  motion.loads = loads.data();
  if (of_step) {
    motion.velocity_changes = changes.data();
    motion.loads_before = loads_before.data();
    motion.time_step_before = time_step_before;
  }
  return motion;
}

/* LAMMPS has sorted its atoms, added or deleted some, and has other images. What is kept of each is carried over by its identifier. */

void EllgranDeviceGrains::follow_order()
{
  auto *const atoms = static_cast<AtomKokkos *>(atom);
  const int owned = atom->nlocal, count = owned + atom->nghost;
  const int before = changes_known ? listed_owned : 0;
  const auto tag = atoms->k_tag.view_device();
  const int old_size = static_cast<int>(places.extent(0));
  const auto old_places = places;

  if (of_step) {
    fit(other_changes, "ellgran:changes", count);
    fit(other_loads, "ellgran:loads_before", owned);
    const auto to_changes = other_changes, from_changes = changes;
    const auto to_loads = other_loads, from_loads = loads_before;
    Kokkos::parallel_for(
        Policy(0, owned), KOKKOS_LAMBDA(const int i) {
          const int id = tag(i);
          int from = (before > 0 && id < old_size) ? old_places(id) : -1;
          for (int k = 0; k < 6; k++) {
            to_changes(i, k) = (from >= 0) ? from_changes(from, k) : 0.0;
            to_loads(i, k) = (from >= 0) ? from_loads(from, k) : ((k == 0) ? UNKNOWN : 0.0);
          }
        });
    std::swap(changes, other_changes);
    std::swap(loads_before, other_loads);
    changes_known = true;
  }

  int largest = 0;
  Kokkos::parallel_reduce(
      Policy(0, owned), KOKKOS_LAMBDA(const int i, int &most) { most = (tag(i) > most) ? tag(i) : most; },
      Kokkos::Max<int>(largest));
  if (old_size < largest + 1)
    places = Integers(Kokkos::view_alloc(Kokkos::WithoutInitializing, std::string("ellgran:places")), static_cast<size_t>(largest) + 1 + largest / 8);
  Kokkos::deep_copy(LMPDeviceType(), places, -1);
  fit(owners, "ellgran:owners", count);
  const auto now = places;
  const auto of = owners;
  Kokkos::parallel_for(
      Policy(0, owned), KOKKOS_LAMBDA(const int i) {
        now(tag(i)) = i;
        of(i) = i;
      });
  Kokkos::parallel_for(
      Policy(owned, count), KOKKOS_LAMBDA(const int i) { of(i) = now(tag(i)); });
  listed_owned = owned;
  listed_count = count;
}

void EllgranDeviceGrains::take_shapes()
{
  auto *const atoms = static_cast<AtomKokkos *>(atom);
  auto *const style = dynamic_cast<AtomVecEllipsoidKokkos *>(atom->style_match("ellipsoid"));
  fit(semi_axes, "ellgran:semi_axes", listed_count);
  fit(masses, "ellgran:masses", listed_count);
  fit(types, "ellgran:types", listed_count);
  const auto bonus = style->k_bonus.view_device();
  const auto ellipsoid = atoms->k_ellipsoid.view_device();
  const auto rmass = atoms->k_rmass.view_device();
  const auto type = atoms->k_type.view_device();
  const auto to_axes = semi_axes;
  const auto to_masses = masses;
  const auto to_types = types;
  const auto of = owners;
  Kokkos::parallel_for(
      Policy(0, listed_count), KOKKOS_LAMBDA(const int i) {
        const int j = of(i);
        const double *const axes = bonus(ellipsoid(j)).shape;
        for (int k = 0; k < 3; k++) to_axes(i, k) = axes[k];
        to_masses(i) = rmass(j);
        to_types(i) = type(j);
      });
  double sum = 0.0;
  Kokkos::parallel_reduce(
      Policy(0, listed_owned),
      KOKKOS_LAMBDA(const int i, double &of_all) {
        double least = to_axes(i, 0);
        for (int k = 1; k < 3; k++) least = (to_axes(i, k) < least) ? to_axes(i, k) : least;
        of_all += least;
      },
      sum);
  margin = (listed_owned > 0) ? std::min(MARGIN * sum / listed_owned, neighbor->skin) : 0.0;
}

/* LAMMPS' rows have all the same room; those of ellgran follow one another. */

void EllgranDeviceGrains::take_rows(NeighListKokkos<LMPDeviceType> *list)
{
  const int owned = listed_owned;
  const auto counts = list->d_numneigh;
  const auto from = list->d_neighbors;
  fit(starts, "ellgran:starts", owned + 1);
  const auto first = starts;
  uint64_t total = 0;
  Kokkos::parallel_reduce(
      Policy(0, owned), KOKKOS_LAMBDA(const int i, uint64_t &of_all) { of_all += counts(i); }, total);
  if (total > std::numeric_limits<uint32_t>::max())
    error->one(FLERR, "{}: the neighbour list has {} entries, more than 2^32 - 1: use a shorter skin or fewer grains", caller, total);
  Kokkos::parallel_scan(
      Policy(0, owned + 1), KOKKOS_LAMBDA(const int i, uint32_t &sum, const bool last) {
        if (last) first(i) = sum;
        if (i < owned) sum += counts(i);
      });
  fit(neighbours, "ellgran:neighbours", total);
  const auto to = neighbours;
  Kokkos::parallel_for(
      Policy(0, owned), KOKKOS_LAMBDA(const int i) {
        const uint32_t begin = first(i);
        const int n = counts(i);
        for (int k = 0; k < n; k++) to(begin + k) = static_cast<uint32_t>(from(i, k) & NEIGHMASK);
      });
}

void EllgranDeviceGrains::take_list(NeighListKokkos<LMPDeviceType> *list)
{
  follow_order();
  take_shapes();
  take_state();
  take_rows(list);
  EllgranGpuList rows = ELLGRAN_INIT(EllgranGpuList);
  rows.starts = starts.data();
  rows.neighbours = neighbours.data();
  rows.margin = margin;
  const EllgranGpuGrains now = grains();
  check(ellgran_gpu_new_list(scene, &now, &rows, stream()));
}

void EllgranDeviceGrains::take_state()
{
  auto *const atoms = static_cast<AtomKokkos *>(atom);
  auto *const style = dynamic_cast<AtomVecEllipsoidKokkos *>(atom->style_match("ellipsoid"));
  fit(velocities, "ellgran:velocities", listed_count);
  fit(momenta, "ellgran:momenta", listed_count);
  fit(quaternions, "ellgran:quaternions", listed_count);
  const auto bonus = style->k_bonus.view_device();
  const auto ellipsoid = atoms->k_ellipsoid.view_device();
  const auto v = atoms->k_v.view_device();
  const auto angmom = atoms->k_angmom.view_device();
  const auto to_velocities = velocities;
  const auto to_momenta = momenta;
  const auto to_quaternions = quaternions;
  const auto of = owners;
  const auto change = changes;
  const int owned = listed_owned;
  const bool with_changes = of_step;
  Kokkos::parallel_for(
      Policy(0, listed_count), KOKKOS_LAMBDA(const int i) {
        const int j = of(i);
        for (int k = 0; k < 3; k++) {
          to_velocities(i, k) = v(j, k);
          to_momenta(i, k) = angmom(j, k);
        }
        const double *const quat = bonus(ellipsoid(j)).quat;
        for (int k = 0; k < 4; k++) to_quaternions(i, k) = quat[k];
        if (with_changes && i >= owned)
          for (int k = 0; k < 6; k++) change(i, k) = change(j, k);
      });
}

void EllgranDeviceGrains::add_forces(const EllgranStep &step)
{
  fit(loads, "ellgran:loads", listed_owned);
  const EllgranGpuGrains now = grains();
  check(ellgran_gpu_compute_pairs(scene, &now, &step, loads.data(), stream()));
  put_loads();
}

int32_t EllgranDeviceGrains::add_plane()
{
  int32_t number = -1;
  check(ellgran_gpu_add_plane(scene, stream(), &number));
  return number;
}

void EllgranDeviceGrains::add_plane_forces(const std::vector<PlaneNow> &planes, int32_t wall_type, const EllgranStep &step)
{
  require_listed();
  // Those of pairs are among LAMMPS' already.
  Kokkos::deep_copy(LMPDeviceType(), loads, 0.0);
  const EllgranGpuGrains now = grains();
  for (const PlaneNow &plane : planes)
    check(ellgran_gpu_compute_plane(scene, &now, plane.number, &plane.place, wall_type, &step, loads.data(), stream()));
  put_loads();
}

void EllgranDeviceGrains::put_loads()
{
  auto *const atoms = static_cast<AtomKokkos *>(atom);
  const auto f = atoms->k_f.view_device();
  const auto torque = atoms->k_torque.view_device();
  const auto from = loads;
  Kokkos::parallel_for(
      Policy(0, listed_owned), KOKKOS_LAMBDA(const int i) {
        for (int k = 0; k < 3; k++) {
          f(i, k) += from(i, k);
          torque(i, k) += from(i, 3 + k);
        }
      });
}

/* Some commands between two runs take images away, or atoms. A run without set-up goes on with the list of the one before it. */

void EllgranDeviceGrains::require_listed() const
{
  const int count = atom->nlocal + atom->nghost;
  if (listed_count < 0 || atom->nlocal != listed_owned || count != listed_count)
    error->one(FLERR,
               "{}: the neighbour list is of {} atoms and images, but there are {} now: a command between two runs has changed them: "
               "leave out 'pre no' in the run that follows it",
               caller, listed_count, count);
}

/* All that may have changed since forces were computed. */

void EllgranDeviceGrains::take_motion()
{
  require_listed();
  auto *const atoms = static_cast<AtomKokkos *>(atom);
  auto *const style = dynamic_cast<AtomVecEllipsoidKokkos *>(atom->style_match("ellipsoid"));
  const auto bonus = style->k_bonus.view_device();
  const auto ellipsoid = atoms->k_ellipsoid.view_device();
  const auto to_quaternions = quaternions;
  fit(loads, "ellgran:loads", listed_owned);
  const auto v = atoms->k_v.view_device();
  const auto angmom = atoms->k_angmom.view_device();
  const auto f = atoms->k_f.view_device();
  const auto torque = atoms->k_torque.view_device();
  const auto to_velocities = velocities;
  const auto to_momenta = momenta;
  const auto to_loads = loads;
  Kokkos::parallel_for(
      Policy(0, listed_owned), KOKKOS_LAMBDA(const int i) {
        for (int k = 0; k < 3; k++) {
          to_velocities(i, k) = v(i, k);
          to_momenta(i, k) = angmom(i, k);
          to_loads(i, k) = f(i, k);
          to_loads(i, 3 + k) = torque(i, k);
        }
        const double *const quat = bonus(ellipsoid(i)).quat;
        for (int k = 0; k < 4; k++) to_quaternions(i, k) = quat[k];
      });
}

void EllgranDeviceGrains::put_motion(bool turned)
{
  auto *const atoms = static_cast<AtomKokkos *>(atom);
  auto *const style = dynamic_cast<AtomVecEllipsoidKokkos *>(atom->style_match("ellipsoid"));
  const auto v = atoms->k_v.view_device();
  const auto angmom = atoms->k_angmom.view_device();
  const auto bonus = style->k_bonus.view_device();
  const auto ellipsoid = atoms->k_ellipsoid.view_device();
  const auto from_velocities = velocities;
  const auto from_momenta = momenta;
  const auto from_quaternions = quaternions;
  Kokkos::parallel_for(
      Policy(0, listed_owned), KOKKOS_LAMBDA(const int i) {
        for (int k = 0; k < 3; k++) {
          v(i, k) = from_velocities(i, k);
          angmom(i, k) = from_momenta(i, k);
        }
        if (!turned) return;
        double *const quat = bonus(ellipsoid(i)).quat;
        for (int k = 0; k < 4; k++) quat[k] = from_quaternions(i, k);
      });
}

void EllgranDeviceGrains::start_step(double time_step, double time_step_before)
{
  take_motion();
  const EllgranGpuMotion now = motion(time_step_before);
  check(ellgran_gpu_start_step(scene, &now, time_step, stream()));
  put_motion(true);
}

void EllgranDeviceGrains::finish_step(double time_step, double time_step_before)
{
  take_motion();
  const EllgranGpuMotion now = motion(time_step_before);
  check(ellgran_gpu_finish_step(scene, &now, time_step, stream()));
  put_motion(false);
}

void EllgranDeviceGrains::prepare()
{
  take_state();
  const EllgranGpuGrains now = grains();
  check(ellgran_gpu_prepare(scene, &now, stream()));
}

/* LAMMPS may have its atoms in another order than when the list was made. */

void EllgranDeviceGrains::add_changes(double sign)
{
  if (!changes_known) return;
  auto *const atoms = static_cast<AtomKokkos *>(atom);
  const auto tag = atoms->k_tag.view_device();
  const auto v = atoms->k_v.view_device();
  const auto angmom = atoms->k_angmom.view_device();
  const auto from = changes;
  const auto place = places;
  const int size = static_cast<int>(places.extent(0));
  Kokkos::parallel_for(
      Policy(0, atom->nlocal), KOKKOS_LAMBDA(const int i) {
        const int j = (tag(i) < size) ? place(tag(i)) : -1;
        if (j < 0) return;
        for (int k = 0; k < 3; k++) {
          v(i, k) += sign * from(j, k);
          angmom(i, k) += sign * from(j, 3 + k);
        }
      });
}

void EllgranDeviceGrains::require_sound()
{
  if (listed_count < 0) return;
  const EllgranGpuGrains now = grains();
  check(ellgran_gpu_check(scene, &now, stream()));
}
