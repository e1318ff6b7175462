// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// `fix nve/ellipsoid/kk` in a LAMMPS with KOKKOS for CUDA: moves all grains by the kernels of ellgran.

#ifdef FIX_CLASS
// clang-format off
FixStyle(nve/ellipsoid/kk,FixNVEEllipsoidDevice);
FixStyle(nve/ellipsoid/kk/device,FixNVEEllipsoidDevice);
// clang-format on
#else

#ifndef LMP_FIX_NVE_ELLIPSOID_DEVICE_H
#define LMP_FIX_NVE_ELLIPSOID_DEVICE_H

#include "fix.h"

namespace LAMMPS_NS {

class FixNVEEllipsoidDevice : public Fix {
 public:
  FixNVEEllipsoidDevice(class LAMMPS *, int, char **);

  int setmask() override;
  void init() override;
  void setup_pre_exchange() override;
  void setup_pre_force(int) override;
  void setup(int) override;
  void initial_integrate(int) override;
  void final_integrate() override;

  [[nodiscard]] bool has_velocities_of_step() const { return of_step; }

 private:
  class AtomKokkos *atomKK;
  class PairGranEllipsoidDevice *pair;
  bool of_step;              // the word `velocities step`: forces see velocities of the step
  bool swapped;              // while a run starts: `v` is what the last forces saw
  bool is_new;               // no run has been started with it
  double time_step_before;   // 0: not known

  void swap(double sign);
};

}    // namespace LAMMPS_NS

#endif
#endif
