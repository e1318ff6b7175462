// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// `fix nve/ellipsoid/kk`: the integrator in a run with KOKKOS.

#ifdef FIX_CLASS
// clang-format off
FixStyle(nve/ellipsoid/kk,FixNVEEllipsoidKokkos);
FixStyle(nve/ellipsoid/kk/host,FixNVEEllipsoidKokkos);
// clang-format on
#else

#ifndef LMP_FIX_NVE_ELLIPSOID_KOKKOS_H
#define LMP_FIX_NVE_ELLIPSOID_KOKKOS_H

#include "ellgran_kokkos.h"
#include "fix_nve_ellipsoid.h"

namespace LAMMPS_NS {

class FixNVEEllipsoidKokkos : public EllgranKokkosFix<FixNVEEllipsoid> {
 public:
  FixNVEEllipsoidKokkos(LAMMPS *lmp, int narg, char **arg) :
      EllgranKokkosFix("Fix nve/ellipsoid/kk", "nve/ellipsoid", lmp, narg, arg)
  {
  }
};

}    // namespace LAMMPS_NS

#endif
#endif
