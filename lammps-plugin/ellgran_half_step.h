// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// When do atoms have the velocities of the half step that follows the forces? A fix that says so.

#ifndef ELLGRAN_HALF_STEP_H
#define ELLGRAN_HALF_STEP_H

#include "fix.h"

#include <functional>
#include <string>

namespace LAMMPS_NS {

/// After the first half of a time integration atoms have moved, with the velocities to which the last forces have led, and
/// still stand in the order in which those forces were computed.
class FixEllgranHalfStep : public Fix {
 public:
  FixEllgranHalfStep(class LAMMPS *, int, char **);

  std::function<void()> after_half_step;

  int setmask() override;
  void post_integrate() override;

  // Does what the base class does, whose symbol has the width of atom IDs in its name: not to need it
  // lets a LAMMPS with other integer sizes load the plugin, which then says what is wrong.
  void set_molecule(int, tagint, int, double *, double *, double *) override;
};

/// Adds such a fix.
FixEllgranHalfStep *add_half_step(class Modify *modify, const std::string &id);

}    // namespace LAMMPS_NS

#endif
