// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// Which time step do the grains of a scene allow? Asked when a run starts, for the log and for a warning.

#ifndef ELLGRAN_STEP_LIMITS_H
#define ELLGRAN_STEP_LIMITS_H

#include "pointers.h"

#include "ellgran_atoms.h"

#include <string>
#include <vector>

namespace LAMMPS_NS {

class EllgranStepLimits : protected Pointers {
 public:
  /// `caller` opens the warning, for example "Pair gran/ellipsoid".
  EllgranStepLimits(class LAMMPS *lmp, const std::string &caller);

  /// Finds the limits for contacts between the grains of each pair of types that `used` names, on all ranks, by the
  /// smallest grain of each type at the greatest speed in the system. `parameters` and `used` are row-major over types
  /// 0 ... ntypes-1.
  void find(const EllgranAtoms &atoms, const EllgranLaws *laws,
            const std::vector<EllgranLawParameters> &parameters, const std::vector<uint8_t> &used);

  /// One line for the log; empty if there are no grains.
  [[nodiscard]] std::string describe() const;

  /// What is wrong with the time step of the run; empty if nothing is.
  [[nodiscard]] std::string excess() const;

 private:
  struct Limit {
    double time;
    int i, j;    // the types whose contact it belongs to
  };

  std::string caller;
  Limit rayleigh, collision, critical;
  double speed;    // of the fastest grain
};

}    // namespace LAMMPS_NS

#endif
