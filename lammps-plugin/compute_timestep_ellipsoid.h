// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// `compute timestep/ellipsoid`: the time step that the contacts of a scene of ellipsoids allow.

#ifdef COMPUTE_CLASS
// clang-format off
ComputeStyle(timestep/ellipsoid,ComputeTimestepEllipsoid);
// clang-format on
#else

#ifndef LMP_COMPUTE_TIMESTEP_ELLIPSOID_H
#define LMP_COMPUTE_TIMESTEP_ELLIPSOID_H

#include "compute.h"

#include "ellgran_scene_step.h"

#include <string>

namespace LAMMPS_NS {

class ComputeTimestepEllipsoid : public Compute {
 public:
  ComputeTimestepEllipsoid(class LAMMPS *, int, char **);
  ~ComputeTimestepEllipsoid() override;

  void init() override;
  void compute_vector() override;

 private:
  // Values of the vector. Keep README.md in step.
  enum { STABLE_STEP, SHORTEST_COLLISION, STEP_FOR_ERROR, DEEPEST_OVERLAP, LIMITING_ATOM, NUMBER_OF_VALUES };

  std::string caller;
  double energy_error;    // that is allowed in a collision
  EllgranSceneStep scene;
};

}    // namespace LAMMPS_NS

#endif
#endif
