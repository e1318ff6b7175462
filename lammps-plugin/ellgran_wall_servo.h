// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// The words and the state of `servo`: a wall that keeps the force, or the stress, with which it presses in a direction.

#ifndef ELLGRAN_WALL_SERVO_H
#define ELLGRAN_WALL_SERVO_H

#include "pointers.h"

#include "ellgran.h"
#include "ellgran_number_or_variable.h"

#include <string>

namespace LAMMPS_NS {

class WallServo : protected Pointers {
 public:
  /// Reads what follows the word *servo*; `caller` opens every message. `consumed` words were read.
  WallServo(LAMMPS *lmp, const std::string &caller, int narg, char **arg, int &consumed);

  /// Stops with a message if a variable is missing: for `Fix::init`.
  void require_variables() const;

  /// The wall has moved by a step.
  void advance(double time_step);

  /// Chooses the velocity for the next step from what acts on the wall, this rank's share. Where no time has passed, the
  /// velocity that was chosen before stays. All ranks call it.
  void follow(const EllgranWallLoad &load, double time_step, bool time_passes);

  [[nodiscard]] const double *direction() const { return axis; }
  /// Along the direction, since the servo was made.
  [[nodiscard]] double displacement() const { return place; }
  /// Over the last step.
  [[nodiscard]] double velocity() const { return last_velocity; }
  /// With which the wall presses, on all ranks, and with which it is to press.
  [[nodiscard]] double force() const { return force_now; }
  [[nodiscard]] double target() const { return state.target; }

  static constexpr int NUMBER_OF_STATES = 5;
  /// What a restart file keeps.
  void pack(double *values) const;
  void unpack(const double *values);

 private:
  std::string caller;
  double axis[3];
  NumberOrVariable target_words, area_words;
  EllgranServo state;
  double place, last_velocity, force_now;
  bool has_followed;    // a velocity for the next step is known

  void check(int32_t status) const;
};

}    // namespace LAMMPS_NS

#endif
