// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// `pair_style gran/ellipsoid/kk` in a LAMMPS with KOKKOS for CUDA: forces of contacts by the kernels of ellgran, from arrays that stay
/// in the memory of the GPU.

#ifdef PAIR_CLASS
// clang-format off
PairStyle(gran/ellipsoid/kk,PairGranEllipsoidDevice);
PairStyle(gran/ellipsoid/kk/device,PairGranEllipsoidDevice);
// clang-format on
#else

#ifndef LMP_PAIR_GRAN_ELLIPSOID_DEVICE_H
#define LMP_PAIR_GRAN_ELLIPSOID_DEVICE_H

#include "pair_gran_ellipsoid.h"

#include "ellgran_device_grains.h"

#include <vector>

namespace LAMMPS_NS {

class PairGranEllipsoidDevice : public PairGranEllipsoid {
 public:
  PairGranEllipsoidDevice(class LAMMPS *);

  void compute(int, int) override;
  void init_style() override;
  void setup() override;
  void finish() override;
  void write_restart(FILE *) override;
  void read_restart(FILE *) override;
  void write_restart_settings(FILE *) override;
  void read_restart_settings(FILE *) override;

  EllgranDeviceGrains grains;

  /// The pair style of this LAMMPS; stops where it is another one.
  static PairGranEllipsoidDevice *of(class LAMMPS *lmp, const char *caller);

 private:
  class AtomKokkos *atomKK;
  std::vector<EllgranLawParameters> laws_of_scene;    // row-major over the types of atoms and the walls
  std::vector<uint8_t> set_in_scene;
  uint32_t options_of_scene;
  std::vector<tagint> ids_at_end;    // of all atoms in their order, when the last run ended

  void refuse_what_the_gpu_has_not() const;
  void require_wide_box() const;
  void refuse_other_atoms();
  void take_laws();
};

}    // namespace LAMMPS_NS

#endif
#endif
