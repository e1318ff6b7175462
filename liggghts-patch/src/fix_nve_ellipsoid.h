/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Moves and turns rigid ellipsoids by velocity Verlet; the rotation of a free grain is exact, and forces may see velocities of the
 * step at which they are computed (the library's own integrator).
 */

#ifdef FIX_CLASS
FixStyle(nve/ellipsoid,FixNVEEllipsoid)
#else

#ifndef LMP_FIX_NVE_ELLIPSOID_H
#define LMP_FIX_NVE_ELLIPSOID_H

#include <cstdio>
#include <string>
#include <vector>

#include "ellgran.h"
#include "fix.h"

namespace LAMMPS_NS {

class FixNVEEllipsoid : public Fix {
 public:
  FixNVEEllipsoid(class LAMMPS *, int, char **);
  virtual ~FixNVEEllipsoid();
  virtual void pre_delete(bool unfixflag);
  virtual int setmask();
  virtual void init();
  virtual void setup_pre_exchange();
  virtual void setup_pre_force(int);
  virtual void setup(int);
  virtual void initial_integrate(int);
  virtual void pre_force(int);
  virtual void final_integrate();

  // Lends the library the velocities that the present forces see, or those that the last forces saw, and what they have more than
  // those of the half step; nothing where all grains leave the velocities of the half step to the forces.
  static void lend_velocities(class LAMMPS *lmp, EllgranParticles &particles);

  // what is kept goes with the particles
  virtual double memory_usage();
  virtual void grow_arrays(int count);
  virtual void copy_arrays(int from, int to, int);
  virtual void set_arrays(int particle);
  virtual int pack_exchange(int particle, double *buffer);
  virtual int unpack_exchange(int particle, double *buffer);
  virtual int pack_comm(int count, int *particles, double *buffer, int, int *);
  virtual void unpack_comm(int count, int first, double *buffer);
  virtual int size_restart(int particle);
  virtual int maxsize_restart();
  virtual int pack_restart(int particle, double *buffer);
  virtual void unpack_restart(int particle, int place);
  virtual void write_restart(FILE *fp);
  virtual void restart(char *state);

 private:
  enum Velocities { DEFAULT, STEP, HALF };

  EllgranWorkspace *workspace_;
  Velocities word_;
  FixNVEEllipsoid *keeper_;  // has the arrays for this fix too; NULL: velocities of the half step
  bool swapped_;             // of the keeper, while a run starts: v is what the last forces saw
  bool extrapolated_;        // of the keeper, while forces are computed: v is what they see
  bool ghosts_wanted_;       // of the keeper: something asks for velocities of the half step
  int step_bits_;            // of the keeper: the groups of all fixes with velocities of the step
  double time_step_before_;  // 0: not known
  bool said_half_;
  bool said_inertia_;

  // Velocity and angular momentum: with what they have more than at the half step while forces are computed, with what those had more
  // that the last forces saw between steps.
  double **changes_;
  double **loads_before_;    // force and torque when the last step began
  double **motion_changes_;  // velocity and angular velocity, more than at the half step, when forces were computed last
  std::vector<double> velocities_, momenta_, angular_velocities_;

  // The grains of this processor as the library sees them; count 0 where there are none.
  EllgranMotion motion(int group_mask) const;
  void check(int status) const;
  void refuse(const char *message) const;
  // the fixes of this style that are to hand out velocities of the step, in LIGGGHTS' order; the first one is the keeper
  static std::vector<FixNVEEllipsoid *> all_of_step(class Modify *modify);
  // the model of LIGGGHTS' own that sums up a displacement; empty if there is none
  std::string own_spring() const;
  void warn_of_other_inertia();
  void forget();
  void swap(double sign);
  void find_motion_changes();
};

}

#endif
#endif
