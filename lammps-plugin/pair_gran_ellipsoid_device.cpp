// SPDX-License-Identifier: GPL-2.0-or-later

#include "pair_gran_ellipsoid_device.h"

#include "ellgran_step_velocity.h"
#include "fix_nve_ellipsoid.h"
#include "fix_nve_ellipsoid_device.h"
#include "fix_wall_gran_ellipsoid_device.h"

#include "atom_kokkos.h"
#include "atom_masks.h"
#include "comm.h"
#include "compute.h"
#include "domain.h"
#include "error.h"
#include "fix.h"
#include "force.h"
#include "input.h"
#include "modify.h"
#include "neigh_list_kokkos.h"
#include "neigh_request.h"
#include "neighbor.h"
#include "output.h"
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <cstring>

using namespace LAMMPS_NS;

namespace {

const char CALLER[] = "Pair gran/ellipsoid/kk";

}    // namespace

PairGranEllipsoidDevice::PairGranEllipsoidDevice(LAMMPS *lmp) :
    PairGranEllipsoid(lmp), grains(lmp, CALLER), atomKK(nullptr), options_of_scene(0)
{
  if (!lmp->kokkos)
    error->all(FLERR, "{}: style gran/ellipsoid/kk needs LAMMPS to run with KOKKOS: start it with '-k on g 1', or use gran/ellipsoid",
               CALLER);
  atomKK = static_cast<AtomKokkos *>(atom);
  kokkosable = 1;
  execution_space = Device;
  datamask_read = X_MASK | V_MASK | F_MASK | TORQUE_MASK | ANGMOM_MASK | TAG_MASK | TYPE_MASK | RMASS_MASK | ELLIPSOID_MASK | BONUS_MASK;
  datamask_modify = F_MASK | TORQUE_MASK;
  // Contacts one by one, and sums over them, are not on the GPU.
  single_enable = 0;
  nextra = 0;
}

PairGranEllipsoidDevice *PairGranEllipsoidDevice::of(LAMMPS *lmp, const char *caller)
{
  auto *const pair = dynamic_cast<PairGranEllipsoidDevice *>(lmp->force->pair);
  if (!pair)
    lmp->error->all(FLERR, "{}: on a GPU it goes with 'pair_style gran/ellipsoid/kk' alone, not with hybrid nor with another style",
                    caller);
  return pair;
}

void PairGranEllipsoidDevice::compute(int eflag, int vflag)
{
  ev_init(0, 0);
  // Whoever asks for energies or stresses hears from LAMMPS that there are none.
  if (eflag || vflag) update->eflag_global = update->vflag_global = update->eflag_atom = update->vflag_atom = -1;

  atomKK->sync(Device, datamask_read);
  if (neighbor->ago == 0) {
    grains.take_list(static_cast<NeighListKokkos<LMPDeviceType> *>(list));
  } else {
    grains.require_listed();
    grains.prepare();
  }
  EllgranStep step = ELLGRAN_INIT(EllgranStep);
  step.time_step = update->dt;
  step.advance_history = time_passes() ? 1 : 0;
  grains.add_forces(step);
  atomKK->modified(Device, datamask_modify);
  // Nothing wrong is shown.
  if (update->ntimestep == output->next) grains.require_sound();
}

void PairGranEllipsoidDevice::init_style()
{
  // What follows reads the arrays of the host.
  atomKK->sync(Host, ALL_MASK);
  require_settings();
  refuse_what_the_gpu_has_not();
  refuse_other_atoms();
  if (comm->ghost_velocity) {
    // LAMMPS of 4 Jul 2026 would write quaternions over what else images have; see docs/kokkos.md.
    comm->ghost_velocity = 0;
    utils::logmesg(lmp, "{}: images have the velocities of their grains on the GPU: 'comm_modify vel no' takes the place of 'vel yes'\n",
                   CALLER);
  }
  atoms.require_shapes(~0);
  atoms.count_ellipsoids();
  warn_of_masses();
  find_largest_semi_axes();
  require_wide_box();
  build_laws();
  tell_step_limits();
  refuse_what_cannot_work();
  take_laws();

  const FixNVEEllipsoidDevice *motion = nullptr;
  for (const auto *fix : modify->get_fix_list())
    if (const auto *found = dynamic_cast<const FixNVEEllipsoidDevice *>(fix)) motion = found;
  grains.use_velocities_of_step(motion && motion->has_velocities_of_step());

  auto *const request = neighbor->add_request(this, NeighConst::REQ_FULL);
  request->set_kokkos_host(0);
  request->set_kokkos_device(1);
}

/* Contacts are remembered on the GPU, by kernels that were made for the laws. Walls have types behind those of the atoms. */

void PairGranEllipsoidDevice::take_laws()
{
  std::vector<FixWallGranEllipsoidDevice *> walls;
  for (auto *fix : modify->get_fix_list())
    if (auto *wall = dynamic_cast<FixWallGranEllipsoidDevice *>(fix)) walls.push_back(wall);
  const int types = atom->ntypes + static_cast<int>(walls.size());
  std::vector<EllgranLawParameters> given;
  std::vector<uint8_t> is_set;
  fill_laws(types, given, is_set);
  for (std::size_t k = 0; k < walls.size(); k++)
    for (int i = 0; i <= atom->ntypes + static_cast<int>(k); i++) {
      const std::size_t place = static_cast<std::size_t>(i) * types + atom->ntypes + k;
      given[place] = walls[k]->contact_law();
      is_set[place] = 1;
    }

  const bool same = grains.has_scene() && options_of_scene == laws_options && laws_of_scene.size() == given.size() && set_in_scene == is_set &&
      std::memcmp(laws_of_scene.data(), given.data(), given.size() * sizeof(EllgranLawParameters)) == 0;
  if (same && std::all_of(walls.begin(), walls.end(), [](const auto *wall) { return wall->is_in_scene(); })) return;
  EllgranLaws *all = nullptr;
  if (ellgran_laws_new(types, given.data(), is_set.data(), laws_options, &all) != ELLGRAN_SUCCESS)
    error->all(FLERR, "{}: {}", CALLER, ellgran_last_error());
  const bool remembers = ellgran_laws_history_length(all) > 0;
  if (grains.has_list() && remembers) {
    ellgran_laws_free(all);
    error->all(FLERR,
               "{}: laws or walls have changed since the last run, and on the GPU contacts that exist cannot go on with others: start "
               "anew from a data file ('write_data')",
               CALLER);
  }
  grains.set_laws(all);
  ellgran_laws_free(all);
  for (std::size_t k = 0; k < walls.size(); k++) walls[k]->add_to_scene(grains, atom->ntypes + 1 + static_cast<int>(k));
  laws_of_scene = given;
  options_of_scene = laws_options;
  set_in_scene = is_set;
}

void PairGranEllipsoidDevice::refuse_what_the_gpu_has_not() const
{
  const auto refuse = [this](const std::string &what, const char *cure) {
    error->all(FLERR, "{}: {} not on the GPU: {}", CALLER, what, cure);
  };
  of(lmp, CALLER);
  if (comm->nprocs > 1) refuse("several ranks are", "start LAMMPS with one");
  if (update->whichflag == 2) refuse("minimisation is", "use a run with damping");
  if (input->command && std::strcmp(input->command, "rerun") == 0) refuse("'rerun' is", "start LAMMPS without '-k on'");
  if (output->restart_flag) refuse("restart files are", "remove 'restart', and use 'write_data'");
  if (atom->molecular)
    for (int k = 1; k < 4; k++)
      if (force->special_coul[k] != force->special_lj[k])
        refuse("special_bonds with other factors for coul than for lj is", "give both the same");
  if (neighbor->includegroup) refuse("'neigh_modify include' is", "remove it");
  if (atoms.shapes_may_change()) refuse("fixes that may change shapes (set, python, external) are", "remove them");
  if (!modify->get_fix_by_style("^pour/ellipsoid").empty()) refuse("fix pour/ellipsoid is", "insert grains in a run without '-k on'");
  for (const char *style : {"^contact/ellipsoid/atom", "^energy/ellipsoid", "^timestep/ellipsoid"})
    for (const auto *compute : modify->get_compute_by_style(style))
      refuse(std::string("compute ") + compute->style + " is", "remove it, or start LAMMPS without '-k on'");
  if (FixEllgranStepVelocity::needed(modify)) refuse("prescribed motion of grains and changes of the box are", "remove fix move, rigid, deform, nph or press");
  for (const auto *fix : modify->get_fix_list()) {
    const std::string style = fix->style;
    if (fix->rigid_flag || utils::strmatch(style, "^freeze") || fix->box_change)
      refuse("fix " + style + " is", "remove it, or start LAMMPS without '-k on'");
    if (dynamic_cast<const FixWallGranEllipsoid *>(fix) && !dynamic_cast<const FixWallGranEllipsoidDevice *>(fix))
      refuse("fix wall/gran/ellipsoid without the suffix is", "use wall/gran/ellipsoid/kk ('-sf kk')");
    if (dynamic_cast<const FixNVEEllipsoid *>(fix))
      refuse("fix nve/ellipsoid without the suffix is", "use nve/ellipsoid/kk ('-sf kk')");
  }
}

/* What contacts remember is found by the IDs of atoms, which `delete_atoms` gives to others. */

void PairGranEllipsoidDevice::refuse_other_atoms()
{
  if (!grains.has_list()) return;
  const std::size_t known = ids_at_end.size();
  if (static_cast<std::size_t>(atom->nlocal) < known || !std::equal(ids_at_end.begin(), ids_at_end.end(), atom->tag))
    error->all(FLERR,
               "{}: atoms have been deleted, or have other IDs, since the last run, and on the GPU contacts that exist cannot follow them: start "
               "anew from a data file ('write_data')",
               CALLER);
}

/* Grains are known by their identifiers: no grain may meet two images of another one, nor its own. */

void PairGranEllipsoidDevice::require_wide_box() const
{
  const double reach = 2.0 * *std::max_element(largest.begin(), largest.end());
  const double cutoff = std::max(reach, cutoff_global) + neighbor->skin;
  for (int k = 0; k < 3; k++)
    if (domain->periodicity[k] && domain->prd[k] <= 2.0 * cutoff)
      error->all(FLERR,
                 "{}: the box is {} long in {}, where it is periodic: on the GPU it must be longer than {}, twice the cutoff of the "
                 "neighbour list",
                 CALLER, domain->prd[k], "xyz"[k], 2.0 * cutoff);
}

/* On the host it looks at contacts, which are on the GPU. */

void PairGranEllipsoidDevice::setup() {}

void PairGranEllipsoidDevice::finish()
{
  grains.require_sound();
  atomKK->sync(Host, TAG_MASK);
  ids_at_end.assign(atom->tag, atom->tag + atom->nlocal);
}

void PairGranEllipsoidDevice::write_restart(FILE *)
{
  error->all(FLERR, "{}: restart files are not written on the GPU: use 'write_data', which leaves out what contacts remember", CALLER);
}

void PairGranEllipsoidDevice::read_restart(FILE *)
{
  error->all(FLERR, "{}: restart files are not read on the GPU: use a data file", CALLER);
}

void PairGranEllipsoidDevice::write_restart_settings(FILE *fp)
{
  write_restart(fp);
}

void PairGranEllipsoidDevice::read_restart_settings(FILE *fp)
{
  read_restart(fp);
}
