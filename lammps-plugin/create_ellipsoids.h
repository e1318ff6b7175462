// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// `create_ellipsoids`: fills a region at once with ellipsoids that do not overlap.

#ifdef COMMAND_CLASS
// clang-format off
CommandStyle(create_ellipsoids,CreateEllipsoids);
// clang-format on
#else

#ifndef LMP_CREATE_ELLIPSOIDS_H
#define LMP_CREATE_ELLIPSOIDS_H

#include "command.h"

#include "ellgran_grain_mixture.h"
#include "ellgran_grain_placement.h"

#include <string>
#include <vector>

namespace LAMMPS_NS {

class CreateEllipsoids : public Command {
 public:
  CreateEllipsoids(class LAMMPS *);
  void command(int, char **) override;

 private:
  EllgranGrainMixture mixture;
  EllgranGrainPlacement placement;

  int type = 0, seed = 0;
  double fill = 0.0;
  bigint number = 0;
  int most_attempts = 1000;
  bool whole_grains = true, partial = false, ignore_others = false;
  class Region *region = nullptr;

  void parse(int narg, char **arg);
  /// All that are wanted, the largest first.
  [[nodiscard]] std::vector<EllgranGrain> grains() const;
  [[nodiscard]] std::vector<EllgranGrain> place(std::vector<EllgranGrain> wanted);
};

}    // namespace LAMMPS_NS

#endif
#endif
