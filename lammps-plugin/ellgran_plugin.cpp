// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// What `plugin load` calls. Registers the styles, if they were built for the LAMMPS that loads them.

#include "lammpsplugin.h"

#include "compute_contact_ellipsoid_atom.h"
#include "compute_energy_ellipsoid.h"
#include "compute_timestep_ellipsoid.h"
#include "create_ellipsoids.h"
#include "ellgran_class_layout.h"
#include "ellgran_kokkos.h"
#include "fix_nve_ellipsoid_kokkos.h"
#include "fix_pour_ellipsoid.h"
#include "fix_wall_gran_ellipsoid_kokkos.h"
#include "pair_gran_ellipsoid_kokkos.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "fix_neigh_history.h"
#include "force.h"
#include "lammps.h"
#include "library.h"
#include "utils.h"
#include "version.h"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <new>
#include <string>

#if defined(__linux__) || defined(__APPLE__)
#include <dlfcn.h>
#endif

#ifdef LAMMPS_UPDATE
#define ELLGRAN_BUILT_FOR LAMMPS_VERSION " - " LAMMPS_UPDATE
#else
#define ELLGRAN_BUILT_FOR LAMMPS_VERSION
#endif

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

Fix *create_integrator(LAMMPS *lmp, int narg, char **arg)
{
  return new FixNVEEllipsoid(lmp, narg, arg);
}

Pair *create_pair_kokkos(LAMMPS *lmp)
{
  return new PairGranEllipsoidKokkos(lmp);
}

Fix *create_fix_kokkos(LAMMPS *lmp, int narg, char **arg)
{
  return new FixWallGranEllipsoidKokkos(lmp, narg, arg);
}

Fix *create_integrator_kokkos(LAMMPS *lmp, int narg, char **arg)
{
  return new FixNVEEllipsoidKokkos(lmp, narg, arg);
}

Fix *create_pour(LAMMPS *lmp, int narg, char **arg)
{
  return new FixPourEllipsoid(lmp, narg, arg);
}

Compute *create_contacts(LAMMPS *lmp, int narg, char **arg)
{
  return new ComputeContactEllipsoidAtom(lmp, narg, arg);
}

Compute *create_balance(LAMMPS *lmp, int narg, char **arg)
{
  return new ComputeEnergyEllipsoid(lmp, narg, arg);
}

Compute *create_step(LAMMPS *lmp, int narg, char **arg)
{
  return new ComputeTimestepEllipsoid(lmp, narg, arg);
}

Command *create_fill(LAMMPS *lmp)
{
  return new CreateEllipsoids(lmp);
}

// LAMMPS' classes as the headers describe them.
struct FixByHeaders : public Fix {
  virtual void after_last() {}
};
struct ComputeByHeaders : public Compute {
  virtual void after_last() {}
};
struct HistoryByHeaders : public FixNeighHistory {
  virtual void after_last() {}
};
struct PairByHeaders : public Pair {
  using Pair::Pair;
  void compute(int, int) override {}
  void settings(int, char **) override {}
  void coeff(int, char **) override {}
  virtual void after_last() {}

  // What LAMMPS' own constructor has written, read where the headers say it is.
  [[nodiscard]] bool is_new() const
  {
    return single_enable == 1 && restartinfo == 1 && reinitflag == 1 && trim_flag == 1 && compute_flag == 1 &&
        mixed_flag == 1 && ncoultablebits == 12 && ndisptablebits == 12 && tabinner == std::sqrt(2.0) &&
        offset_flag == 0 && mix_flag == GEOMETRIC && nparams == 0 && maxcvatom == 0;
  }
};

// The name of a class that is not in memory as the headers say; empty if none is found. Updates of a release carry its
// version, and those of 22 Jul 2025 have moved members of Pair.
std::string changed_class(LAMMPS *lmp)
{
  const auto differs = [](std::size_t by_headers, const char *mangled) {
    const std::size_t here = ellgran_virtual_functions_of(mangled);
    return here && by_headers && here != by_headers;
  };
  if (differs(ellgran_virtual_functions(&PairByHeaders::after_last), "N9LAMMPS_NS4PairE")) return "Pair";
  if (differs(ellgran_virtual_functions(&FixByHeaders::after_last), "N9LAMMPS_NS3FixE")) return "Fix";
  if (differs(ellgran_virtual_functions(&ComputeByHeaders::after_last), "N9LAMMPS_NS7ComputeE")) return "Compute";
  if (differs(ellgran_virtual_functions(&HistoryByHeaders::after_last), "N9LAMMPS_NS15FixNeighHistoryE"))
    return "FixNeighHistory";

  // LAMMPS' constructor may write more than the headers know of. It allocates nothing, and its counterpart is not called,
  // which would take what it wrote for something else.
  constexpr std::size_t SPARE = 4096;
  alignas(PairByHeaders) static unsigned char room[sizeof(PairByHeaders) + SPARE];
  std::memset(room, 0, sizeof room);
  const auto *pair = new (room) PairByHeaders(lmp);
  Pair::instance_total--;
  return pair->is_new() ? "" : "Pair";
}

// A second file with these styles changes nothing: LAMMPS keeps the first, and does not always say so.
void tell_of_first_plugin(LAMMPS *lmp)
{
#if defined(__linux__) || defined(__APPLE__)
  bool from_plugin = false;
  for (int k = 0; k < lammps_plugin_count(); k++) {
    char style[64] = "", name[64] = "";
    lammps_plugin_name(k, style, name, sizeof style);
    from_plugin |= std::strcmp(style, "pair") == 0 && std::strcmp(name, "gran/ellipsoid") == 0;
  }
  const auto found = lmp->force->pair_map->find("gran/ellipsoid");
  if (!from_plugin || found == lmp->force->pair_map->end() ||
      reinterpret_cast<void *>(found->second) == reinterpret_cast<void *>(&create_pair))
    return;
  Dl_info first{}, here{};
  if (dladdr(reinterpret_cast<void *>(found->second), &first) && dladdr(reinterpret_cast<void *>(&create_pair), &here) &&
      lmp->comm->me == 0)
    utils::logmesg(lmp, "Plugin ellgran: the styles of {} are in use already and stay, those of {} are not used\n",
                   first.dli_fname, here.dli_fname);
#endif
}

// The layout of LAMMPS' classes changes between releases: a plugin for another one reads garbage.
void require_same_lammps(LAMMPS *lmp)
{
  if (std::strcmp(lmp->version, LAMMPS_VERSION) != 0)
    lmp->error->all(FLERR,
                    "Plugin ellgran was built for LAMMPS version " ELLGRAN_BUILT_FOR
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

  const std::string changed = changed_class(lmp);
  if (!changed.empty())
    lmp->error->all(FLERR,
                    "Plugin ellgran was built for LAMMPS version " ELLGRAN_BUILT_FOR
                    ", but this is another update of it, in which class " +
                        changed + " differs: build the plugin with LAMMPS_SOURCE_DIR set to the sources of this LAMMPS");

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
  tell_of_first_plugin(lammps);

  const auto one = [](auto *function) { return reinterpret_cast<lammpsplugin_factory1 *>(function); };
  const auto two = [](auto *function) { return reinterpret_cast<lammpsplugin_factory2 *>(function); };
  const struct {
    const char *kind, *name;
    lammpsplugin_factory1 *creator;
    lammpsplugin_factory2 *creator_with_words;
    bool of_kokkos = false;
  } styles[] = {
      {"pair", "gran/ellipsoid", one(&create_pair), nullptr},
      {"fix", "wall/gran/ellipsoid", nullptr, two(&create_fix)},
      {"fix", "nve/ellipsoid", nullptr, two(&create_integrator)},
      {"fix", "pour/ellipsoid", nullptr, two(&create_pour)},
      {"compute", "contact/ellipsoid/atom", nullptr, two(&create_contacts)},
      {"compute", "energy/ellipsoid", nullptr, two(&create_balance)},
      {"compute", "timestep/ellipsoid", nullptr, two(&create_step)},
      {"command", "create_ellipsoids", one(&create_fill), nullptr},
      {"pair", "gran/ellipsoid/kk", one(&create_pair_kokkos), nullptr, true},
      {"pair", "gran/ellipsoid/kk/host", one(&create_pair_kokkos), nullptr, true},
      {"fix", "wall/gran/ellipsoid/kk", nullptr, two(&create_fix_kokkos), true},
      {"fix", "wall/gran/ellipsoid/kk/host", nullptr, two(&create_fix_kokkos), true},
      {"fix", "nve/ellipsoid/kk", nullptr, two(&create_integrator_kokkos), true},
      {"fix", "nve/ellipsoid/kk/host", nullptr, two(&create_integrator_kokkos), true},
  };

  // LAMMPS keeps the pointers for as long as the plugin is loaded.
  static char about[sizeof styles / sizeof styles[0]][96];
  char *text = about[0];
  const bool kokkos = has_kokkos();
  for (const auto &style : styles) {
    if (style.of_kokkos && !kokkos) continue;
    std::snprintf(text, sizeof about[0], "%s %s, ellgran %s", style.kind, style.name, ellgran_version());
    lammpsplugin_t plugin{};
    plugin.version = LAMMPS_VERSION;
    plugin.author = "the ellgran developers";
    plugin.handle = handle;
    plugin.style = style.kind;
    plugin.name = style.name;
    plugin.info = text;
    if (style.creator)
      plugin.creator.v1 = style.creator;
    else
      plugin.creator.v2 = style.creator_with_words;
    reinterpret_cast<lammpsplugin_regfunc>(regfunc)(&plugin, lmp);
    text += sizeof about[0];
  }
}
