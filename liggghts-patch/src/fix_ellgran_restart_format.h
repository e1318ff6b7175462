/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Which version of our values does a restart file of LIGGGHTS hold? LIGGGHTS itself writes and reads the histories of contacts
 * (fix contacthistory, fix contacthistory/mesh, and fix property/atom for the walls); this fix, which the contact models make,
 * adds the version of what these values mean. It has nothing to do with the version of the library's binary interface.
 *
 * Version 1, a file without this fix, and version 2 hold, of each contact, in this order:
 *   surface ellipsoid: unit normal of the last step (3 values), and for walls whether the contact touched (1);
 *   tangential tfd: what is remembered of the tangential displacement (3), and its energy (1) unless totalDisplacement is on;
 *     where the surface is not ellipsoid, the normal (3) and whether the contact touched (1).
 *
 * Raise VERSION when a value is added, removed, moved or changes its meaning, and keep the code that reads the older ones.
 * tests/restart_files has a file of each version, and tests/liggghts/restart_files.rs reads them all.
 */

#ifdef FIX_CLASS
FixStyle(ellgran/restart_format,FixEllgranRestartFormat)
#else

#ifndef LMP_FIX_ELLGRAN_RESTART_FORMAT_H
#define LMP_FIX_ELLGRAN_RESTART_FORMAT_H

#include <cstdio>

#include "fix.h"

namespace LAMMPS_NS {

class FixEllgranRestartFormat : public Fix {
 public:
  enum { VERSION = 2 };

  FixEllgranRestartFormat(class LAMMPS *, int, char **);
  virtual int setmask() { return 0; }
  virtual void write_restart(FILE *fp);
  virtual void restart(char *state);

  // Makes the fix unless it is there. Call it when a run begins.
  static void add(class LAMMPS *lmp);
};

}

#endif
#endif
