/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Moves and turns rigid ellipsoids by velocity Verlet; the rotation of a free grain is exact (the library's own integrator). */

#ifdef FIX_CLASS
FixStyle(nve/ellipsoid,FixNVEEllipsoid)
#else

#ifndef LMP_FIX_NVE_ELLIPSOID_H
#define LMP_FIX_NVE_ELLIPSOID_H

#include "ellgran.h"
#include "fix.h"

namespace LAMMPS_NS {

class FixNVEEllipsoid : public Fix {
 public:
  FixNVEEllipsoid(class LAMMPS *, int, char **);
  virtual ~FixNVEEllipsoid();
  virtual int setmask();
  virtual void init();
  virtual void initial_integrate(int);
  virtual void final_integrate();

 private:
  EllgranWorkspace *workspace_;

  // The grains of this processor as the library sees them; count 0 where there are none.
  EllgranMotion motion() const;
  void check(int status) const;
};

}

#endif
#endif
