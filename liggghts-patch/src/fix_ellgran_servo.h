/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * What the controller of a fix mesh/surface/stress/servo knows goes into restart files: LIGGGHTS writes the position of the mesh, and forgets its
 * velocity, the sum of the errors and the load of the step before. Where a run begins, forces are computed with the velocity of the mesh that the last
 * forces saw, which is that of the step before: LIGGGHTS computes them with the new one. The servo of each mesh makes one such fix, of spheres too. A file without it is read as
 * LIGGGHTS reads it: the controller begins anew.
 */

#ifdef FIX_CLASS
FixStyle(ellgran/servo,FixEllgranServo)
#else

#ifndef LMP_FIX_ELLGRAN_SERVO_H
#define LMP_FIX_ELLGRAN_SERVO_H

#include <cstdio>
#include <string>

#include "fix.h"

namespace LAMMPS_NS {

class MeshModuleStressServo;

class FixEllgranServo : public Fix {
 public:
  FixEllgranServo(class LAMMPS *, int, char **);
  virtual int setmask();
  virtual void setup_pre_force(int);
  virtual void initial_integrate(int);
  virtual void pre_force(int);
  virtual void write_restart(FILE *fp);
  virtual void restart(char *state);

  // Makes the fix of this mesh anew.
  static void add(class LAMMPS *lmp, const char *mesh);

 private:
  // In restart files, in this order. Of another version is another FORMAT.
  struct State {
    double format;
    double motion[3];                    // velocity of the mesh from this step on, angular if it turns
    double motion_before[3], turned_by;  // that which the last forces saw, and the angle by which the mesh has turned since it was set
    double sum_of_errors, load_before;
  };

  std::string mesh_;
  State state_;
  bool is_of_file_;  // and the servo does not know it yet
  bool begins_;      // no step since forces were computed anew

  MeshModuleStressServo *servo() const;
  double turn_of_a_step(const MeshModuleStressServo &controller, const double *motion) const;
  void set_velocities(MeshModuleStressServo &controller, const double *motion, double turned_by) const;
};

}

#endif
#endif
