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

  /// Whether forces see velocities of the step; decided before a list.
  void use_velocities_of_step(bool yes);

  /// Nothing is known of the velocities that the last forces saw: they are those that there are.
  void forget_steps() { changes_known = false; }

  /// Takes the order that LAMMPS' atoms have now, and its neighbour list: full, and on the device.
  void take_list(NeighListKokkos<LMPDeviceType> *list);

  /// Stops where LAMMPS has other atoms than the list.
  void require_listed() const;

  /// Takes positions, attitudes and velocities as they are now; of images, from the grains that they are images of.
  void prepare();

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

  /// Halves of a step of velocity Verlet, of all owned grains.
  void start_step(double time_step, double time_step_before);
  void finish_step(double time_step, double time_step_before);

  /// Adds `sign` times what velocities and angular momenta were more, when the last forces were computed, than they are.
  void add_changes(double sign);

  /// Waits, and stops if something is wrong with a grain.
  void require_sound();

  // Parts of the above. The compiler wants functions that have kernels of KOKKOS in them to be public.
  void follow_order();
  void find_margin();
  void take_rows(NeighListKokkos<LMPDeviceType> *list);

 private:
  using Loads = Kokkos::View<double *[6], Kokkos::LayoutRight, LMPDeviceType>;
  using Integers = Kokkos::View<int *, LMPDeviceType>;
  using Unsigned = Kokkos::View<uint32_t *, LMPDeviceType>;

  std::string caller;
  EllgranGpu *gpu;
  EllgranGpuScene *scene;
  bool of_step, changes_known;
  int listed_count, listed_owned;    // grains of the list, images included, and owned ones; -1: none yet
  double margin;

  Integers owners;    // the grain itself, or that of which it is an image
  Loads changes, loads_before, other_changes, other_loads;
  Integers places;    // of owned grains by identifier; -1: none
  Unsigned starts, neighbours;

  void check(int32_t status) const;
  [[nodiscard]] void *stream() const;
  [[nodiscard]] EllgranGpuGrains grains() const;
  [[nodiscard]] EllgranGpuLoads loads() const;
  [[nodiscard]] EllgranGpuMotion motion(double time_step_before) const;
};

}    // namespace LAMMPS_NS

#endif
