// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// `fix wall/gran/ellipsoid/kk`: the walls in a run with KOKKOS.

#ifdef FIX_CLASS
// clang-format off
FixStyle(wall/gran/ellipsoid/kk,FixWallGranEllipsoidKokkos);
FixStyle(wall/gran/ellipsoid/kk/host,FixWallGranEllipsoidKokkos);
// clang-format on
#else

#ifndef LMP_FIX_WALL_GRAN_ELLIPSOID_KOKKOS_H
#define LMP_FIX_WALL_GRAN_ELLIPSOID_KOKKOS_H

#include "ellgran_kokkos.h"
#include "fix_wall_gran_ellipsoid.h"

namespace LAMMPS_NS {

class FixWallGranEllipsoidKokkos : public EllgranKokkosFix<FixWallGranEllipsoid> {
 public:
  FixWallGranEllipsoidKokkos(LAMMPS *lmp, int narg, char **arg) :
      EllgranKokkosFix("Fix wall/gran/ellipsoid/kk", "wall/gran/ellipsoid", lmp, narg, arg)
  {
  }
};

}    // namespace LAMMPS_NS

#endif
#endif
