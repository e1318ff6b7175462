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
/// displacement and the rotation over the step.
///
/// A fix that changes the box moves the atoms with it (`fix deform ... remap x`, `fix nph/asphere`, `fix press/berendsen`),
/// or their periodic images alone (`remap none`), and tells no velocity. In such a box the velocities of all atoms are found
/// from their displacements, and images have in addition the velocity with which the edges of the box change. With `fix deform
/// ... remap v` the atoms' velocities are right, and LAMMPS gives images theirs.
///
/// It does nothing where no such fix is defined.
class FixEllgranStepVelocity : public Fix {
 public:
  FixEllgranStepVelocity(class LAMMPS *, int, char **);
  ~FixEllgranStepVelocity() override;

  int setmask() override;
  void init() override;
  void setup(int) override;
  void post_integrate() override;
  void post_force(int) override;
  void end_of_step() override;

  /// True if a fix is defined whose atoms, or their images, may not carry the velocity of the half step.
  static bool needed(class Modify *modify);

  /// Lets `velocities` and `angular_momenta` point to those over the last step where the atoms' own are not those; of
  /// ghosts too if asked for. Where `velocity_changes` are lent, those that are velocities of the step stay, and their changes become
  /// what they have more than those over the step. With ghosts it communicates: all processors call it in the same step.
  void replace_velocities(EllgranParticles &particles, bool with_ghosts);

  /// Whether the box changes and its images have velocities that LAMMPS does not give them.
  [[nodiscard]] bool box_moves() const { return moving_edges != 0; }

  /// How much more the velocity of an atom, or of a ghost after `replace_velocities`, was over the last step than its own.
  [[nodiscard]] const double *found(int i) const { return difference[i]; }

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
  int moving_edges;       // components of the box, bits of Fix::BOX_CHANGE_..., whose change is in no velocity
  double edges[6];        // of the box when the step began, then when atoms have moved: `domain->h`
  double edge_rates[6];   // of the components that change so, over the last step
  double **difference;    // velocity and angular momentum over the last step less the atom's own
  double **start;         // position, velocity, quaternion when the step began, valid until atoms change processors; where
                          // the box changes the position becomes that to which the step led, which goes with the atom
  std::vector<double> velocities, angular_momenta, changes;

  void store_start(int i);
  void check(int32_t status) const;
  void follow_flip();
  void follow_images();
  void keep_velocities_of_step(EllgranParticles &particles, int count);
};

/// The fix that the pair style or wall has, which was `now` and called `id`, or nullptr where none is needed. A new one gets a name that
/// begins with `prefix` and is not taken; the owner deletes it by its ID. It stands after all fixes that change the box: what they do
/// with the positions when the atoms have moved, it must see.
FixEllgranStepVelocity *place_step_velocity(class Modify *modify, FixEllgranStepVelocity *now, const std::string &prefix,
                                            std::string &id);

}    // namespace LAMMPS_NS

#endif
