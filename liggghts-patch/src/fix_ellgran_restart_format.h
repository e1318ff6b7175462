/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Which version of our values does a restart file of LIGGGHTS hold? LIGGGHTS itself writes and reads the histories of contacts
 * (fix contacthistory, fix contacthistory/mesh), and fix wall/gran/ellipsoid those of walls; this fix, which the contact models
 * make, adds the version of what these values mean. It has nothing to do with the version of the library's binary interface.
 *
 * Version 1, a file without this fix. The history of a contact holds, in this order:
 *   surface ellipsoid: unit normal of the last step (3 values), and for walls whether the contact touched (1);
 *   tangential tfd: what is remembered of the tangential displacement (3), and its energy (1) unless totalDisplacement is on;
 *     where the surface is not ellipsoid, the normal (3) and whether the contact touched (1).
 * The histories of a wall are in fixes property/atom contacts_ID_1, contacts_ID_2, ...: for each contact a flag, the point from the
 * particle's centre, the normal out of the wall, the history.
 *
 * Version 2. Histories of pairs as in version 1; those of walls do not begin with normal and flag. A wall's memory is in the
 * fix itself, as the library lays it out (src/walls/histories.rs).
 *
 * Version 3. As version 2. A wall's fix has in words what its contacts remember, and this fix has the names of the values of pairs: models under
 * which they mean something else do not read them.
 *
 * Raise VERSION when a value is added, removed, moved or changes its meaning, and keep the code that reads the older ones.
 * tests/restart_files has a file of each older version, and tests/liggghts/restart_files.rs reads them all.
 */

#ifdef FIX_CLASS
FixStyle(ellgran/restart_format,FixEllgranRestartFormat)
#else

#ifndef LMP_FIX_ELLGRAN_RESTART_FORMAT_H
#define LMP_FIX_ELLGRAN_RESTART_FORMAT_H

#include <cstdio>
#include <string>

#include "fix.h"

namespace LAMMPS_NS {

class FixEllgranRestartFormat : public Fix {
 public:
  enum { VERSION = 3 };

  FixEllgranRestartFormat(class LAMMPS *, int, char **);
  virtual int setmask() { return 0; }
  virtual void write_restart(FILE *fp);
  virtual void restart(char *state);

  // Makes the fix unless it is there. Call it when a run begins.
  static void add(class LAMMPS *lmp);

  // Whether particles and contacts come from a restart file that has this fix.
  static bool has_read(class LAMMPS *lmp);

  // It is there from the first run to 'clear', and so knows what a pair style that is given again does not: what contacts of pairs remembered
  // was lost with the one before. Of this rank.
  static void note_lost_histories(class Modify *modify);
  // Whether that has happened on any rank since the last call.
  static bool take_lost_histories(class LAMMPS *lmp);
  // Names of the values that contacts of pairs remembered when the restart file was written, once: empty if there was none, of versions
  // before 3 too.
  static std::string take_names_of_file(class LAMMPS *lmp);

 private:
  int histories_lost_;
  bool has_read_;
  std::string names_of_file_;
};

}

#endif
#endif
