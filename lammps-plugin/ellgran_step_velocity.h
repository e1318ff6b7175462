// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// With which velocity did a grain move during the last step, where LAMMPS' own is not that one?

#ifndef ELLGRAN_STEP_VELOCITY_H
#define ELLGRAN_STEP_VELOCITY_H

#include "fix.h"

#include "ellgran_atoms.h"

#include <string>
#include <vector>

namespace LAMMPS_NS {

/// The contact laws take velocities that belong to the half step: those with which the grains came where they are. The
/// integrators by half steps (`fix nve/asphere`) leave them in `v` while forces are computed. `fix move` leaves the
/// velocity at the end of the step, and an angular momentum that makes the given spin only with the orientation at its
/// start; `fix rigid` lets the body's spin act on positions at the end of the step. All that would leak into the
/// tangential displacement in proportion to the step. For the atoms of such fixes this fix finds the velocities from the
/// displacement and the rotation over the step. It does nothing where no such fix is defined.
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

  /// Lets `velocities` and `angular_momenta` point to those over the last step where the atoms' own are not those; of
  /// ghosts too if asked for. Where `velocity_changes` are lent, those that are velocities of the step stay, and their changes become
  /// what they have more than those over the step. With ghosts it communicates: all processors call it in the same step.
  void replace_velocities(EllgranParticles &particles, bool with_ghosts);

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
  EllgranAtoms atoms;
  int moved_bits;         // groups of fixes that prescribe motions
  int rigid_bits;         // groups of rigid bodies
  double **difference;    // velocity and angular momentum over the last step less the atom's own
  double **start;         // position, velocity, quaternion when the step began, valid until atoms change processors
  std::vector<double> velocities, angular_momenta, changes;

  void store_start(int i);
  void keep_velocities_of_step(EllgranParticles &particles, int count);
};

/// Adds the fix under a name that begins with `prefix` and is not taken; the owner deletes it by its ID.
FixEllgranStepVelocity *add_step_velocity(class Modify *modify, const std::string &prefix);

}    // namespace LAMMPS_NS

#endif
