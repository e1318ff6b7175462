// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// By how much is a wall faster when forces are computed than in the middle of the step that led there?

#ifndef ELLGRAN_WALL_VELOCITY_H
#define ELLGRAN_WALL_VELOCITY_H

namespace LAMMPS_NS {

/// What the velocity at the step has more than that of the half step, of a motion whose velocity is known from step to step alone.
class WallVelocityAtStep {
 public:
  static constexpr int COUNT = 4;    // velocity (3), and the rate of a rotation

  /// By so much has the velocity grown over a step, half of it since the half step. Where its growth turns from one step to the next, as
  /// that of a wall which swings with the force on it, it is left at that of the half step, which is stable.
  void grow(const double (&growth)[COUNT]);

  /// The velocity is that of this instant.
  void stand();

  [[nodiscard]] const double *change() const { return changes; }

  static constexpr int NUMBER_OF_STATES = 2 * COUNT;
  /// What a restart file keeps.
  void pack(double *values) const;
  void unpack(const double *values);

 private:
  double changes[COUNT] = {}, last_growth[COUNT] = {};
};

}    // namespace LAMMPS_NS

#endif
