// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_half_step.h"

#include "ellgran_substitute.h"

#include "error.h"

using namespace LAMMPS_NS;

FixEllgranHalfStep::FixEllgranHalfStep(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg) {}

int FixEllgranHalfStep::setmask()
{
  return FixConst::POST_INTEGRATE;
}

void FixEllgranHalfStep::post_integrate()
{
  if (after_half_step) after_half_step();
}

void FixEllgranHalfStep::set_molecule(int, tagint, int, double *, double *, double *)
{
  error->all(FLERR, "Molecule update not implemented for fix {}", style);
}

FixEllgranHalfStep *LAMMPS_NS::add_half_step(Modify *modify, const std::string &id)
{
  const SubstituteFix<FixEllgranHalfStep> substitute(modify, "DUMMY");
  return static_cast<FixEllgranHalfStep *>(modify->add_fix(id + " all DUMMY"));
}
