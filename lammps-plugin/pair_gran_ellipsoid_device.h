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

#include "kokkos_base.h"

#include <string>
#include <vector>

namespace LAMMPS_NS {

class PairGranEllipsoidDevice : public PairGranEllipsoid, public KokkosBase {
 public:
  PairGranEllipsoidDevice(class LAMMPS *);

  void compute(int, int) override;
  void init_style() override;
  void setup() override;
  void finish() override;
  int pack_forward_comm_kokkos(int, DAT::tdual_int_1d, DAT::tdual_double_1d &, int, int *) override;
  void unpack_forward_comm_kokkos(int, int, DAT::tdual_double_1d &) override;
  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;

  EllgranDeviceGrains grains;

  /// The pair style of this LAMMPS; stops where it is another one.
  static PairGranEllipsoidDevice *of(class LAMMPS *lmp, const char *caller);

 private:
  class AtomKokkos *atomKK;
  class FixNVEEllipsoidDevice *motion;    // nullptr: LAMMPS moves the grains
  class FixEllgranDeviceHistory *device_history;

  /// The laws of a scene, row-major over the types of atoms and the walls.
  struct SceneLaws {
    std::vector<EllgranLawParameters> given;
    std::vector<uint8_t> is_set;
    [[nodiscard]] bool is(const SceneLaws &other) const;
  };
  SceneLaws laws_of_scene;
  uint32_t options_of_scene;
  bool between_runs;                    // no force has been computed since the last run ended
  std::vector<double> grains_at_end;    // with several ranks: types, masses and semi-axes
  // Where MPI reads the memory of the host alone.
  DAT::tdual_int_1d sent_grains;
  DAT::tdual_double_1d message;

  void refuse_what_the_gpu_has_not() const;
  void require_wide_box() const;
  void keep_what_contacts_remember();
  [[nodiscard]] std::vector<class FixWallGranEllipsoidDevice *> walls() const;
  [[nodiscard]] SceneLaws wanted_laws() const;
  [[nodiscard]] bool scene_serves(const SceneLaws &wanted) const;
  void take_laws();
  class FixEllgranHistory *make_history_fix(const std::string &id) override;
  void begin_list();
  [[nodiscard]] std::vector<double> present_grains();
  void require_same_grains();
  void share_motion();
  int grow_messages(int n);
  void tally(const EllgranStep &step);
  void tally_on_host(const EllgranStep &step);
  template <typename TALLIES> void add_tallies(const TALLIES &sums);
};

}    // namespace LAMMPS_NS

#endif
#endif
