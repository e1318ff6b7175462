// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// `pair_style gran/ellipsoid/kk`: the pair style in a run with KOKKOS.

#ifdef PAIR_CLASS
// clang-format off
PairStyle(gran/ellipsoid/kk,PairGranEllipsoidKokkos);
PairStyle(gran/ellipsoid/kk/host,PairGranEllipsoidKokkos);
// clang-format on
#else

#ifndef LMP_PAIR_GRAN_ELLIPSOID_KOKKOS_H
#define LMP_PAIR_GRAN_ELLIPSOID_KOKKOS_H

#include "ellgran_kokkos.h"
#include "pair_gran_ellipsoid.h"

namespace LAMMPS_NS {

class PairGranEllipsoidKokkos : public EllgranKokkos<PairGranEllipsoid> {
 public:
  PairGranEllipsoidKokkos(LAMMPS *lmp) : EllgranKokkos("Pair gran/ellipsoid/kk", "gran/ellipsoid", lmp) {}
};

}    // namespace LAMMPS_NS

#endif
#endif
