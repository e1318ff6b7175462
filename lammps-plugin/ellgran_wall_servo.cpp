// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_wall_servo.h"

#include "error.h"
#include "modify.h"
#include "update.h"
#include "utils.h"

#include <cmath>
#include <mpi.h>

using namespace LAMMPS_NS;

namespace {

const char WORDS[] = "servo ax ay az target speed [area A] [gain g]";
constexpr double DEFAULT_GAIN = 0.5;

}    // namespace

WallServo::WallServo(LAMMPS *lmp, const std::string &caller_of, int narg, char **arg, int &consumed) :
    Pointers(lmp), caller(caller_of), axis{}, state(ELLGRAN_INIT(EllgranServo)), place(0.0), last_velocity(0.0),
    force_now(0.0), has_followed(false)
{
  if (narg < 5) error->all(FLERR, "{}: 'servo' needs 5 values: {}", caller, WORDS);
  double square = 0.0;
  for (int k = 0; k < 3; k++) {
    axis[k] = utils::numeric(FLERR, arg[k], false, lmp);
    square += axis[k] * axis[k];
  }
  if (!(square > 0.0 && std::isfinite(square)))
    error->all(FLERR, "{}: servo needs a direction other than {} {} {}", caller, arg[0], arg[1], arg[2]);
  for (double &component : axis) component /= std::sqrt(square);
  target_words.read(lmp, caller, "servo target", arg[3]);
  state.largest_speed = utils::numeric(FLERR, arg[4], false, lmp);
  if (!(state.largest_speed > 0.0 && std::isfinite(state.largest_speed)))
    error->all(FLERR, "{}: servo speed {} must be a finite number greater than 0", caller, arg[4]);
  state.gain = DEFAULT_GAIN;
  area_words.set(1.0);
  consumed = 5;
  bool has_area = false, has_gain = false;
  while (consumed < narg) {
    const std::string word = arg[consumed];
    if (word != "area" && word != "gain") break;
    if (consumed + 1 >= narg) error->all(FLERR, "{}: 'servo ... {}' needs a value: {}", caller, word, WORDS);
    if ((word == "area") ? has_area : has_gain) error->all(FLERR, "{}: servo {} is given twice", caller, word);
    if (word == "area") {
      has_area = true;
      area_words.read(lmp, caller, "servo area", arg[consumed + 1]);
      if (!area_words.is_variable() && !(area_words.constant() > 0.0))
        error->all(FLERR, "{}: servo area {} must be greater than 0", caller, arg[consumed + 1]);
    } else {
      has_gain = true;
      state.gain = utils::numeric(FLERR, arg[consumed + 1], false, lmp);
    }
    consumed += 2;
  }
  // The library knows the ranges.
  EllgranServo tried = state;
  tried.target = target_words.constant();
  check(ellgran_servo_follow(&tried, 0.0, 0.0, 0.0, 1.0));
}

void WallServo::check(int32_t status) const
{
  if (status != ELLGRAN_SUCCESS) error->all(FLERR, "{}: {}", caller, ellgran_last_error());
}

void WallServo::require_variables() const
{
  target_words.require_variable(lmp);
  area_words.require_variable(lmp);
}

void WallServo::advance(double time_step)
{
  last_velocity = state.velocity;
  place += last_velocity * time_step;
}

void WallServo::follow(const EllgranWallLoad &load, double time_step, bool time_passes)
{
  double here[3] = {0.0, load.stiffness, load.damping}, all[3];
  for (int k = 0; k < 3; k++) here[0] -= load.force[k] * axis[k];
  MPI_Allreduce(here, all, 3, MPI_DOUBLE, MPI_SUM, world);
  force_now = all[0];

  const bool varies = target_words.is_variable() || area_words.is_variable();
  if (varies) modify->clearstep_compute();
  const double area = area_words.value(lmp);
  if (!(area > 0.0)) error->all(FLERR, "{}: servo area {} must be greater than 0", caller, area);
  state.target = area * target_words.value(lmp);
  if (varies) modify->addstep_compute(update->ntimestep + 1);

  if (!time_passes && has_followed) return;
  check(ellgran_servo_follow(&state, force_now, all[1], all[2], time_step));
  has_followed = true;
}

void WallServo::pack(double *values) const
{
  values[0] = place;
  values[1] = last_velocity;
  values[2] = state.velocity;
  values[3] = state.steady_velocity;
  values[4] = has_followed ? 1.0 : 0.0;
}

void WallServo::unpack(const double *values)
{
  place = values[0];
  last_velocity = values[1];
  state.velocity = values[2];
  state.steady_velocity = values[3];
  has_followed = values[4] != 0.0;
}
