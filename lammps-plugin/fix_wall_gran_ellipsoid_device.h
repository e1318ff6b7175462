// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// `fix wall/gran/ellipsoid/kk` in a LAMMPS with KOKKOS for CUDA: walls with forces by the kernels of ellgran.

#ifdef FIX_CLASS
// clang-format off
FixStyle(wall/gran/ellipsoid/kk,FixWallGranEllipsoidDevice);
FixStyle(wall/gran/ellipsoid/kk/device,FixWallGranEllipsoidDevice);
// clang-format on
#else

#ifndef LMP_FIX_WALL_GRAN_ELLIPSOID_DEVICE_H
#define LMP_FIX_WALL_GRAN_ELLIPSOID_DEVICE_H

#include "fix_wall_gran_ellipsoid.h"

#include "ellgran_device_grains.h"

#include <vector>

namespace LAMMPS_NS {

/// What contacts remember is on the GPU while a run goes on. It comes to the atoms where one ends, for a restart file, and with several ranks
/// where atoms may go to others; the next list takes it back.
class FixWallGranEllipsoidDevice : public FixWallGranEllipsoid {
 public:
  FixWallGranEllipsoidDevice(class LAMMPS *, int, char **);

  void post_constructor() override;
  int setmask() override;
  void init() override;
  void setup(int) override;
  void post_force(int) override;
  void pre_exchange() override;
  void post_run() override;
  double compute_vector(int) override;
  void write_restart(FILE *) override;
  int unpack_exchange(int, double *) override;

  /// The law of contacts of any grain with the wall.
  [[nodiscard]] const EllgranLawParameters &contact_law() const { return law_words; }

  /// Adds the wall to a scene in which it is of this type.
  void add_to_scene(EllgranDeviceGrains &grains, int type);
  [[nodiscard]] bool is_in_scene() const { return type_in_scene > 0; }

  /// With a new list: what the atoms have goes back to the GPU.
  void give_to_device();
  /// The GPU has gone on with it.
  void let_go() { held = false; }

 private:
  class AtomKokkos *atomKK;
  class PairGranEllipsoidDevice *pair;
  int type_in_scene;    // 0: in none
  int32_t numbers[2];   // of the lower and the upper plane
  int32_t number;       // of a wall that is not made of these two alone, or that turns
  bool knows_loads;     // `output_here` is of the last step
  bool held;            // the atoms have what contacts remember, and no longer the GPU

  [[nodiscard]] bool is_of_planes() const { return (plane_slots[0] >= 0 || plane_slots[1] >= 0) && !rotates; }
  void add_plane_forces(const EllgranWallMotion &motion, const EllgranStep &step);
  [[nodiscard]] std::vector<EllgranDeviceGrains::WallOnHost> on_host() const;
  void take_from_device();
  void take_loads();
  static LAMMPS *checked(LAMMPS *lmp);
  void refuse_what_the_gpu_has_not() const;
};

}    // namespace LAMMPS_NS

#endif
#endif
