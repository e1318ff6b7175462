/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Which fixes and computes of LIGGGHTS' own would be wrong about ellipsoids without saying so?
 */

#ifndef ELLGRAN_COMMANDS_H
#define ELLGRAN_COMMANDS_H

#include "lammps.h"

// Stops with a message that names the command and the cure, if the deck has such a command. All fixes and computes exist
// when a run begins, which is when to call it.
void ellgran_check_commands(LAMMPS_NS::LAMMPS *lmp);

// LIGGGHTS lists which fix does what when a run is set up. 'run ... pre no' takes the list of the run before, by numbers that mean other fixes, or none,
// once one was added, given again or removed. Of computes it keeps addresses, and leaves new ones without their beginning. LIGGGHTS' own 'modify' and
// 'run' call these three.
void ellgran_note_change_of_fixes(LAMMPS_NS::LAMMPS *lmp);
void ellgran_note_change_of_computes(LAMMPS_NS::LAMMPS *lmp);
void ellgran_check_no_setup(LAMMPS_NS::LAMMPS *lmp);

#endif
