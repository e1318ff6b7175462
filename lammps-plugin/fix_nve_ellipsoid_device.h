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

#include "kokkos_base.h"

#include <vector>

namespace LAMMPS_NS {

/// With velocities of the step, what is kept of the steps of each grain is on the GPU. It comes to the atoms where they go to other ranks
/// or into a restart file, and where a run finds other atoms than the last one ended with; it has the form of `fix nve/ellipsoid` there.
class FixNVEEllipsoidDevice : public Fix, public KokkosBase {
 public:
  FixNVEEllipsoidDevice(class LAMMPS *, int, char **);
  ~FixNVEEllipsoidDevice() override;
  FixNVEEllipsoidDevice(const FixNVEEllipsoidDevice &) = delete;
  FixNVEEllipsoidDevice &operator=(const FixNVEEllipsoidDevice &) = delete;

  int setmask() override;
  void post_constructor() override;
  void init() override;
  void setup_pre_exchange() override;
  void pre_exchange() override;
  void setup_pre_force(int) override;
  void setup(int) override;
  void initial_integrate(int) override;
  void final_integrate() override;
  void post_run() override;

  double memory_usage() override;
  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  int size_restart(int) override;
  int maxsize_restart() override;
  int pack_restart(int, double *) override;
  void unpack_restart(int, int) override;
  void write_restart(FILE *) override;
  void restart(char *) override;

  /// Gives to the GPU what the atoms have, before the order of a new list is taken.
  void give_to_device();
  /// When a run starts, while `pair_now` still knows the atoms of the last one: where there are others now, these take what is kept of
  /// their steps.
  void follow_atoms(class PairGranEllipsoidDevice *pair_now);

  [[nodiscard]] bool has_velocities_of_step() const { return of_step; }

 private:
  class AtomKokkos *atomKK;
  class PairGranEllipsoidDevice *pair;
  bool of_step;              // the word `velocities step`: forces see velocities of the step
  bool swapped;              // while a run starts: `v` is what the last forces saw
  bool is_new;               // no run has been started with it
  double time_step_before;   // 0: not known

  double **of_steps;     // of each atom
  tagint *ids_at_end;    // of each atom when the last run ended; 0: not known
  bool held;             // the atoms have it, and no longer the GPU
  bool runs;             // the GPU knows the atoms by the IDs that they have

  void swap(double sign);
  void take_from_device();
  [[nodiscard]] bool atoms_have_changed() const;
};

}    // namespace LAMMPS_NS

#endif
#endif
