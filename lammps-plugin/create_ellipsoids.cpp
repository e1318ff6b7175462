// SPDX-License-Identifier: GPL-2.0-or-later

#include "create_ellipsoids.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "modify.h"
#include "region.h"
#include "utils.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;

namespace {

const char CALLER[] = "create_ellipsoids";
const char SYNTAX[] =
    "create_ellipsoids type seed region ID fill fraction|number N shape ... [scale ...] [fractions ...] [dens lo hi] [orient ...] "
    "[attempts n] [partial yes|no] [inside grain|centre] [ignore]";

// So many grains in a row without a place: the region is full.
constexpr int FULL = 20;

// More grains than that are a mistake in the units of a shape.
constexpr double MOST_GRAINS = 1.0e9;

double volume_of(const std::vector<EllgranGrain> &grains)
{
  double sum = 0.0;
  for (const EllgranGrain &grain : grains) sum += grain.volume();
  return sum;
}

}    // namespace

CreateEllipsoids::CreateEllipsoids(LAMMPS *lmp) : Command(lmp), mixture(lmp, CALLER), placement(lmp, CALLER) {}

void CreateEllipsoids::command(int narg, char **arg)
{
  placement.require_scene();
  if (modify->nfix_restart_peratom)
    error->all(FLERR, "{}: what a restart file holds of each grain has not been given to its fixes yet: give those fixes before, or "
                      "this command after 'run 0'", CALLER);
  parse(narg, arg);

  const std::vector<EllgranGrain> wanted = grains();
  placement.collect(mixture.largest(), 0.5 * std::cbrt(mixture.mean_volume()), 0.0, ignore_others);
  const std::vector<EllgranGrain> placed = place(wanted);
  const double reached = volume_of(placed) / placement.volume(), asked = volume_of(wanted) / placement.volume();
  if (placed.size() < wanted.size()) {
    const std::string what =
        fmt::format("{}: region {} is full at a solid fraction of {:.4g}: {} of {} grains found a place with {} attempts each, {:.4g} "
                    "was asked for", CALLER, region->id, reached, placed.size(), wanted.size(), most_attempts, asked);
    if (!partial)
      error->all(FLERR, "{}: ask for less, give more attempts, or take what there is by 'partial yes'", what);
    if (comm->me == 0) error->warning(FLERR, what);
  }

  placement.begin_creation();
  tagint tag = placement.greatest_tag();
  const double at_rest[3] = {0.0, 0.0, 0.0};
  for (const EllgranGrain &grain : placed) placement.create(grain, type, ++tag, 1, at_rest);
  placement.end_creation(static_cast<bigint>(placed.size()), tag);
  if (comm->me != 0) return;
  utils::logmesg(lmp, "Created {} grains\n", placed.size());
  // A region that is flat, with centres in it, has no volume.
  if (placement.volume() > 0.0)
    utils::logmesg(lmp, "  solid fraction {:.6g} of region {}, volume {:.6g}\n", reached, region->id, placement.volume());
}

void CreateEllipsoids::parse(int narg, char **arg)
{
  if (narg < 2) error->all(FLERR, "{}: type and seed are needed: {}", CALLER, SYNTAX);
  type = mixture.integer("type", arg[0]);
  if (type < 1 || type > atom->ntypes)
    error->all(FLERR, "{}: type {} is not one of the types of this box, 1 to {}", CALLER, arg[0], atom->ntypes);
  seed = mixture.integer("seed", arg[1]);
  if (seed <= 0) error->all(FLERR, "{}: seed {} must be greater than 0", CALLER, arg[1]);

  int iarg = 2;
  while (iarg < narg) {
    const std::string word = arg[iarg];
    if (mixture.parse(iarg, narg, arg)) continue;
    if (word == "ignore") {
      ignore_others = true;
      iarg++;
      continue;
    }
    const bool known = word == "region" || word == "fill" || word == "number" || word == "attempts" || word == "partial" || word == "inside";
    if (!known) error->all(FLERR, "{}: unknown word '{}': {}; {}", CALLER, word, SYNTAX, EllgranGrainMixture::SYNTAX);
    mixture.require_values(word, 1, iarg, narg);
    const std::string value = arg[iarg + 1];
    if (word == "region") {
      region = domain->get_region_by_id(value);
      if (!region) error->all(FLERR, "{}: region {} does not exist", CALLER, value);
    } else if (word == "fill") {
      fill = mixture.number(word, arg[iarg + 1]);
      if (fill <= 0.0 || fill >= 1.0) error->all(FLERR, "{}: fill {} must be between 0 and 1", CALLER, value);
    } else if (word == "number") {
      number = mixture.integer(word, arg[iarg + 1]);
      if (number < 1) error->all(FLERR, "{}: number {} must be 1 or more", CALLER, value);
    } else if (word == "attempts") {
      most_attempts = mixture.integer(word, arg[iarg + 1]);
      if (most_attempts < 1) error->all(FLERR, "{}: attempts {} must be 1 or more", CALLER, value);
    } else if (word == "partial") {
      partial = mixture.yes_or_no(word, value);
    } else {
      if (value != "grain" && value != "centre") error->all(FLERR, "{}: inside '{}' must be grain or centre", CALLER, value);
      whole_grains = (value == "grain");
    }
    iarg += 2;
  }
  if (!region) error->all(FLERR, "{}: no region given: {}", CALLER, SYNTAX);
  if ((fill > 0.0) == (number > 0))
    error->all(FLERR, "{}: give either 'fill' with a solid fraction or 'number' with a number of grains", CALLER);
  mixture.finish();
  region->init();
  region->prematch();
  placement.set_region(region, whole_grains);
}

std::vector<EllgranGrain> CreateEllipsoids::grains() const
{
  const double target = fill * placement.volume(), mean = mixture.mean_volume();
  if (target > MOST_GRAINS * mean)
    error->all(FLERR, "{}: fill {} of region {} would be {:.3g} grains of mean volume {:.4g}: are the diameters of 'shape' in the units "
                      "of the box?", CALLER, fill, region->id, target / mean, mean);
  // Those on the edge of a region may stick out of it.
  double room = 1.0;
  for (int k = 0; k < 3; k++) room *= placement.high()[k] - placement.low()[k] + 2.0 * mixture.largest();
  if (static_cast<double>(number) * mean > room)
    error->all(FLERR, "{}: number {} of grains of mean volume {:.4g} is more than there is room for in and around region {}, {:.4g}: ask for "
                      "less, or give 'fill' a solid fraction", CALLER, number, mean, region->id, room);
  std::vector<EllgranGrain> wanted;
  double volume = 0.0;
  while (true) {
    EllgranRandom looks(seed, EllgranRandom::LOOK, wanted.size());
    const EllgranGrain next = mixture.grain(looks);
    // The number that comes closest.
    if (number > 0 ? static_cast<bigint>(wanted.size()) >= number : volume + 0.5 * next.volume() > target) break;
    volume += next.volume();
    wanted.push_back(next);
  }
  if (wanted.empty())
    error->all(FLERR, "{}: fill {} of region {}, volume {:.4g}, is less than one grain of mean volume {:.4g}", CALLER, fill, region->id,
               placement.volume(), mean);
  std::stable_sort(wanted.begin(), wanted.end(),
                   [](const EllgranGrain &a, const EllgranGrain &b) { return a.volume() > b.volume(); });
  return wanted;
}

std::vector<EllgranGrain> CreateEllipsoids::place(std::vector<EllgranGrain> wanted)
{
  const double *low = placement.low(), *high = placement.high();
  std::vector<EllgranGrain> placed;
  int without = 0;
  for (std::size_t k = 0; k < wanted.size() && without < FULL; k++) {
    EllgranRandom places(seed, EllgranRandom::PLACE, k);
    EllgranGrain &grain = wanted[k];
    bool found = false;
    for (int attempt = 0; attempt < most_attempts && !found; attempt++) {
      for (int a = 0; a < 3; a++) grain.position[a] = places.uniform(low[a], high[a]);
      mixture.orient(grain, places);
      found = placement.is_free(grain);
    }
    without = found ? 0 : without + 1;
    if (!found) continue;
    placement.add(grain);
    placed.push_back(grain);
  }
  return placed;
}
