/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Where a run begins, forces are computed with the velocities of a mesh of fix move/mesh that the last forces saw: LIGGGHTS sets them to zero then, and
 * leaves them out of restart files. The fixes move/mesh of each mesh make one such fix, beside spheres too. After a file without it the mesh is at rest
 * when the first forces are computed.
 */

#ifdef FIX_CLASS
FixStyle(ellgran/mesh_motion,FixEllgranMeshMotion)
#else

#ifndef LMP_FIX_ELLGRAN_MESH_MOTION_H
#define LMP_FIX_ELLGRAN_MESH_MOTION_H

#include <cstdio>
#include <string>
#include <vector>

#include "fix.h"

namespace LAMMPS_NS {

class TriMesh;

class FixEllgranMeshMotion : public Fix {
 public:
  FixEllgranMeshMotion(class LAMMPS *, int, char **);
  virtual int setmask();
  virtual void setup_pre_force(int);
  virtual void pre_force(int) { has_moved_ = true; }
  virtual void write_restart(FILE *fp);
  virtual void restart(char *state);

  // Makes the fix of this mesh anew: it has another motion from now on.
  static void add(class LAMMPS *lmp, const std::string &mesh);
  // Whether the velocities that the mesh has are those that the last forces saw.
  static bool knows(class LAMMPS *lmp, const std::string &mesh);

 private:
  std::string mesh_;
  bool has_moved_;
  std::vector<double> of_file_;  // of each triangle its ID, and the velocities of its corners
  std::vector<double> points_of_file_;  // about which the motions turn, in their order, where motions before them have carried these points

  TriMesh *mesh() const;
  std::vector<class FixMoveMesh *> motions() const;
};

}

#endif
#endif
