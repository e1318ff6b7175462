// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// Which pair styles and walls of ours does a scene have?

#ifndef ELLGRAN_CONTACT_SOURCES_H
#define ELLGRAN_CONTACT_SOURCES_H

#include "lmptype.h"

#include <vector>

namespace LAMMPS_NS {

struct EllgranContactSources {
  std::vector<class PairGranEllipsoid *> pairs;    // several under pair_style hybrid
  std::vector<class FixWallGranEllipsoid *> walls;

  /// To be called when a run is set up, and again where commands between runs may have taken some away.
  void find(class LAMMPS *lmp);
  [[nodiscard]] bool is_empty() const { return pairs.empty() && walls.empty(); }
};

/// Whether a compute of this plugin asks for the contacts of a step one by one, so that pair style and walls record them in it.
[[nodiscard]] bool computes_ask_for_contacts(class Modify *modify, bigint step);

}    // namespace LAMMPS_NS

#endif
