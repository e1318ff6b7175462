// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// A value of a command that is a number or an equal-style variable, `v_name`.

#ifndef ELLGRAN_NUMBER_OR_VARIABLE_H
#define ELLGRAN_NUMBER_OR_VARIABLE_H

#include "lmptype.h"

#include <string>

namespace LAMMPS_NS {

class LAMMPS;

class NumberOrVariable {
 public:
  /// Reads the word. Messages begin with `caller`, and name the keyword and the word.
  void read(LAMMPS *lmp, const std::string &caller, const std::string &keyword, const char *word);

  [[nodiscard]] bool is_variable() const { return !variable.empty(); }

  /// The number; of a variable 0.
  [[nodiscard]] double constant() const { return number; }

  void set(double value) { number = value; }

  /// Stops with a message if the variable is not there or not of equal style: for `Fix::init`.
  void require_variable(LAMMPS *lmp) const;

  /// The present value. A variable is evaluated: all ranks call it, between `clearstep_compute` and `addstep_compute`.
  [[nodiscard]] double value(LAMMPS *lmp) const;

 private:
  double number = 0.0;
  std::string variable, where;

  [[nodiscard]] int index(LAMMPS *lmp) const;
};

}    // namespace LAMMPS_NS

#endif
