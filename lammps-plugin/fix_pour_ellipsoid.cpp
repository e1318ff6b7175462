// SPDX-License-Identifier: GPL-2.0-or-later

#include "fix_pour_ellipsoid.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "group.h"
#include "modify.h"
#include "neighbor.h"
#include "region.h"
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;
using namespace FixConst;

namespace {

const char STYLE[] = "Fix pour/ellipsoid";
const char SYNTAX[] =
    "fix ID group pour/ellipsoid N type seed region ID shape ... [scale ...] [fractions ...] [dens lo hi] [orient ...] "
    "[vol fraction attempts] [flow mass/time] [rate v] [vel vxlo vxhi vylo vyhi vz] [inside grain|centre] [id max|next] [ignore]";

// Tries at one height before another one is drawn: at a height where a grain does not fit no number of them would do.
constexpr int TRIES_AT_HEIGHT = 10;

// Draws of a centre until one is in the region, and of a height until a grain could fit: counted as one try.
constexpr int DRAWS = 1000;

// Part of gravity that may point away from -z, by rounding of a deck's numbers. As in fix pour.
constexpr double SIDEWAYS = 1.0e-3;
// Steps from one insertion to the next: no run has as many.
constexpr double MOST_STEPS = 1.0e15;

constexpr int NUMBER_OF_OUTPUTS = 3;
constexpr int NUMBER_OF_STATES = 10;

}    // namespace

FixPourEllipsoid::FixPourEllipsoid(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), caller(std::string(STYLE) + " " + id), mixture(lmp, caller), placement(lmp, caller)
{
  placement.require_scene();
  parse(narg, arg);

  scalar_flag = vector_flag = 1;
  extscalar = extvector = 0;
  size_vector = NUMBER_OF_OUTPUTS;
  global_freq = 1;
  time_depend = 1;
  restart_global = 1;
  force_reneighbor = 1;
  next_reneighbor = -1;
}

void FixPourEllipsoid::parse(int narg, char **arg)
{
  if (narg < 6) error->all(FLERR, "{}: N, type and seed are needed: {}", caller, SYNTAX);
  wanted = mixture.integer("N", arg[3]);
  if (wanted < 1) error->all(FLERR, "{}: N {}: the number of grains must be 1 or more", caller, arg[3]);
  type = mixture.integer("type", arg[4]);
  if (type < 1 || type > atom->ntypes)
    error->all(FLERR, "{}: type {} is not one of the types of this box, 1 to {}", caller, arg[4], atom->ntypes);
  seed = mixture.integer("seed", arg[5]);
  if (seed <= 0) error->all(FLERR, "{}: seed {} must be greater than 0", caller, arg[5]);

  Region *region = nullptr;
  int iarg = 6;
  while (iarg < narg) {
    const std::string word = arg[iarg];
    if (mixture.parse(iarg, narg, arg)) continue;
    const int values = (word == "vel") ? 5 : (word == "vol") ? 2 : (word == "ignore") ? 0 : 1;
    const bool known = word == "region" || word == "vol" || word == "flow" || word == "rate" || word == "vel" || word == "inside" ||
        word == "id" || word == "ignore";
    if (!known) error->all(FLERR, "{}: unknown word '{}': {}; {}", caller, word, SYNTAX, EllgranGrainMixture::SYNTAX);
    mixture.require_values(word, values, iarg, narg);
    const char *const value = (values > 0) ? arg[iarg + 1] : "";
    if (word == "region") {
      region = domain->get_region_by_id(value);
      if (!region) error->all(FLERR, "{}: region {} does not exist", caller, value);
      region_id = value;
    } else if (word == "vol") {
      solid_fraction = mixture.number(word, value);
      if (solid_fraction <= 0.0 || solid_fraction >= 1.0)
        error->all(FLERR, "{}: vol fraction {} must be between 0 and 1", caller, value);
      most_attempts = mixture.integer("vol attempts", arg[iarg + 2]);
      if (most_attempts < 1) error->all(FLERR, "{}: vol attempts {} must be 1 or more", caller, arg[iarg + 2]);
    } else if (word == "flow") {
      flow = mixture.number(word, value);
      if (flow <= 0.0) error->all(FLERR, "{}: flow {} must be greater than 0", caller, value);
      flow_given = true;
    } else if (word == "rate") {
      rate = mixture.number(word, value);
    } else if (word == "vel") {
      parse_velocity(iarg, arg);
    } else if (word == "inside") {
      if (std::strcmp(value, "grain") != 0 && std::strcmp(value, "centre") != 0)
        error->all(FLERR, "{}: inside '{}' must be grain or centre", caller, value);
      whole_grains = std::strcmp(value, "grain") == 0;
    } else if (word == "id") {
      if (std::strcmp(value, "max") != 0 && std::strcmp(value, "next") != 0)
        error->all(FLERR, "{}: id '{}' must be max or next", caller, value);
      next_tags = std::strcmp(value, "next") == 0;
    } else {
      ignore_others = true;
    }
    iarg += 1 + values;
  }
  if (!region) error->all(FLERR, "{}: no region given: {}", caller, SYNTAX);
  mixture.finish();
  if (velocity_down > rate)
    error->all(FLERR, "{}: vel vz {} is above the rate {} of the region: grains would leave it at its top", caller, velocity_down,
               rate);
  placement.set_region(region, whole_grains);
}

void FixPourEllipsoid::parse_velocity(int iarg, char **arg)
{
  for (int k = 0; k < 2; k++) {
    velocity_low[k] = mixture.number("vel", arg[iarg + 1 + 2 * k]);
    velocity_high[k] = mixture.number("vel", arg[iarg + 2 + 2 * k]);
    if (velocity_low[k] > velocity_high[k])
      error->all(FLERR, "{}: vel lower bound {} is above the upper bound {}", caller, velocity_low[k], velocity_high[k]);
  }
  velocity_down = mixture.number("vel", arg[iarg + 5]);
}

int FixPourEllipsoid::setmask()
{
  return PRE_EXCHANGE;
}

void FixPourEllipsoid::init()
{
  placement.require_scene();
  Region *region = domain->get_region_by_id(region_id);
  if (!region) error->all(FLERR, "{}: region {} does not exist any more", caller, region_id);
  placement.set_region(region, whole_grains);

  // New grains have the molecule 0, all of them.
  for (int k = 0; atom->molecule_flag && k < neighbor->nex_mol; k++) {
    const int excluded = neighbor->ex_mol_group[k];
    if (neighbor->ex_mol_intra[k] && (group->bitmask[excluded] & (1 | groupbit)))
      error->all(FLERR, "{}: 'neigh_modify exclude molecule/intra {}' takes the new grains for one molecule, and they would fall through one "
                        "another: give that command a group in which they are not, of the clumps alone", caller, group->names[excluded]);
  }

  // What remembers contacts reads the places of ghosts, which this fix takes for its grains.
  bool before = true;
  for (const auto *fix : modify->get_fix_list()) {
    if (fix == this) before = false;
    if (!before && utils::strmatch(fix->style, "^NEIGH_HISTORY"))
      error->all(FLERR, "{}: give 'pair_style' before this fix", caller);
  }
}

/* What pulls the grains down, positive; found when all fixes are initialised. */

double FixPourEllipsoid::gravity_now() const
{
  const auto found = modify->get_fix_by_style("^gravity");
  if (found.size() != 1)
    error->all(FLERR, "{}: there are {} fixes of style gravity: there must be one, for how fast grains fall out of the region", caller,
               found.size());
  int dim = 0;
  const auto *vector = static_cast<const double *>(found[0]->extract("gvec", dim));
  if (!vector) error->all(FLERR, "{}: fix {} does not tell its acceleration", caller, found[0]->id);
  const double magnitude = std::sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
  if (vector[2] > 0.0 || std::hypot(vector[0], vector[1]) > SIDEWAYS * magnitude)
    error->all(FLERR, "{}: gravity {} {} {} of fix {} must point along -z", caller, vector[0], vector[1], vector[2], found[0]->id);
  return magnitude;
}

void FixPourEllipsoid::setup_pre_exchange()
{
  const bool they_fall = plan();
  // A restart file may come from a run with another time step.
  if (clock_time_step != update->dt) reset_dt();
  if (!started && they_fall) {
    started = true;
    next_step = clock_step = update->ntimestep + 1;
    last_tag = placement.greatest_tag();
    tell_plan();
  }
  // A run goes on where the one before it ended, in step too.
  next_step = std::max(next_step, update->ntimestep + 1);
  next_reneighbor = (inserted < wanted) ? next_step : -1;
}

/* How often, and how many: as many grains as the region has room for in each time in which one falls through it. Whether they fall out of it in
   any number of steps. */

bool FixPourEllipsoid::plan()
{
  gravity = gravity_now();
  const double height = placement.high()[2] - placement.low()[2];
  // Seen from the region, which rises, grains start at its top with this speed downwards.
  const double speed = rate - velocity_down;
  if (gravity == 0.0 && speed == 0.0)
    error->all(FLERR, "{}: without gravity grains stay in the region: give 'vel' a vz below 0, or a fix gravity", caller);
  const double root = std::sqrt(speed * speed + 2.0 * gravity * height);
  fall_time = 2.0 * height / (speed + root);
  const bool never_fall = !(fall_time / update->dt < MOST_STEPS);
  if (never_fall && inserted < wanted && update->nsteps > 0)
    error->all(FLERR, "{}: with the time step {} grains do not fall out of the region in this run, which they do in {:.4g}: give a longer time step, or "
                      "this fix after the run", caller, update->dt, fall_time);
  interval = never_fall ? 1 : steps_in(fall_time);
  const double volume = mixture.mean_volume();
  per_event = std::floor(solid_fraction * placement.volume() / volume);
  if (flow_given) {
    const double needed = flow * fall_time / mixture.mean_density() / placement.volume();
    if (needed > solid_fraction)
      error->all(FLERR, "{}: flow {} needs a solid fraction of {:.4g} in the region, more than vol {}: give a larger region, grains "
                        "that fall faster, or a larger vol", caller, flow, needed, solid_fraction);
    if (!never_fall) per_event = flow * static_cast<double>(interval) * update->dt / (mixture.mean_density() * volume);
  }
  if (per_event <= 0.0 || (per_event < 1.0 && !flow_given))
    error->all(FLERR, "{}: no grain at a time: the region {} of volume {:.6g} filled to {} holds less than one grain of mean volume "
                      "{:.6g}: give a larger region or smaller grains", caller, region_id, placement.volume(), solid_fraction, volume);
  return !never_fall;
}

void FixPourEllipsoid::tell_plan() const
{
  if (comm->me != 0) return;
  const double remaining = static_cast<double>(wanted - inserted);
  const auto last = static_cast<bigint>((std::ceil(remaining / per_event) - 1.0) * static_cast<double>(interval));
  utils::logmesg(lmp, "  {}: {:.4g} grains every {} steps, {} by step {}\n", caller, std::min(per_event, remaining), interval, wanted, next_step + last);
}

/* Time since the first insertion, over changes of the time step. */

double FixPourEllipsoid::time_now() const
{
  return clock + static_cast<double>(std::max<bigint>(0, update->ntimestep - clock_step)) * clock_time_step;
}

void FixPourEllipsoid::advance_clock()
{
  clock = time_now();
  clock_step = std::max(clock_step, update->ntimestep);
}

/* Grains go on falling as long, in more or fewer steps. With 'timestep 0' no time passes until there is another one. */

void FixPourEllipsoid::reset_dt()
{
  if (clock_time_step == update->dt || update->dt == 0.0) return;
  advance_clock();
  const bigint left = next_step - update->ntimestep;
  if (started && left > 0) next_step = update->ntimestep + steps_in(static_cast<double>(left) * clock_time_step);
  clock_time_step = update->dt;
  interval = steps_in(fall_time);
  if (next_reneighbor > update->ntimestep) next_reneighbor = next_step;
}

bigint FixPourEllipsoid::steps_in(double time) const
{
  return std::max<bigint>(1, std::llround(std::min(time / update->dt, MOST_STEPS)));
}

bool FixPourEllipsoid::is_due(const EllgranGrain &grain, bigint done) const
{
  if (inserted >= wanted) return false;
  if (!flow_given) return done < static_cast<bigint>(per_event);
  // By the next time.
  const double mass = flow * (clock + static_cast<double>(interval) * update->dt);
  return inserted_mass + 0.5 * grain.mass() < mass;
}

/* A place for the grain, and for how long it has been falling from the top of the region. */

bool FixPourEllipsoid::place(EllgranGrain &grain, EllgranRandom &random, bigint &attempts, double &falling)
{
  const double *low = placement.low(), *high = placement.high();
  const double rise = rate * clock, margin = whole_grains ? grain.smallest() : 0.0;
  while (attempts > 0) {
    double below = 0.0;
    for (int draw = 0; draw < DRAWS; draw++) {
      falling = random.uniform(0.0, fall_time);
      below = falling * (rate - velocity_down + 0.5 * gravity * falling);
      if (below >= margin && below <= high[2] - low[2] - margin) break;
    }
    grain.position[2] = high[2] - below + rise;
    for (int k = 0; k < TRIES_AT_HEIGHT && attempts > 0; k++) {
      attempts--;
      for (int draw = 0; draw < DRAWS; draw++) {
        grain.position[0] = random.uniform(low[0], high[0]);
        grain.position[1] = random.uniform(low[1], high[1]);
        if (placement.is_inside(grain.position)) break;
      }
      mixture.orient(grain, random);
      if (placement.is_free(grain)) return true;
    }
  }
  return false;
}

void FixPourEllipsoid::pre_exchange()
{
  if (next_reneighbor != update->ntimestep) return;
  advance_clock();
  if (gravity_now() != gravity) error->all(FLERR, "{}: gravity must not change in a run", caller);
  const double rise = rate * clock;
  if ((domain->boundary[2][1] == 1 && placement.high()[2] + rise > domain->boxhi[2] + 1e-10 * domain->prd[2]) ||
      (domain->boundary[2][0] == 1 && placement.low()[2] + rise < domain->boxlo[2] - 1e-10 * domain->prd[2]))
    error->all(FLERR, "{}: rate {} has moved region {} out of the simulation box: give a higher box or a lower rate", caller, rate,
               region_id);

  placement.collect(mixture.largest(), 0.5 * std::cbrt(mixture.mean_volume()), rise, ignore_others);
  placement.begin_creation();
  // Other commands may have given atoms the next IDs: contacts are remembered by ID, and no two atoms may have the same.
  const tagint greatest = placement.greatest_tag();
  last_tag = next_tags ? std::max<bigint>(last_tag, greatest) : greatest;

  EllgranRandom places(seed, EllgranRandom::PLACE, events);
  const double expected = std::min(per_event, static_cast<double>(wanted - inserted));
  bigint attempts = static_cast<bigint>(std::ceil(expected) + 1.0) * most_attempts, done = 0;
  bool complete = true;
  while (true) {
    // The same grain until it finds its place: what is hard to place is not rarer than it should be.
    EllgranRandom looks(seed, EllgranRandom::LOOK, inserted);
    EllgranGrain grain = mixture.grain(looks);
    double velocity[3], falling = 0.0;
    for (int k = 0; k < 2; k++) velocity[k] = looks.uniform(velocity_low[k], velocity_high[k]);
    if (!is_due(grain, done)) break;
    complete = place(grain, places, attempts, falling);
    if (!complete) break;
    velocity[2] = velocity_down - gravity * falling;
    placement.add(grain);
    last_tag++;
    placement.create(grain, type, last_tag, 1 | groupbit, velocity);
    inserted++;
    inserted_volume += grain.volume();
    inserted_mass += grain.mass();
    done++;
  }
  placement.end_creation(done, last_tag);
  if (!complete && comm->me == 0)
    error->warning(FLERR, "{}: {} of {:.4g} grains found a place at step {}: the rest come later; the region {} may be too full", caller,
                   done, expected, update->ntimestep, region_id);

  events++;
  next_step = update->ntimestep + interval;
  next_reneighbor = (inserted < wanted) ? next_step : -1;
}

double FixPourEllipsoid::compute_scalar()
{
  return static_cast<double>(inserted);
}

double FixPourEllipsoid::compute_vector(int k)
{
  const double values[NUMBER_OF_OUTPUTS] = {static_cast<double>(inserted), inserted_volume, inserted_mass};
  return values[k];
}

void *FixPourEllipsoid::extract(const char *name, int &itype)
{
  if (std::strcmp(name, "radius") != 0) return nullptr;
  largest_radius = (itype == type) ? mixture.largest() : 0.0;
  itype = 0;
  return &largest_radius;
}

void FixPourEllipsoid::write_restart(FILE *file)
{
  if (comm->me != 0) return;
  const double values[NUMBER_OF_STATES] = {started ? 1.0 : 0.0,
                                           static_cast<double>(inserted),
                                           static_cast<double>(events),
                                           static_cast<double>(next_step),
                                           static_cast<double>(last_tag),
                                           static_cast<double>(clock_step),
                                           clock,
                                           clock_time_step,
                                           inserted_volume,
                                           inserted_mass};
  const int size = sizeof(values);
  fwrite(&size, sizeof(int), 1, file);
  fwrite(values, sizeof(double), NUMBER_OF_STATES, file);
}

void FixPourEllipsoid::restart(char *buffer)
{
  double values[NUMBER_OF_STATES];
  std::memcpy(values, buffer, sizeof values);
  started = values[0] != 0.0;
  inserted = static_cast<bigint>(values[1]);
  events = static_cast<bigint>(values[2]);
  next_step = static_cast<bigint>(values[3]);
  last_tag = static_cast<bigint>(values[4]);
  clock_step = static_cast<bigint>(values[5]);
  clock = values[6];
  clock_time_step = values[7];
  inserted_volume = values[8];
  inserted_mass = values[9];
}
