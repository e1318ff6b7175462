// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// Which of LAMMPS' own fixes and computes would go on with our grains and be wrong, and what to use in their place?

#ifndef ELLGRAN_REFUSALS_H
#define ELLGRAN_REFUSALS_H

namespace LAMMPS_NS {

class LAMMPS;

/// Stops with a message that names the fix or compute, the reason and the cure if one is defined that cannot work.
/// `caller` opens the message. `remembers`: contacts have a history, which all but frictionless spheres do.
void refuse_styles(LAMMPS *lmp, const char *caller, bool remembers);

}    // namespace LAMMPS_NS

#endif
