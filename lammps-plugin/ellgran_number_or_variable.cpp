// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_number_or_variable.h"

#include "error.h"
#include "input.h"
#include "lammps.h"
#include "utils.h"
#include "variable.h"

#include <cmath>

using namespace LAMMPS_NS;

void NumberOrVariable::read(LAMMPS *lmp, const std::string &caller, const std::string &keyword, const char *word)
{
  where = caller + ": " + keyword;
  number = 0.0;
  variable.clear();
  if (utils::strmatch(word, "^v_")) {
    variable = word + 2;
    if (variable.empty()) lmp->error->all(FLERR, "{}: '{}' names no variable", where, word);
    return;
  }
  number = utils::numeric(FLERR, word, false, lmp);
  if (!std::isfinite(number)) lmp->error->all(FLERR, "{} value {} must be finite", where, word);
}

int NumberOrVariable::index(LAMMPS *lmp) const
{
  const int found = lmp->input->variable->find(variable.c_str());
  if (found < 0) lmp->error->all(FLERR, "{} variable v_{} does not exist", where, variable);
  if (!lmp->input->variable->equalstyle(found))
    lmp->error->all(FLERR, "{} variable v_{} must be of equal style", where, variable);
  return found;
}

void NumberOrVariable::require_variable(LAMMPS *lmp) const
{
  if (is_variable()) (void) index(lmp);
}

double NumberOrVariable::value(LAMMPS *lmp) const
{
  if (!is_variable()) return number;
  const double now = lmp->input->variable->compute_equal(index(lmp));
  if (!std::isfinite(now)) lmp->error->all(FLERR, "{} variable v_{} = {} must be finite", where, variable, now);
  return now;
}
