// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// Which surfaces is a region of LAMMPS made of, and where has it moved to?

#ifndef ELLGRAN_REGION_H
#define ELLGRAN_REGION_H

#include "pointers.h"

#include "ellgran.h"

#include <array>
#include <string>
#include <vector>

namespace LAMMPS_NS {

/// Adds the surfaces of a region, in the place where it has not moved, to a wall. Stops with a message that begins with `caller`
/// and names the region where it has none.
void add_region(LAMMPS *lmp, const std::string &caller, class Region *region, EllgranWall *wall);

/// All that the surfaces of a region follow from, as text: another text means that a region of that name was defined anew.
[[nodiscard]] std::string measures_of_region(class Region *region);

/// Normals of the endless planes that it has as a wall. Faces of a block count where they are not inside of the box from `low` to `high`.
[[nodiscard]] std::vector<std::array<double, 3>> planes_of_region(class Region *region, const double *low, const double *high);

/// Bounds of the blocks that grains lie around: three low ones, three high ones.
[[nodiscard]] std::vector<std::array<double, 6>> blocks_within(class Region *region);

/// Volume of a region that stays where it is, of a style with a formula: block, sphere, cylinder or cone, side in. What is
/// endless ends at `low` and `high`, three coordinates each; -1 where there is no formula.
[[nodiscard]] double volume_of_region(class Region *region, const double *low, const double *high);

/// Where a region has moved to: rotation by `angle` about the axis through `point`, then displacement.
struct RegionPose {
  double point[3], axis[3], angle, displacement[3];
};

/// The pose for this time step. Evaluates the region's variables: all ranks call it.
[[nodiscard]] RegionPose region_pose(LAMMPS *lmp, class Region *region);

}    // namespace LAMMPS_NS

#endif
