/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * When must the histories that the library keeps be in LIGGGHTS' own arrays? When neighbour lists are built anew, before fix
 * contacthistory reads them, and when a run ends, since commands between runs read them too.
 *
 * Of all fixes LIGGGHTS calls those first whose style begins with contacthistory, in the order in which they were made. The surface model
 * makes this one when the pair style is read, so that it stands before fix contacthistory, which is made when a run begins.
 *
 * And images of particles, which LIGGGHTS gives shapes, types and masses when it builds neighbour lists, must have those that commands have
 * set before a run that goes on with the list of the one before it ('run ... pre no', 'run ... every').
 *
 * And before the first run particles must have the angular momenta of their angular velocities: LIGGGHTS reads the latter alone from data files.
 */

#ifdef FIX_CLASS
FixStyle(contacthistory/ellgran,FixContactHistoryEllgran)
#else

#ifndef LMP_FIX_CONTACT_HISTORY_ELLGRAN_H
#define LMP_FIX_CONTACT_HISTORY_ELLGRAN_H

#include "fix.h"

namespace LAMMPS_NS {

class FixContactHistoryEllgran : public Fix {
 public:
  FixContactHistoryEllgran(class LAMMPS *, int, char **);
  virtual int setmask();
  virtual void init();
  virtual void pre_exchange() { write(); }
  virtual void setup(int) { changed_ = NULL; }
  virtual void post_run();
  virtual void pre_force(int);
  virtual int pack_comm(int count, int *particles, double *buffer, int, int *);
  virtual void unpack_comm(int count, int first, double *buffer);

  // Makes the fix if it can be made and is not there. Call it when the pair style is read.
  static void add(class LAMMPS *lmp);
  // NULL if there is none.
  static FixContactHistoryEllgran *find(class LAMMPS *lmp);

  // since a run was set up: "fixes" or "computes", NULL for nothing
  void note_change(const char *what) { changed_ = what; }
  const char *what_has_changed() const { return changed_; }

  // Whether histories may stay in the library: this fix comes before fix contacthistory, and nothing else reads them in a step.
  static bool may_keep(class LAMMPS *lmp);

 private:
  void write();

  bool has_run_;
  const char *changed_;
};

}

#endif
#endif
