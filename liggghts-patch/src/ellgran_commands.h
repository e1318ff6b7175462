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

#endif
