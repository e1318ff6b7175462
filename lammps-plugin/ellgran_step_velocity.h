// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// With which velocity did a grain move during the last step, where LAMMPS' own is not that one?

#ifndef ELLGRAN_STEP_VELOCITY_H
#define ELLGRAN_STEP_VELOCITY_H

#include "fix.h"

#include <string>
#include <vector>

namespace LAMMPS_NS {

/// The contact laws take velocities that belong to the half step: those with which the grains came where they are. The
/// integrators by half steps (`fix nve/asphere`) leave them in `v` while forces are computed. `fix move` leaves the
/// velocity at the end of the step, and `fix rigid` lets the body's spin act on its position at the end of the step: the
/// acceleration over half a step would leak into the tangential displacement. For the atoms of such fixes this fix keeps
/// the difference between displacement over time step and `v`. It does nothing where no such fix is defined.
class FixEllgranStepVelocity : public Fix {
 public:
  FixEllgranStepVelocity(class LAMMPS *, int, char **);
  ~FixEllgranStepVelocity() override;

  int setmask() override;
  void init() override;
  void setup(int) override;
  void post_integrate() override;
  void end_of_step() override;

  /// True if a fix is defined whose atoms do not carry the velocity of the half step.
  static bool needed(class Modify *modify);

  /// Velocities over the last step, x y z of each atom, of owned atoms and, if asked for, of ghosts; NULL where
  /// `atom->v` is right. With ghosts it communicates: all processors call it in the same step.
  const double *velocities(bool with_ghosts);

  double memory_usage() override;
  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;

  // Does what the base class does, whose symbol has the width of atom IDs in its name: not to need it
  // lets a LAMMPS with other integer sizes load the plugin, which then says what is wrong.
  void set_molecule(int, tagint, int, double *, double *, double *) override;

 private:
  int moved_bits;         // groups of fixes that prescribe motions
  int rigid_bits;         // groups of rigid bodies
  double **difference;    // velocity over the last step less `v`
  double **start;         // positions and velocities when the step began, valid until atoms change processors
  std::vector<double> result;
};

/// Adds the fix under a name that begins with `prefix` and is not taken; the owner deletes it by its ID.
FixEllgranStepVelocity *add_step_velocity(class Modify *modify, const std::string &prefix);

}    // namespace LAMMPS_NS

#endif
