// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// `fix pour/ellipsoid`: a stream of ellipsoids into a region, in the words of LAMMPS' `fix pour`.

#ifdef FIX_CLASS
// clang-format off
FixStyle(pour/ellipsoid,FixPourEllipsoid);
// clang-format on
#else

#ifndef LMP_FIX_POUR_ELLIPSOID_H
#define LMP_FIX_POUR_ELLIPSOID_H

#include "fix.h"

#include "ellgran_grain_mixture.h"
#include "ellgran_grain_placement.h"

#include <string>

namespace LAMMPS_NS {

class FixPourEllipsoid : public Fix {
 public:
  FixPourEllipsoid(class LAMMPS *, int, char **);

  int setmask() override;
  void init() override;
  void setup_pre_exchange() override;
  void pre_exchange() override;
  double compute_scalar() override;
  double compute_vector(int) override;
  void reset_dt() override;
  /// "radius": the largest semi-axis that a grain of a type may have.
  void *extract(const char *, int &) override;
  void write_restart(FILE *) override;
  void restart(char *) override;

 private:
  std::string caller;
  EllgranGrainMixture mixture;
  EllgranGrainPlacement placement;

  // Words
  bigint wanted = 0;
  int type = 0, seed = 0;
  std::string region_id;
  double solid_fraction = 0.25;
  int most_attempts = 50;
  double rate = 0.0, flow = 0.0;
  double velocity_low[2] = {}, velocity_high[2] = {}, velocity_down = 0.0;
  bool flow_given = false, whole_grains = true, ignore_others = false, next_tags = false;

  // What goes on over a restart.
  bool started = false;
  bigint inserted = 0, events = 0, next_step = 0, last_tag = 0, clock_step = 0;
  double clock = 0.0, clock_time_step = 0.0;
  double inserted_volume = 0.0, inserted_mass = 0.0;

  // What follows from words and scene when a run starts.
  double gravity = 0.0, fall_time = 0.0;
  bigint interval = 1;
  double per_event = 0.0;
  double largest_radius = 0.0;

  void parse(int narg, char **arg);
  void parse_velocity(int iarg, char **arg);
  double gravity_now() const;
  bool plan();
  void tell_plan() const;
  [[nodiscard]] double time_now() const;
  void advance_clock();
  [[nodiscard]] bigint steps_in(double time) const;
  [[nodiscard]] bool is_due(const EllgranGrain &grain, bigint done) const;
  bool place(EllgranGrain &grain, EllgranRandom &random, bigint &attempts, double &falling);
};

}    // namespace LAMMPS_NS

#endif
#endif
