// SPDX-License-Identifier: GPL-2.0-or-later
// What `plugin load` calls: registers the styles of ellgran, those with the suffix kk being the ones for a GPU. For tests alone.

#include "lammpsplugin.h"

#include "compute_contact_ellipsoid_atom.h"
#include "compute_energy_ellipsoid.h"
#include "compute_timestep_ellipsoid.h"
#include "fix_nve_ellipsoid.h"
#include "fix_nve_ellipsoid_device.h"
#include "fix_pour_ellipsoid.h"
#include "fix_wall_gran_ellipsoid.h"
#include "fix_wall_gran_ellipsoid_device.h"
#include "pair_gran_ellipsoid.h"
#include "pair_gran_ellipsoid_device.h"

#include "version.h"

using namespace LAMMPS_NS;

namespace {

template <class Style> void *made(LAMMPS *lmp)
{
  return static_cast<Pair *>(new Style(lmp));
}

template <class Kind, class Style> void *made_with_words(LAMMPS *lmp, int narg, char **arg)
{
  return static_cast<Kind *>(new Style(lmp, narg, arg));
}

struct Registration {
  void *lmp, *handle;
  lammpsplugin_regfunc add;

  void style(const char *kind, const char *name, lammpsplugin_factory1 *creator, lammpsplugin_factory2 *creator_with_words) const
  {
    lammpsplugin_t plugin{};
    plugin.version = LAMMPS_VERSION;
    plugin.author = "the ellgran developers";
    plugin.handle = handle;
    plugin.style = kind;
    plugin.name = name;
    plugin.info = name;
    if (creator)
      plugin.creator.v1 = creator;
    else
      plugin.creator.v2 = creator_with_words;
    add(&plugin, lmp);
  }

  template <class Style> void pair(const char *name) const
  {
    style("pair", name, reinterpret_cast<lammpsplugin_factory1 *>(&made<Style>), nullptr);
  }

  template <class Style> void fix(const char *name) const
  {
    style("fix", name, nullptr, reinterpret_cast<lammpsplugin_factory2 *>(&made_with_words<Fix, Style>));
  }

  template <class Style> void compute(const char *name) const
  {
    style("compute", name, nullptr, reinterpret_cast<lammpsplugin_factory2 *>(&made_with_words<Compute, Style>));
  }
};

}    // namespace

extern "C" __attribute__((visibility("default"))) void lammpsplugin_init(void *lmp, void *handle, void *add)
{
  const Registration all{lmp, handle, reinterpret_cast<lammpsplugin_regfunc>(add)};
  all.pair<PairGranEllipsoid>("gran/ellipsoid");
  all.fix<FixWallGranEllipsoid>("wall/gran/ellipsoid");
  all.fix<FixNVEEllipsoid>("nve/ellipsoid");
  all.fix<FixPourEllipsoid>("pour/ellipsoid");
  all.compute<ComputeContactEllipsoidAtom>("contact/ellipsoid/atom");
  all.compute<ComputeEnergyEllipsoid>("energy/ellipsoid");
  all.compute<ComputeTimestepEllipsoid>("timestep/ellipsoid");
  all.pair<PairGranEllipsoidDevice>("gran/ellipsoid/kk");
  all.fix<FixWallGranEllipsoidDevice>("wall/gran/ellipsoid/kk");
  all.fix<FixNVEEllipsoidDevice>("nve/ellipsoid/kk");
}
