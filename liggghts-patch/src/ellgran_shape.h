/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Is a particle of LIGGGHTS' superquadrics an ellipsoid?
 */

#ifndef ELLGRAN_SHAPE_H
#define ELLGRAN_SHAPE_H

#include <cstdio>

#include "atom.h"
#include "error.h"
#include "lammps.h"

// Stops with a message that names the particle, its blockiness and the command that needs an ellipsoid.
inline void ellgran_check_blockiness(LAMMPS_NS::LAMMPS *lmp, const char *command, int i)
{
  const double *const blockiness = lmp->atom->blockiness[i];
  if (blockiness[0] == 2.0 && blockiness[1] == 2.0) return;
  char message[200];
  snprintf(message, sizeof(message), "ellgran: particle %d: blockiness %g %g: %s needs blockiness 2 2, an ellipsoid",
           static_cast<int>(lmp->atom->tag[i]), blockiness[0], blockiness[1], command);
  lmp->error->one(FLERR, message);
}

#endif
