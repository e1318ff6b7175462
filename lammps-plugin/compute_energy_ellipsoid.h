// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// `compute energy/ellipsoid`: the energy balance of a scene of ellipsoids.

#ifdef COMPUTE_CLASS
// clang-format off
ComputeStyle(energy/ellipsoid,ComputeEnergyEllipsoid);
// clang-format on
#else

#ifndef LMP_COMPUTE_ENERGY_ELLIPSOID_H
#define LMP_COMPUTE_ENERGY_ELLIPSOID_H

#include "compute.h"

#include <string>

namespace LAMMPS_NS {

class ComputeEnergyEllipsoid : public Compute {
 public:
  ComputeEnergyEllipsoid(class LAMMPS *, int, char **);
  ~ComputeEnergyEllipsoid() override;

  void init() override;
  void compute_vector() override;

 private:
  std::string id_balance;
  class FixEllgranEnergyBalance *balance;    // follows each step, and has what restart files keep
};

}    // namespace LAMMPS_NS

#endif
#endif
