// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_contact_sources.h"

#include "fix_wall_gran_ellipsoid.h"
#include "pair_gran_ellipsoid.h"

#include "compute.h"
#include "force.h"
#include "lammps.h"
#include "modify.h"
#include "utils.h"

using namespace LAMMPS_NS;

void EllgranContactSources::find(LAMMPS *lmp)
{
  const char PAIR_STYLE[] = "gran/ellipsoid";
  pairs.clear();
  walls.clear();
  const auto add = [this](Pair *found) {
    if (auto *ours = dynamic_cast<PairGranEllipsoid *>(found)) pairs.push_back(ours);
  };
  Force *const force = lmp->force;
  if (utils::strmatch(force->pair_style ? force->pair_style : "", "^hybrid")) {
    for (int number = 1; Pair *found = force->pair_match(PAIR_STYLE, 0, number); number++) {
      // One alone is found by every number.
      if (!pairs.empty() && found == pairs.front()) break;
      add(found);
    }
  } else if (Pair *found = force->pair_match(PAIR_STYLE, 0))
    add(found);
  for (auto *fix : lmp->modify->get_fix_by_style("^wall/gran/ellipsoid"))
    if (auto *wall = dynamic_cast<FixWallGranEllipsoid *>(fix)) walls.push_back(wall);
}

bool LAMMPS_NS::computes_ask_for_contacts(Modify *modify, bigint step)
{
  bool ask = false;
  for (auto *compute : modify->get_compute_by_style("^contact/ellipsoid/atom$")) ask |= compute->matchstep(step) != 0;
  return ask;
}
