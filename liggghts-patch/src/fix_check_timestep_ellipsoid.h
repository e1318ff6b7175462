/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * fix check/timestep/ellipsoid: the time step that the contacts of a scene of ellipsoids allow, those with walls included, and a
 * warning or an error where the step of the run is a larger part of it than asked for. The library computes; arrays go to it.
 */

#ifdef FIX_CLASS
FixStyle(check/timestep/ellipsoid,FixCheckTimestepEllipsoid)
#else

#ifndef LMP_FIX_CHECK_TIMESTEP_ELLIPSOID_H
#define LMP_FIX_CHECK_TIMESTEP_ELLIPSOID_H

#include <vector>

#include "ellgran.h"
#include "fix.h"

namespace LIGGGHTS {
namespace ContactModels {
struct EllgranContact;
}
}

namespace LAMMPS_NS {

class FixCheckTimestepEllipsoid : public Fix {
 public:
  FixCheckTimestepEllipsoid(class LAMMPS *, int, char **);
  virtual ~FixCheckTimestepEllipsoid();
  virtual int setmask();
  virtual void init();
  virtual void setup(int vflag);
  virtual void end_of_step();
  virtual double compute_vector(int n);
  virtual double memory_usage();

 private:
  // values of the vector, in its order; README.md names them
  enum { STABLE_STEP, SHORTEST_COLLISION, STEP_FOR_ERROR, DEEPEST_OVERLAP, LIMITING_PARTICLE, NUMBER_OF_VALUES };
  double values_[NUMBER_OF_VALUES];

  double fraction_;      // of the stable step that the run may have
  double energy_error_;  // that is allowed in a collision
  bool warns_, stops_;
  bool warned_;

  EllgranWorkspace *workspace_;
  class PairGran *pair_;
  std::vector<class FixWallGranEllipsoid *> walls_;
  std::vector<double> sums_, contact_masses_;

  void check(int32_t status) const;
  bool yes_or_no(const char *keyword, const char *word);
  double number(const char *keyword, const char *word, double least, double most);
  void find();
  LIGGGHTS::ContactModels::EllgranContact *model_of_pairs() const;
};

}

#endif
#endif
