// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// What `plugin load` calls. Registers the styles, if they were built for the LAMMPS that loads them.

#include "lammpsplugin.h"

#include "fix_wall_gran_ellipsoid.h"
#include "pair_gran_ellipsoid.h"

#include "atom.h"
#include "error.h"
#include "lammps.h"
#include "library.h"
#include "version.h"

#include <cstdio>
#include <cstring>
#include <string>

using namespace LAMMPS_NS;

namespace {

Pair *create_pair(LAMMPS *lmp)
{
  return new PairGranEllipsoid(lmp);
}

Fix *create_fix(LAMMPS *lmp, int narg, char **arg)
{
  return new FixWallGranEllipsoid(lmp, narg, arg);
}

// The layout of LAMMPS' classes changes between releases: a plugin for another one reads garbage.
void require_same_lammps(LAMMPS *lmp)
{
  if (std::strcmp(lmp->version, LAMMPS_VERSION) != 0)
    lmp->error->all(FLERR,
                    "Plugin ellgran was built for LAMMPS version " LAMMPS_VERSION
                    ", but this is LAMMPS version " + std::string(lmp->version) +
                    ": build the plugin with LAMMPS_SOURCE_DIR set to the sources of this LAMMPS");

  // Atom IDs have 4 or 8 bytes, chosen when LAMMPS is compiled.
  const int tag_type = lmp->atom->extract_datatype("id");
  const bool wide = (tag_type == LAMMPS_INT64);
  if (wide != (sizeof(tagint) == 8))
    lmp->error->all(FLERR, std::string("Plugin ellgran was built with LAMMPS_SIZES ") +
                               (sizeof(tagint) == 8 ? "bigbig" : "smallbig") +
                               ", but this LAMMPS uses " + (wide ? "bigbig" : "smallbig") +
                               ": build the plugin with the LAMMPS_SIZES of this LAMMPS");

  if (ellgran_abi_version() != ELLGRAN_ABI_VERSION)
    lmp->error->all(FLERR, "Plugin ellgran was compiled for ABI version " +
                               std::to_string(ELLGRAN_ABI_VERSION) +
                               " of the library, but linked with version " +
                               std::to_string(ellgran_abi_version()));
}

}    // namespace

extern "C" __attribute__((visibility("default"))) void lammpsplugin_init(void *lmp, void *handle,
                                                                         void *regfunc)
{
  auto *lammps = static_cast<LAMMPS *>(lmp);
  require_same_lammps(lammps);

  // LAMMPS keeps these pointers for as long as the plugin is loaded.
  static char pair_about[96], fix_about[96];
  std::snprintf(pair_about, sizeof pair_about, "pair_style gran/ellipsoid, ellgran %s",
                ellgran_version());
  std::snprintf(fix_about, sizeof fix_about, "fix wall/gran/ellipsoid, ellgran %s",
                ellgran_version());

  lammpsplugin_t plugin{};
  plugin.version = LAMMPS_VERSION;
  plugin.author = "the ellgran developers";
  plugin.handle = handle;
  const auto register_style = reinterpret_cast<lammpsplugin_regfunc>(regfunc);

  plugin.style = "pair";
  plugin.name = "gran/ellipsoid";
  plugin.info = pair_about;
  plugin.creator.v1 = reinterpret_cast<lammpsplugin_factory1 *>(&create_pair);
  register_style(&plugin, lmp);

  plugin.style = "fix";
  plugin.name = "wall/gran/ellipsoid";
  plugin.info = fix_about;
  plugin.creator.v2 = reinterpret_cast<lammpsplugin_factory2 *>(&create_fix);
  register_style(&plugin, lmp);
}
