// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_device_grains.h"

#include "atom_kokkos.h"
#include "atom_masks.h"
#include "atom_vec_ellipsoid_kokkos.h"
#include "error.h"
#include "neighbor.h"

#include <algorithm>
#include <cstddef>
#include <limits>

using namespace LAMMPS_NS;

namespace {

// Pairs of the list with a wider gap than the mean margin of the grains are looked at again only when a grain has moved by half of it: so
// much of the largest semi-axis, between these shares of the smallest. On an H100 128 000 needles of aspect ratio 10 take 4.5 ms a step with
// a twentieth of the smallest, 2.4 ms with a fifth (tests/lammps_on_gpu/time.lmp).
constexpr double MARGIN_PER_LENGTH = 0.025, MARGIN = 0.05, MOST_MARGIN = 0.2;

// Forces and torques that are not known, as in fix nve/ellipsoid.
constexpr double UNKNOWN = std::numeric_limits<double>::infinity();

// Threads that sum up what acts on a wall, at most: each takes some of the grains.
constexpr int SUMMING_THREADS = 1 << 16;

using Policy = Kokkos::RangePolicy<LMPDeviceType>;

// Rows or columns, as KOKKOS has them for this machine.
template <class View> EllgranGpuVectors vectors_of(const View &view)
{
  return {view.data(), view.stride(0), view.stride(1)};
}

AtomVecEllipsoidKokkos *style_of(Atom *atom)
{
  return dynamic_cast<AtomVecEllipsoidKokkos *>(atom->style_match("ellipsoid"));
}

// LAMMPS has shapes and attitudes in records beside its other arrays.
struct Bodies {
  EllgranGpuVectors semi_axes, quaternions;
  const int32_t *places;
  std::size_t count;

  explicit Bodies(Atom *atom)
  {
    const auto bonus = style_of(atom)->k_bonus.view_device();
    using Record = AtomVecEllipsoid::Bonus;
    static_assert(sizeof(Record) % sizeof(double) == 0, "records of LAMMPS hold doubles at a distance of doubles");
    constexpr std::size_t record = sizeof(Record) / sizeof(double);
    auto *const first = reinterpret_cast<double *>(bonus.data());
    semi_axes = {first + offsetof(Record, shape) / sizeof(double), record, 1};
    quaternions = {first + offsetof(Record, quat) / sizeof(double), record, 1};
    places = static_cast<AtomKokkos *>(atom)->k_ellipsoid.view_device().data();
    count = bonus.extent(0);
  }
};

template <class T> using OnHost = Kokkos::View<T *, Kokkos::HostSpace, Kokkos::MemoryTraits<Kokkos::Unmanaged>>;
template <class T> using OnDevice = Kokkos::View<T *, LMPDeviceType, Kokkos::MemoryTraits<Kokkos::Unmanaged>>;

// Copies to the host, and waits for it.
template <class T> std::vector<T> copied_out(const T *from, std::size_t count)
{
  std::vector<T> to(count);
  if (count > 0) Kokkos::deep_copy(OnHost<T>(to.data(), count), OnDevice<const T>(from, count));
  return to;
}

template <class T> void copy_in(T *to, const T *from, std::size_t count)
{
  if (count > 0) Kokkos::deep_copy(OnDevice<T>(to, count), OnHost<const T>(from, count));
}

// Views that only grow: LAMMPS adds images with each list.
template <class View> void fit(View &view, const char *label, size_t count)
{
  if (view.extent(0) < count || !view.data())
    view = View(Kokkos::view_alloc(Kokkos::WithoutInitializing, std::string(label)), count + count / 8 + 1);
}

}    // namespace

EllgranDeviceGrains::EllgranDeviceGrains(LAMMPS *lmp, const std::string &caller_name) :
    Pointers(lmp), caller(caller_name), gpu(nullptr), scene(nullptr), of_step(false), changes_known(false), has_owners(true), rows_known(false), listed_count(-1), listed_owned(0), margin(0.0)
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
  rows_known = false;
  loads_on_walls.clear();
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
  const Bodies bodies(atom);
  EllgranGpuGrains grains = ELLGRAN_INIT(EllgranGpuGrains);
  grains.owned_count = listed_owned;
  grains.count = listed_count;
  grains.positions = vectors_of(atoms->k_x.view_device());
  grains.velocities = vectors_of(atoms->k_v.view_device());
  grains.angular_momenta = vectors_of(atoms->k_angmom.view_device());
  grains.velocity_changes = of_step ? changes.data() : nullptr;
  grains.masses = atoms->k_rmass.view_device().data();
  grains.semi_axes = bodies.semi_axes;
  grains.quaternions = bodies.quaternions;
  grains.types = atoms->k_type.view_device().data();
  grains.identifiers = atoms->k_tag.view_device().data();
  grains.owners = has_owners ? owners.data() : nullptr;
  grains.body_places = bodies.places;
  grains.body_count = bodies.count;
  return grains;
}

/* LAMMPS has set these to zero, and others may have added to them. */

EllgranGpuLoads EllgranDeviceGrains::loads() const
{
  auto *const atoms = static_cast<AtomKokkos *>(atom);
  EllgranGpuLoads loads = ELLGRAN_INIT(EllgranGpuLoads);
  loads.forces = vectors_of(atoms->k_f.view_device());
  loads.torques = vectors_of(atoms->k_torque.view_device());
  loads.add = 1;
  return loads;
}

EllgranGpuMotion EllgranDeviceGrains::motion(double time_step_before) const
{
  auto *const atoms = static_cast<AtomKokkos *>(atom);
  const Bodies bodies(atom);
  const EllgranGpuLoads now = loads();
  EllgranGpuMotion motion = ELLGRAN_INIT(EllgranGpuMotion);
  motion.count = listed_owned;
  motion.positions = vectors_of(atoms->k_x.view_device());
  motion.velocities = vectors_of(atoms->k_v.view_device());
  motion.angular_momenta = vectors_of(atoms->k_angmom.view_device());
  motion.quaternions = bodies.quaternions;
  motion.semi_axes = bodies.semi_axes;
  motion.masses = atoms->k_rmass.view_device().data();
  motion.forces = now.forces;
  motion.torques = now.torques;
  motion.body_places = bodies.places;
  motion.body_count = bodies.count;
  if (of_step) {
    motion.velocity_changes = changes.data();
    motion.loads_before = loads_before.data();
    motion.time_step_before = time_step_before;
  }
  return motion;
}

/* LAMMPS has sorted its atoms, added or deleted some, and has other images. What is kept of each is carried over by its identifier. */

void EllgranDeviceGrains::follow_order(bool several_ranks)
{
  auto *const atoms = static_cast<AtomKokkos *>(atom);
  const int owned = atom->nlocal, count = owned + atom->nghost;
  has_owners = !several_ranks;
  const bool known = changes_known;
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
          int from = (known && id < old_size) ? old_places(id) : -1;
          for (int k = 0; k < 6; k++) {
            to_changes(i, k) = (from >= 0) ? from_changes(from, k) : 0.0;
            to_loads(i, k) = (from >= 0) ? from_loads(from, k) : ((k == 0) ? UNKNOWN : 0.0);
          }
        });
    std::swap(changes, other_changes);
    std::swap(loads_before, other_loads);
    changes_known = true;
  }

  place_ids();
  fit(owners, "ellgran:owners", count);
  fit(ids, "ellgran:ids", count);
  const auto now = places;
  const auto of = owners, id = ids;
  const int size = static_cast<int>(places.extent(0));
  const auto type = atoms->k_type.view_device();
  const bool has_own_images = has_owners;
  Kokkos::parallel_for(
      Policy(0, count), KOKKOS_LAMBDA(const int i) {
        id(i) = tag(i);
        of(i) = (i < owned) ? i : ((tag(i) < size) ? now(tag(i)) : -1);
        // Images do not hear of types that a command has changed before a run without set-up.
        if (has_own_images && i >= owned && of(i) >= 0) type(i) = type(of(i));
      });
  if (has_owners) atoms->modified(Device, TYPE_MASK);
  listed_owned = owned;
  listed_count = count;
  rows_known = false;
}

/* Where LAMMPS' present atoms are, by their IDs. */

void EllgranDeviceGrains::place_ids()
{
  const int owned = atom->nlocal;
  const auto tag = static_cast<AtomKokkos *>(atom)->k_tag.view_device();
  int largest = 0;
  Kokkos::parallel_reduce(
      Policy(0, owned), KOKKOS_LAMBDA(const int i, int &most) { most = (tag(i) > most) ? tag(i) : most; },
      Kokkos::Max<int>(largest));
  // On a rank without atoms the reduction leaves the least number that there is.
  largest = std::max(largest, 0);
  if (places.extent(0) < static_cast<size_t>(largest) + 1)
    places = Integers(Kokkos::view_alloc(Kokkos::WithoutInitializing, std::string("ellgran:places")), static_cast<size_t>(largest) + 1 + largest / 8);
  Kokkos::deep_copy(LMPDeviceType(), places, -1);
  const auto now = places;
  Kokkos::parallel_for(
      Policy(0, owned), KOKKOS_LAMBDA(const int i) { now(tag(i)) = i; });
}

/* The ends of long grains move far when they turn, and their neighbour lists are long: a wider margin is worth its pairs there. */

void EllgranDeviceGrains::find_margin()
{
  auto *const atoms = static_cast<AtomKokkos *>(atom);
  const auto bonus = style_of(atom)->k_bonus.view_device();
  const auto ellipsoid = atoms->k_ellipsoid.view_device();
  double sum = 0.0;
  Kokkos::parallel_reduce(
      Policy(0, listed_owned),
      KOKKOS_LAMBDA(const int i, double &of_all) {
        const double *const axes = bonus(ellipsoid(i)).shape;
        double least = axes[0], largest = axes[0];
        for (int k = 1; k < 3; k++) {
          least = (axes[k] < least) ? axes[k] : least;
          largest = (axes[k] > largest) ? axes[k] : largest;
        }
        const double of_length = MARGIN_PER_LENGTH * largest, most = MOST_MARGIN * least;
        const double wide = (of_length < most) ? of_length : most;
        of_all += (wide > MARGIN * least) ? wide : MARGIN * least;
      },
      sum);
  margin = (listed_owned > 0) ? std::min(sum / listed_owned, neighbor->skin) : 0.0;
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
  find_margin();
  take_rows(list);
  EllgranGpuList rows = ELLGRAN_INIT(EllgranGpuList);
  rows.starts = starts.data();
  rows.neighbours = neighbours.data();
  rows.margin = margin;
  const EllgranGpuGrains now = grains();
  check(ellgran_gpu_new_list(scene, &now, &rows, stream()));
}

const EllgranDeviceGrains::Rows &EllgranDeviceGrains::rows()
{
  if (!rows_known) {
    rows_of_list.owned = listed_owned;
    rows_of_list.starts = copied_out(starts.data(), static_cast<std::size_t>(listed_owned) + 1);
    rows_of_list.neighbours = copied_out(neighbours.data(), rows_of_list.starts.back());
    rows_of_list.ids = copied_out(ids.data(), listed_count);
    rows_known = true;
  }
  return rows_of_list;
}

std::vector<int> EllgranDeviceGrains::owners_on_host() const
{
  return has_owners ? copied_out<int>(owners.data(), listed_count) : std::vector<int>();
}

EllgranDeviceGrains::Remembered EllgranDeviceGrains::nothing_remembered() const
{
  EllgranGpuHistories held = ELLGRAN_INIT(EllgranGpuHistories);
  check(ellgran_gpu_histories(scene, -1, &held));
  return {std::vector<uint32_t>(held.count), std::vector<double>(held.count * held.length), held.length};
}

EllgranDeviceGrains::Remembered EllgranDeviceGrains::remembered() const
{
  Remembered pairs = nothing_remembered();
  check(ellgran_gpu_read_histories(scene, -1, pairs.touching.data(), pairs.histories.data(), stream()));
  return pairs;
}

void EllgranDeviceGrains::remember(const Remembered &pairs)
{
  const EllgranGpuGrains now = grains();
  check(ellgran_gpu_write_histories(scene, &now, -1, pairs.touching.data(), pairs.histories.data(), stream()));
}

std::vector<tagint> EllgranDeviceGrains::ids_of_owned() const
{
  return copied_out<tagint>(ids.data(), listed_owned);
}

void EllgranDeviceGrains::read_wall(const WallOnHost &of, double *histories) const
{
  check(ellgran_gpu_read_wall_histories(scene, of.number, of.wall, of.laws, of.part, histories, stream()));
}

void EllgranDeviceGrains::write_wall(const WallOnHost &of, const double *histories)
{
  const EllgranGpuGrains now = grains();
  check(ellgran_gpu_write_wall_histories(scene, &now, of.number, of.wall, of.laws, of.part, histories, stream()));
}

std::vector<double> EllgranDeviceGrains::steps() const
{
  if (!of_step || !changes_known || listed_count < 0) return {};
  const std::size_t n = listed_owned;
  const auto more = copied_out<double>(changes.data(), 6 * n), before = copied_out<double>(loads_before.data(), 6 * n);
  std::vector<double> values(KEPT_OF_STEPS * n);
  for (std::size_t i = 0; i < n; i++) {
    std::copy_n(&more[6 * i], 6, &values[KEPT_OF_STEPS * i]);
    std::copy_n(&before[6 * i], 6, &values[KEPT_OF_STEPS * i + 6]);
  }
  return values;
}

void EllgranDeviceGrains::set_steps(const std::vector<double> &values)
{
  const std::size_t n = atom->nlocal;
  fit(changes, "ellgran:changes", n);
  fit(loads_before, "ellgran:loads_before", n);
  std::vector<double> part(6 * n);
  for (std::size_t i = 0; i < n; i++) std::copy_n(&values[KEPT_OF_STEPS * i], 6, &part[6 * i]);
  copy_in<double>(changes.data(), part.data(), part.size());
  for (std::size_t i = 0; i < n; i++) std::copy_n(&values[KEPT_OF_STEPS * i + 6], 6, &part[6 * i]);
  copy_in<double>(loads_before.data(), part.data(), part.size());
  place_ids();
  changes_known = true;
}

std::vector<double> EllgranDeviceGrains::velocity_changes() const
{
  if (!of_step) return {};
  if (!has_owners) return copied_out<double>(changes.data(), 6 * static_cast<std::size_t>(listed_count));
  auto values = copied_out<double>(changes.data(), 6 * static_cast<std::size_t>(listed_owned));
  const auto of = owners_on_host();
  values.resize(6 * static_cast<std::size_t>(listed_count));
  for (int i = listed_owned; i < listed_count; i++) std::copy_n(&values[6 * static_cast<std::size_t>(of[i])], 6, &values[6 * static_cast<std::size_t>(i)]);
  return values;
}

void EllgranDeviceGrains::pack_motion(int n, const DAT::tdual_int_1d &indices, DAT::tdual_double_1d &buffer)
{
  auto *const atoms = static_cast<AtomKokkos *>(atom);
  const auto index = indices.view<LMPDeviceType>();
  const auto to = buffer.view<LMPDeviceType>();
  const auto v = atoms->k_v.view_device();
  const auto angmom = atoms->k_angmom.view_device();
  const auto more = changes;
  const int length = motion_length();
  Kokkos::parallel_for(
      Policy(0, n), KOKKOS_LAMBDA(const int i) {
        const int j = index(i);
        for (int k = 0; k < 3; k++) {
          to(i * length + k) = v(j, k);
          to(i * length + 3 + k) = angmom(j, k);
        }
        for (int k = 6; k < length; k++) to(i * length + k) = more(j, k - 6);
      });
}

void EllgranDeviceGrains::unpack_motion(int n, int first, DAT::tdual_double_1d &buffer)
{
  auto *const atoms = static_cast<AtomKokkos *>(atom);
  const auto from = buffer.view<LMPDeviceType>();
  const auto v = atoms->k_v.view_device();
  const auto angmom = atoms->k_angmom.view_device();
  const auto more = changes;
  const int length = motion_length();
  Kokkos::parallel_for(
      Policy(0, n), KOKKOS_LAMBDA(const int i) {
        const int j = first + i;
        for (int k = 0; k < 3; k++) {
          v(j, k) = from(i * length + k);
          angmom(j, k) = from(i * length + 3 + k);
        }
        for (int k = 6; k < length; k++) more(j, k - 6) = from(i * length + k);
      });
}

void EllgranDeviceGrains::add_forces(const EllgranStep &step)
{
  const EllgranGpuGrains now = grains();
  const EllgranGpuLoads to = loads();
  check(ellgran_gpu_compute_pairs(scene, &now, &step, &to, stream()));
}

EllgranGpuTallies EllgranDeviceGrains::tallies(const EllgranStep &step)
{
  const EllgranGpuGrains now = grains();
  EllgranGpuTallies sums = ELLGRAN_INIT(EllgranGpuTallies);
  check(ellgran_gpu_tally_pairs(scene, &now, &step, &sums, stream()));
  return sums;
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
  const EllgranGpuGrains now = grains();
  for (const PlaneNow &plane : planes) {
    const EllgranGpuLoads to = no_wall_loads();
    check(ellgran_gpu_compute_plane(scene, &now, plane.number, &plane.place, wall_type, &step, &to, stream()));
    add_wall_loads(plane.number);
  }
}

int32_t EllgranDeviceGrains::add_wall(const EllgranWall *wall)
{
  int32_t number = -1;
  check(ellgran_gpu_add_wall(scene, wall, stream(), &number));
  return number;
}

void EllgranDeviceGrains::add_wall_forces(int32_t number, const EllgranWallMotion &motion, int32_t wall_type, const EllgranStep &step)
{
  require_listed();
  const EllgranGpuGrains now = grains();
  const EllgranGpuLoads to = no_wall_loads();
  check(ellgran_gpu_compute_wall(scene, &now, number, &motion, wall_type, &step, &to, stream()));
  add_wall_loads(number);
}

/* Loads by one wall, before it is computed. */

EllgranGpuLoads EllgranDeviceGrains::no_wall_loads()
{
  fit(wall_forces, "ellgran:wall_forces", listed_owned);
  fit(wall_torques, "ellgran:wall_torques", listed_owned);
  Kokkos::deep_copy(LMPDeviceType(), wall_forces, 0.0);
  Kokkos::deep_copy(LMPDeviceType(), wall_torques, 0.0);
  EllgranGpuLoads loads = ELLGRAN_INIT(EllgranGpuLoads);
  loads.forces = vectors_of(wall_forces);
  loads.torques = vectors_of(wall_torques);
  loads.add = 1;
  return loads;
}

/* To LAMMPS' forces and torques, and to the sums of the wall, in the same order each time. */

void EllgranDeviceGrains::add_wall_loads(int32_t number)
{
  auto *const atoms = static_cast<AtomKokkos *>(atom);
  if (loads_on_walls.size() <= static_cast<std::size_t>(number)) loads_on_walls.resize(number + 1);
  const int owned = listed_owned, threads = std::min(owned, SUMMING_THREADS);
  auto &sums_of_wall = loads_on_walls[number];
  if (sums_of_wall.extent(0) != static_cast<std::size_t>(threads)) sums_of_wall = Loads("ellgran:load_on_wall", threads);
  const auto sums = sums_of_wall;
  const auto x = atoms->k_x.view_device();
  const auto f = atoms->k_f.view_device();
  const auto torque = atoms->k_torque.view_device();
  const auto of_forces = wall_forces, of_torques = wall_torques;
  Kokkos::parallel_for(
      Policy(0, threads), KOKKOS_LAMBDA(const int thread) {
        double sum[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
        for (int i = thread; i < owned; i += threads) {
          for (int k = 0; k < 3; k++) {
            const int l = (k + 1) % 3, m = (k + 2) % 3;
            f(i, k) += of_forces(i, k);
            torque(i, k) += of_torques(i, k);
            sum[k] -= of_forces(i, k);
            sum[3 + k] -= x(i, l) * of_forces(i, m) - x(i, m) * of_forces(i, l) + of_torques(i, k);
          }
        }
        for (int k = 0; k < 6; k++) sums(thread, k) = sum[k];
      });
}

EllgranDeviceGrains::WallLoad EllgranDeviceGrains::load_on_wall(int32_t number) const
{
  WallLoad load;
  if (loads_on_walls.size() <= static_cast<std::size_t>(number)) return load;
  const auto &sums = loads_on_walls[number];
  const auto of_threads = copied_out<double>(sums.data(), 6 * sums.extent(0));
  for (std::size_t k = 0; k < of_threads.size(); k++) {
    double *const to = (k % 6 < 3) ? load.force : load.torque;
    to[k % 3] += of_threads[k];
  }
  return load;
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

void EllgranDeviceGrains::start_step(double time_step, double time_step_before)
{
  require_listed();
  const EllgranGpuMotion now = motion(time_step_before);
  check(ellgran_gpu_start_step(scene, &now, time_step, stream()));
}

void EllgranDeviceGrains::finish_step(double time_step, double time_step_before)
{
  require_listed();
  const EllgranGpuMotion now = motion(time_step_before);
  check(ellgran_gpu_finish_step(scene, &now, time_step, stream()));
}

void EllgranDeviceGrains::prepare()
{
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
