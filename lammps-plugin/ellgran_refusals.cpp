// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_refusals.h"

#include "comm.h"
#include "compute.h"
#include "error.h"
#include "fix.h"
#include "lammps.h"
#include "modify.h"

#include <string>

using namespace LAMMPS_NS;

namespace {

enum Grains { ALL, REMEMBERING };    // REMEMBERING: all but frictionless spheres, for which LAMMPS is right

struct Refusal {
  const char *style;    // and its variants with the suffix of an accelerator package
  Grains grains;
  const char *reason;
  const char *cure;
};

// Keep the table in README.md in step; tests/lammps/engine_commands.rs runs each of its rows.

const Refusal COMPUTES[] = {
    {"group/group", ALL, "it takes forces along the line of centres, which contact forces are not",
     "sum p21 p22 p23 of 'compute pair/local' over the pairs that 'compute property/local patom1 "
     "patom2' names"},
    {"stress/mop", ALL,
     "it takes forces along the line of centres, which contact forces are not",
     "use 'compute stress/atom' with 'compute chunk/atom', or 'compute pair/local'"},
    {"stress/mop/profile", ALL,
     "it takes forces along the line of centres, which contact forces are not",
     "use 'compute stress/atom' with 'compute chunk/atom', or 'compute pair/local'"},
    {"stress/cartesian", ALL,
     "it takes forces along the line of centres, which contact forces are not",
     "use 'compute stress/atom' with 'compute chunk/atom', or 'compute pair/local'"},
    {"stress/cylinder", ALL,
     "it takes forces along the line of centres, which contact forces are not",
     "use 'compute stress/atom' with 'compute chunk/atom', or 'compute pair/local'"},
    {"stress/spherical", ALL,
     "it takes forces along the line of centres, which contact forces are not",
     "use 'compute stress/atom' with 'compute chunk/atom', or 'compute pair/local'"},
    {"fabric", ALL, "it takes contacts of enclosing spheres and forces along the line of centres",
     "sum columns 3 to 8 of 'compute contact/ellipsoid/atom', or use normals and forces of 'compute pair/local'"},
    {"contact/atom", ALL, "it counts enclosing spheres that overlap, not contacts",
     "use 'compute contact/ellipsoid/atom'"},
    {"rattlers/atom", ALL, "it counts enclosing spheres that overlap, not contacts",
     "take column 1 of 'compute contact/ellipsoid/atom'"},
    {"force/tally", ALL, "it is not given the contact forces, and would show 0",
     "use 'compute pair/local', 'compute pe/atom' or 'compute stress/atom'"},
    {"heat/flux/tally", ALL, "it is not given the contact forces, and would show 0",
     "use 'compute pair/local', 'compute pe/atom' or 'compute stress/atom'"},
    {"heat/flux/virial/tally", ALL, "it is not given the contact forces, and would show 0",
     "use 'compute pair/local', 'compute pe/atom' or 'compute stress/atom'"},
    {"pe/tally", ALL, "it is not given the contact forces, and would show 0",
     "use 'compute pair/local', 'compute pe/atom' or 'compute stress/atom'"},
    {"pe/mol/tally", ALL, "it is not given the contact forces, and would show 0",
     "use 'compute pair/local', 'compute pe/atom' or 'compute stress/atom'"},
    {"stress/tally", ALL, "it is not given the contact forces, and would show 0",
     "use 'compute pair/local', 'compute pe/atom' or 'compute stress/atom'"},
    {"temp/sphere", ALL, "it takes spins from 'omega', which ellipsoids do not have",
     "use 'compute temp/asphere'"},
    {"erotate/sphere", ALL, "it takes spins from 'omega', which ellipsoids do not have",
     "use 'compute erotate/asphere'"},
};

const Refusal FIXES[] = {
    {"nve", REMEMBERING, "it moves grains but does not turn them",
     "use the style that ends in '/asphere'"},
    {"nvt", REMEMBERING, "it moves grains but does not turn them",
     "use the style that ends in '/asphere'"},
    {"nph", REMEMBERING, "it moves grains but does not turn them",
     "use the style that ends in '/asphere'"},
    {"npt", REMEMBERING, "it moves grains but does not turn them",
     "use the style that ends in '/asphere'"},
    {"nvt/sllod", REMEMBERING, "it moves grains but does not turn them",
     "use 'fix nve/asphere' or 'fix nvt/asphere' with 'fix deform ... remap v'"},
    {"nvt/uef", REMEMBERING, "it moves grains but does not turn them",
     "use 'fix nvt/asphere' with 'fix deform ... remap v'"},
    {"npt/uef", REMEMBERING, "it moves grains but does not turn them",
     "use 'fix npt/asphere' with 'fix deform ... remap v'"},
    {"npt/cauchy", REMEMBERING, "it moves grains but does not turn them", "use 'fix npt/asphere'"},
    {"bocs", REMEMBERING, "it moves grains but does not turn them", "use 'fix npt/asphere'"},
    {"nvk", REMEMBERING, "it moves grains but does not turn them", "use 'fix nvt/asphere'"},
    {"brownian", REMEMBERING, "it moves grains but does not turn them", "use 'fix nve/asphere' with 'fix langevin'"},
    {"nve/sphere", ALL, "it turns spheres: the orientation of ellipsoids would not change",
     "use the style that ends in '/asphere'"},
    {"nvt/sphere", ALL, "it turns spheres: the orientation of ellipsoids would not change",
     "use the style that ends in '/asphere'"},
    {"nph/sphere", ALL, "it turns spheres: the orientation of ellipsoids would not change",
     "use the style that ends in '/asphere'"},
    {"npt/sphere", ALL, "it turns spheres: the orientation of ellipsoids would not change",
     "use the style that ends in '/asphere'"},
    {"wall/gran", ALL, "it sees spheres", "use 'fix wall/gran/ellipsoid'"},
    {"wall/gran/region", ALL, "it sees spheres", "use 'fix wall/gran/ellipsoid'"},
    {"surface/global", ALL, "it sees spheres", "use 'fix wall/gran/ellipsoid ... mesh'"},
    {"surface/local", ALL, "it sees spheres", "use 'fix wall/gran/ellipsoid ... mesh'"},
    {"pour", ALL, "what it inserts has no shape",
     "use 'fix pour/ellipsoid'; to add grains at once 'create_ellipsoids'"},
    {"deposit", ALL, "what it inserts has no shape",
     "use 'fix pour/ellipsoid'; to add grains at once 'create_ellipsoids'"},
    {"gcmc", ALL, "what it inserts has no shape", "remove it"},
    {"widom", ALL, "what it inserts has no shape", "remove it"},
    {"heat/flow", ALL, "contacts conduct no heat, and temperatures would stay", "remove it"},
    {"viscous/nonlinear", ALL, "it takes the drag of enclosing spheres", "use 'fix viscous'"},
    {"damping/cundall", ALL, "it damps 'omega', which ellipsoids do not have",
     "give the law a damping, or use 'fix viscous'"},
};

// True for the style and its variants of accelerator packages.
bool is_style(const std::string &style, const std::string &name)
{
  if (style == name) return true;
  for (const char *suffix : {"/omp", "/opt", "/intel", "/gpu", "/kk", "/kk/host", "/kk/device"})
    if (style == name + suffix) return true;
  return false;
}

// The refusal that a style meets, or nullptr.
template <std::size_t count>
const Refusal *find(const Refusal (&table)[count], const char *style, bool remembers)
{
  for (const Refusal &entry : table)
    if ((entry.grains == ALL || remembers) && is_style(style, entry.style)) return &entry;
  return nullptr;
}

void refuse(LAMMPS *lmp, const char *caller, const char *kind, const char *id, const char *style,
            const char *reason, const char *cure)
{
  lmp->error->all(FLERR, "{} cannot be used with {} {} of style {}: {}: {}", caller, kind, id, style,
                  reason, cure);
}

}    // namespace

void LAMMPS_NS::refuse_styles(LAMMPS *lmp, const char *caller, bool remembers)
{
  Modify *modify = lmp->modify;
  for (const auto *compute : modify->get_compute_list())
    if (const Refusal *found = find(COMPUTES, compute->style, remembers))
      refuse(lmp, caller, "compute", compute->id, compute->style, found->reason, found->cure);
  for (const auto *fix : modify->get_fix_list()) {
    if (const Refusal *found = find(FIXES, fix->style, remembers))
      refuse(lmp, caller, "fix", fix->id, fix->style, found->reason, found->cure);
    // set where it adapts diameters, which need not come with the other things that it adapts
    if (is_style(fix->style, "adapt") && fix->diam_flag)
      refuse(lmp, caller, "fix", fix->id, fix->style,
             "its 'diameter' changes an enclosing radius but no shape", "use 'fix set ... shape'");
    if (remembers && lmp->comm->me == 0 &&
        (is_style(fix->style, "nve/limit") || is_style(fix->style, "nve/noforce")))
      lmp->error->warning(FLERR, "{}: fix {} of style {} moves grains but does not turn them", caller,
                          fix->id, fix->style);
  }
}
