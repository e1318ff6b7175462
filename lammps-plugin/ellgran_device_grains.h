// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// Where in the memory of the GPU are the arrays that the kernels of ellgran take, in a run of LAMMPS with KOKKOS for CUDA? Tells the kernels
/// of LAMMPS' views, which they read and write as they are, and starts them; computes no physics. Compiled with the headers of KOKKOS.

#ifndef ELLGRAN_DEVICE_GRAINS_H
#define ELLGRAN_DEVICE_GRAINS_H

#include "pointers.h"

#include "ellgran_gpu.h"

#include "kokkos_type.h"
#include "neigh_list_kokkos.h"

#include <string>
#include <vector>

namespace LAMMPS_NS {

static_assert(sizeof(tagint) == sizeof(int32_t), "the kernels of ellgran take identifiers of 4 bytes: LAMMPS_SIZES must be smallbig");
static_assert(sizeof(KK_FLOAT) == sizeof(double), "the kernels of ellgran take double precision: KOKKOS_PREC must be double");

class EllgranDeviceGrains : protected Pointers {
 public:
  /// `caller` opens every message.
  EllgranDeviceGrains(class LAMMPS *lmp, const std::string &caller);
  ~EllgranDeviceGrains();
  EllgranDeviceGrains(const EllgranDeviceGrains &) = delete;
  EllgranDeviceGrains &operator=(const EllgranDeviceGrains &) = delete;

  /// A scene with these laws, in which nothing is remembered.
  void set_laws(const EllgranLaws *laws);
  [[nodiscard]] bool has_scene() const { return scene != nullptr; }

  /// Whether something is remembered of the contacts of the run before.
  [[nodiscard]] bool has_list() const { return listed_count >= 0; }
  [[nodiscard]] int owned_in_list() const { return listed_owned; }

  /// Whether forces see velocities of the step; decided before a list.
  void use_velocities_of_step(bool yes);
  [[nodiscard]] bool uses_velocities_of_step() const { return of_step; }

  /// Nothing is known of the velocities that the last forces saw: they are those that there are.
  void forget_steps() { changes_known = false; }

  /// Takes the order that LAMMPS' atoms have now, before `take_list`: what is kept of each atom follows its ID. With several ranks images
  /// have velocities of their own (`pack_motion`), else those of the grains that they are images of.
  void follow_order(bool several_ranks);

  /// Takes LAMMPS' neighbour list: full, and on the device.
  void take_list(NeighListKokkos<LMPDeviceType> *list);

  /// The rows of the list on the host, and the IDs that its atoms and images had when it was made.
  struct Rows {
    std::vector<uint32_t> starts, neighbours;
    std::vector<tagint> ids;
    int owned;
    /// Whether row `k` is the one that keeps its pair with `other`.
    [[nodiscard]] bool keeps(int k, int other) const { return other >= owned || ids[k] < ids[other]; }
  };
  const Rows &rows();
  /// The grain that each atom and image of the list is, or is an image of; empty with several ranks.
  [[nodiscard]] std::vector<int> owners_on_host() const;

  /// What is remembered of the entries of the rows, on the host: `length` doubles each. Of a pair: as of the pair whose first grain has
  /// the lower ID.
  struct Remembered {
    std::vector<uint32_t> touching;
    std::vector<double> histories;
    std::size_t length;
  };
  [[nodiscard]] Remembered remembered() const;
  [[nodiscard]] Remembered nothing_remembered() const;
  /// In place of all that is remembered.
  void remember(const Remembered &pairs);

  /// The IDs that the atoms of this rank had when the list was made.
  [[nodiscard]] std::vector<tagint> ids_of_owned() const;

  /// A wall of the scene, or a plane that is one of its parts, and how the host keeps what it remembers.
  struct WallOnHost {
    int32_t number;
    const EllgranWall *wall;
    const EllgranLaws *laws;
    int32_t part;
  };
  /// Adds what grains of the list remember of it to `histories` on the host; see ellgran_gpu_read_wall_histories.
  void read_wall(const WallOnHost &wall, double *histories) const;
  /// In place of all that is remembered of it, of LAMMPS' present atoms in their order.
  void write_wall(const WallOnHost &wall, const double *histories);

  /// What is kept of the steps of each grain of the list, on the host: what velocities and angular momenta of the last forces have more,
  /// and the loads before; KEPT_OF_STEPS doubles each. Empty if nothing is.
  static constexpr int KEPT_OF_STEPS = 12;
  [[nodiscard]] std::vector<double> steps() const;
  /// In place of it, of LAMMPS' present atoms in their order.
  void set_steps(const std::vector<double> &values);
  /// The first part of it, of all atoms and images of the list, 6 doubles each; empty if nothing is kept.
  [[nodiscard]] std::vector<double> velocity_changes() const;

  /// Messages with the velocities of grains to their images on other ranks, `motion_length()` doubles each.
  [[nodiscard]] int motion_length() const { return of_step ? 12 : 6; }
  void pack_motion(int n, const DAT::tdual_int_1d &indices, DAT::tdual_double_1d &buffer);
  void unpack_motion(int n, int first, DAT::tdual_double_1d &buffer);

  /// Stops where LAMMPS has other atoms than the list.
  void require_listed() const;

  /// Takes positions, attitudes and velocities as they are now; of images, from the grains that they are images of.
  void prepare();

  /// Elastic energies and virial of pairs, before their forces are added.
  EllgranGpuTallies tallies(const EllgranStep &step);
  /// Adds the forces of pairs to LAMMPS'.
  void add_forces(const EllgranStep &step);

  /// Adds a plane to the scene, before its first list; its number.
  int32_t add_plane();

  /// Adds the forces of planes to LAMMPS', after those of pairs: `wall_type` in the laws of the scene.
  struct PlaneNow {
    int32_t number;
    EllgranPlane place;
  };
  void add_plane_forces(const std::vector<PlaneNow> &planes, int32_t wall_type, const EllgranStep &step);

  /// Adds a wall of any shapes without triangles to the scene, before its first list; its number.
  int32_t add_wall(const EllgranWall *wall);

  /// Adds the forces of such a wall to LAMMPS', after those of pairs: `wall_type` in the laws of the scene.
  void add_wall_forces(int32_t number, const EllgranWallMotion &motion, int32_t wall_type, const EllgranStep &step);

  /// What acted on a plane or wall of the scene in the last step: the force, and the torque about the origin. Waits for it.
  struct WallLoad {
    double force[3] = {}, torque[3] = {};
  };
  [[nodiscard]] WallLoad load_on_wall(int32_t number) const;

  /// Halves of a step of velocity Verlet, of all owned grains.
  void start_step(double time_step, double time_step_before);
  void finish_step(double time_step, double time_step_before);

  /// Adds `sign` times what velocities and angular momenta were more, when the last forces were computed, than they are.
  void add_changes(double sign);

  /// Waits, and stops if something is wrong with a grain.
  void require_sound();

  // Parts of the above. The compiler wants functions that have kernels of KOKKOS in them to be public.
  void place_ids();
  void find_margin();
  void take_rows(NeighListKokkos<LMPDeviceType> *list);
  void add_wall_loads(int32_t number);

 private:
  using Loads = Kokkos::View<double *[6], Kokkos::LayoutRight, LMPDeviceType>;
  using Vectors = Kokkos::View<double *[3], Kokkos::LayoutRight, LMPDeviceType>;
  using Integers = Kokkos::View<int *, LMPDeviceType>;
  using Unsigned = Kokkos::View<uint32_t *, LMPDeviceType>;

  std::string caller;
  EllgranGpu *gpu;
  EllgranGpuScene *scene;
  bool of_step, changes_known, has_owners, rows_known;
  int listed_count, listed_owned;    // grains of the list, images included, and owned ones; -1: none yet
  double margin;

  Integers owners;    // the grain itself, or that of which it is an image; not with several ranks
  Integers ids;       // of the atoms and images of the list
  Rows rows_of_list;
  Loads changes, loads_before, other_changes, other_loads;
  Vectors wall_forces, wall_torques;    // of the owned grains, by one wall
  std::vector<Loads> loads_on_walls;    // by their numbers: parts of the sums over all grains
  Integers places;    // of owned grains by identifier; -1: none
  Unsigned starts, neighbours;

  void check(int32_t status) const;
  [[nodiscard]] void *stream() const;
  [[nodiscard]] EllgranGpuGrains grains() const;
  [[nodiscard]] EllgranGpuLoads loads() const;
  [[nodiscard]] EllgranGpuLoads no_wall_loads();
  [[nodiscard]] EllgranGpuMotion motion(double time_step_before) const;
};

}    // namespace LAMMPS_NS

#endif
