// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// Which time step do all contacts of a scene allow, as they are, those with walls included? Passes arrays and sums; computes no physics.

#ifndef ELLGRAN_SCENE_STEP_H
#define ELLGRAN_SCENE_STEP_H

#include "pointers.h"

#include "ellgran_atoms.h"
#include "ellgran_contact_sources.h"

#include <string>
#include <vector>

namespace LAMMPS_NS {

class EllgranSceneStep : protected Pointers {
 public:
  /// `caller` opens every message, for example "Compute timestep/ellipsoid 1".
  EllgranSceneStep(class LAMMPS *lmp, const std::string &caller);
  ~EllgranSceneStep() override;
  EllgranSceneStep(const EllgranSceneStep &) = delete;
  EllgranSceneStep &operator=(const EllgranSceneStep &) = delete;

  /// The pair styles and walls of ours; to be called when a run is set up.
  void find_sources() { sources.find(lmp); }

  /// Whether there are any; and the first of the pair styles, or nullptr.
  [[nodiscard]] bool has_sources() const { return !sources.is_empty(); }
  [[nodiscard]] const class PairGranEllipsoid *first_pair() const { return sources.pairs.empty() ? nullptr : sources.pairs.front(); }

  /// Looks at all contacts. All ranks call it, after neighbour lists are built.
  void find();

  /// What was found, the same on all ranks: infinite, and 0, where nothing touches.
  [[nodiscard]] double stable_step() const { return step; }
  [[nodiscard]] tagint limiting_particle() const { return limiting; }
  [[nodiscard]] double shortest_collision() const;
  [[nodiscard]] double deepest_overlap() const { return extremes.deepest_overlap; }

  /// The longest stable step with which that collision keeps its energy to `error`. All ranks call it.
  [[nodiscard]] double step_for_error(double error) const;

 private:
  EllgranAtoms atoms;
  std::string caller;
  EllgranWorkspace *workspace;
  EllgranContactSources sources;

  std::vector<double> sums, contact_masses;
  double step;
  tagint limiting;
  EllgranContactExtremes extremes;    // of all ranks
  const EllgranLaws *laws;            // of the shortest collision, on the rank that has it; else nullptr

  void check(int32_t status) const;
};

}    // namespace LAMMPS_NS

#endif
