/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "ellgran_commands.h"

#include <cstdio>
#include <cstring>

#include "comm.h"
#include "compute.h"
#include "compute_pair_gran_local.h"
#include "error.h"
#include "fix.h"
#include "fix_contact_history_ellgran.h"
#include "fix_heat_gran_conduction.h"
#include "modify.h"
#include "neighbor.h"
#include "update.h"

using namespace LAMMPS_NS;

namespace {

struct Refusal {
  const char *style;
  const char *reason;
};

const char *const NO_SEMI_AXES =
    "gives grains a radius and no semi-axes; use particletemplate/superquadric with blockiness 2 2";
const char *const NO_CLUMPS = "does not carry the shape and orientation of ellipsoids; clumps of ellipsoids are not available";
const char *const NO_ROTATION = "does not turn ellipsoids by their inertia; use nve/ellipsoid or nve/superquadric";
// as class Neighbor numbers its styles
const int MULTI = 2;
const char *const BOUNDING_SPHERE = "takes each grain for its bounding sphere";

const Refusal FIXES[] = {
    {"particletemplate/sphere", NO_SEMI_AXES},
    {"particletemplate/multisphere", NO_SEMI_AXES},
    {"particletemplate/multiplespheres", NO_SEMI_AXES},
    {"multisphere", NO_CLUMPS},
    {"multisphere/nointegration", NO_CLUMPS},
    {"multisphere/break", NO_CLUMPS},
    {"concave", NO_CLUMPS},
    {"rigid", NO_CLUMPS},
    {"nve/sphere", NO_ROTATION},
    {"buoyancy", BOUNDING_SPHERE},
    {"massflow/mesh/sieve", BOUNDING_SPHERE},
    {"spring/rg", "takes masses of types, which LIGGGHTS' grains have not, and crashes, beside its own spheres too"},
    {"multicontact/halfspace", "needs surface multicontact, which knows spheres alone"},
};

const Refusal COMPUTES[] = {
    {"contact/atom",
     "counts bounding spheres that overlap; compute pair/gran/local has one row for each contact"},
    {"contact/atom/gran",
     "counts bounding spheres that overlap; compute pair/gran/local has one row for each contact"},
    {"erotate/sphere", "takes each grain for a sphere; use erotate/superquadric"},
    {"erotate/sphere/atom", "takes each grain for a sphere; use erotate/superquadric"},
};

void refuse(LAMMPS *lmp, const char *kind, const char *id, const char *style, const char *reason)
{
  char message[400];
  snprintf(message, sizeof(message), "surface ellipsoid: %s %s (%s) %s", kind, id, style, reason);
  lmp->error->all(FLERR, message);
}

// what these fixes keep to themselves
struct Conduction : public FixHeatGranCond {
  // the first of the modes is 'overlap', the second 'constant'
  static bool is_constant(FixHeatGranCond *fix) { return fix->*(&Conduction::area_calculation_mode_) == 1; }
};

void check_local(LAMMPS *lmp, ComputePairGranLocal *compute)
{
  if (compute->offset_ms_id1() >= 0 && lmp->modify->n_fixes_style("multisphere") == 0)
    refuse(lmp, "compute", compute->id, compute->style, "has ms_id, which needs fix multisphere");
  if (compute->offset_heat() >= 0 && (compute->offset_contact_point() >= 0 || compute->offset_ms_id1() >= 0))
    refuse(lmp, "compute", compute->id, compute->style,
           "has heatFlux with contactPoint or ms_id: LIGGGHTS writes the flux over the last of them; leave one out");
}

}

void ellgran_check_commands(LAMMPS *lmp)
{
  if (strcmp(lmp->update->integrate_style, "verlet") != 0)
    lmp->error->all(FLERR, "surface ellipsoid needs run_style verlet: with respa grains bounce wrongly, with LIGGGHTS' own models too");
  if (lmp->neighbor->style == MULTI)
    lmp->error->all(FLERR, "surface ellipsoid: 'neighbor ... multi' finds no pairs of grains in this LIGGGHTS, of its own models too; "
                           "use 'neighbor ... bin'");
  // 2: of a minimisation, as class Update has it
  if (lmp->update->whichflag == 2)
    lmp->error->all(FLERR, "surface ellipsoid: 'minimize' follows the energy of contacts, which is zero here as with LIGGGHTS' own models, and would throw "
                           "grains away; let them come to rest in a run with fix viscous");
  Modify *const modify = lmp->modify;
  for (int k = 0; k < modify->nfix; k++) {
    Fix *const fix = modify->fix[k];
    for (size_t r = 0; r < sizeof(FIXES) / sizeof(FIXES[0]); r++)
      if (strcmp(fix->style, FIXES[r].style) == 0) refuse(lmp, "fix", fix->id, fix->style, FIXES[r].reason);
    if (strcmp(fix->style, "move") == 0 && lmp->comm->me == 0) {
      char message[200];
      snprintf(message, sizeof(message), "surface ellipsoid: fix %s (move) carries ellipsoids and does not turn them", fix->id);
      lmp->error->warning(FLERR, message);
    }
    FixHeatGranCond *const conduction = dynamic_cast<FixHeatGranCond *>(fix);
    if (conduction && !Conduction::is_constant(conduction))
      refuse(lmp, "fix", fix->id, fix->style,
             "takes the contact area from bounding spheres; give it 'contact_area constant A'");
  }
  for (int k = 0; k < modify->ncompute; k++) {
    Compute *const compute = modify->compute[k];
    for (size_t r = 0; r < sizeof(COMPUTES) / sizeof(COMPUTES[0]); r++)
      if (strcmp(compute->style, COMPUTES[r].style) == 0)
        refuse(lmp, "compute", compute->id, compute->style, COMPUTES[r].reason);
    if (strcmp(compute->style, "pair/gran/local") == 0 || strcmp(compute->style, "wall/gran/local") == 0)
      check_local(lmp, static_cast<ComputePairGranLocal *>(compute));
  }
}

void ellgran_note_change_of_fixes(LAMMPS *lmp)
{
  FixContactHistoryEllgran *const fix = FixContactHistoryEllgran::find(lmp);
  if (fix) fix->note_change("fixes");
}

void ellgran_note_change_of_computes(LAMMPS *lmp)
{
  FixContactHistoryEllgran *const fix = FixContactHistoryEllgran::find(lmp);
  if (fix) fix->note_change("computes");
}

void ellgran_check_no_setup(LAMMPS *lmp)
{
  const FixContactHistoryEllgran *const fix = FixContactHistoryEllgran::find(lmp);
  if (!fix || !fix->what_has_changed()) return;
  char message[300];
  snprintf(message, sizeof(message),
           "run ... pre no: %s were added, given again or removed since the run before was set up, and this one would go on with those of "
           "before: leave 'pre no' out",
           fix->what_has_changed());
  lmp->error->all(FLERR, message);
}
