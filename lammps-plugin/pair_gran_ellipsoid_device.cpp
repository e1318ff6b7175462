// SPDX-License-Identifier: GPL-2.0-or-later

#include "pair_gran_ellipsoid_device.h"

#include "ellgran_device_history.h"
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
#include "kokkos.h"
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
    PairGranEllipsoid(lmp), grains(lmp, CALLER), atomKK(nullptr), motion(nullptr), device_history(nullptr), options_of_scene(0),
    between_runs(false)
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
  ev_init(eflag, vflag);
  atomKK->sync(Device, datamask_read);
  if (end_of_run.known && !update->setupflag) {
    atomKK->sync(Host, X_MASK | TAG_MASK);
    require_end_of_run();
  }
  if (neighbor->ago == 0) {
    begin_list();
  } else if (between_runs) {
    // The first step of a run without set-up: commands may have changed types, masses and shapes.
    grains.require_listed();
    require_same_grains();
    atomKK->sync(Host, TYPE_MASK | ELLIPSOID_MASK | BONUS_MASK);
    require_allowed_sizes();
    begin_list();
  } else {
    grains.require_listed();
    if (device_history && device_history->is_held()) device_history->let_go();
    for (auto *wall : walls()) wall->let_go();
    share_motion();
    grains.prepare();
  }
  between_runs = end_of_run.known = false;
  EllgranStep step = ELLGRAN_INIT(EllgranStep);
  step.time_step = update->dt;
  step.advance_history = time_passes() ? 1 : 0;
  if (evflag) tally(step);
  grains.add_forces(step);
  atomKK->modified(Device, datamask_modify);
  // Nothing wrong is shown.
  if (update->ntimestep == output->next) grains.require_sound();
}

/* What has been kept on the host goes back to the GPU. */

void PairGranEllipsoidDevice::begin_list()
{
  if (motion) motion->give_to_device();
  grains.follow_order(comm->nprocs > 1);
  share_motion();
  grains.take_list(static_cast<NeighListKokkos<LMPDeviceType> *>(list));
  if (device_history && device_history->is_held()) device_history->give_to_device();
  for (auto *wall : walls()) wall->give_to_device();
}

/* Images on other ranks hear of types, masses and shapes with a new neighbour list of LAMMPS alone. */

std::vector<double> PairGranEllipsoidDevice::present_grains()
{
  atomKK->sync(Host, TYPE_MASK | RMASS_MASK | ELLIPSOID_MASK | BONUS_MASK);
  const EllgranParticles particles = atoms.view();
  std::vector<double> values;
  for (int i = 0; i < atom->nlocal; i++) {
    values.push_back(atom->type[i]);
    values.push_back(atom->rmass[i]);
    const auto *const record = reinterpret_cast<const char *>(particles.semi_axes) + particles.semi_axes_stride * atom->ellipsoid[i];
    const auto *const axes = reinterpret_cast<const double *>(record);
    values.insert(values.end(), axes, axes + 3);
  }
  return values;
}

void PairGranEllipsoidDevice::require_same_grains()
{
  if (comm->nprocs == 1) return;
  int same_here = (present_grains() == grains_at_end) ? 1 : 0;
  int same = 0;
  MPI_Allreduce(&same_here, &same, 1, MPI_INT, MPI_MIN, world);
  if (!same)
    error->all(FLERR,
               "{}: types, masses or shapes have changed since the last run, and on the GPU with several ranks images would not hear of it: "
               "leave out 'pre no'",
               CALLER);
}

/* With one rank images have the velocities of their grains. */

void PairGranEllipsoidDevice::share_motion()
{
  if (comm->nprocs == 1) return;
  comm->forward_comm(this, grains.motion_length());
  atomKK->modified(Device, V_MASK | ANGMOM_MASK);
}

/* In a step in which somebody asks for energies or stresses the contacts are computed once more, of what the GPU is about to compute them from:
   on the GPU, or where they are asked for by atom on the host, whose forces and histories are dropped. */

void PairGranEllipsoidDevice::tally(const EllgranStep &step)
{
  if (eflag_atom || vflag_atom || cvflag_atom)
    tally_on_host(step);
  else if (atom->nlocal > 0)
    add_tallies(grains.tallies(step));
}

template <typename TALLIES> void PairGranEllipsoidDevice::add_tallies(const TALLIES &sums)
{
  if (eflag_global) eng_vdwl += sums.normal_elastic_energy + sums.tangential_elastic_energy;
  if (vflag_global)
    for (int k = 0; k < 6; k++) virial[k] += sums.virial[k];
}

void PairGranEllipsoidDevice::tally_on_host(const EllgranStep &step)
{
  if (atom->nlocal + atom->nghost == 0) return;
  atomKK->sync(Host, X_MASK | V_MASK | ANGMOM_MASK | RMASS_MASK | TYPE_MASK | TAG_MASK | ELLIPSOID_MASK | BONUS_MASK);
  const auto &rows = grains.rows();
  const auto remembered = grains.remembered();
  const std::size_t count = static_cast<std::size_t>(atom->nlocal) + atom->nghost;

  EllgranParticles particles = atoms.view();
  const auto owners = grains.owners_on_host();
  std::vector<double> velocities(3 * count), angular_momenta(3 * count), unused_forces(3 * count, 0.0), unused_torques(3 * count, 0.0);
  std::vector<int> bodies(count);
  for (std::size_t i = 0; i < count; i++) {
    const std::size_t owner = owners.empty() ? i : static_cast<std::size_t>(owners[i]);
    std::copy_n(particles.velocities + 3 * owner, 3, &velocities[3 * i]);
    std::copy_n(particles.angular_momenta + 3 * owner, 3, &angular_momenta[3 * i]);
    bodies[i] = particles.shape_indices[owner];
  }
  const auto changes = grains.velocity_changes();
  particles.velocities = velocities.data();
  particles.angular_momenta = angular_momenta.data();
  particles.velocity_changes = changes.empty() ? nullptr : changes.data();
  particles.shape_indices = bodies.data();
  particles.forces = unused_forces.data();
  particles.torques = unused_torques.data();

  // The entries that the rows keep, each as of the pair whose first grain is that of the row.
  std::vector<int> central(rows.owned), counts(count, 0), neighbours, touching;
  std::vector<double> histories, source(history_length);
  std::vector<std::size_t> begins(rows.owned);
  for (int k = 0; k < rows.owned; k++) {
    central[k] = k;
    begins[k] = neighbours.size();
    for (uint32_t e = rows.starts[k]; e < rows.starts[k + 1]; e++) {
      const int other = static_cast<int>(rows.neighbours[e]);
      if (!rows.keeps(k, other)) continue;
      counts[k]++;
      neighbours.push_back(other);
      touching.push_back(static_cast<int>(remembered.touching[e]));
      // Where walls remember more than pairs the GPU has longer histories, which begin in the same way.
      const double *const history = &remembered.histories[e * remembered.length];
      histories.insert(histories.end(), history, history + history_length);
      if (rows.ids[k] < rows.ids[other]) continue;
      std::copy_n(history, history_length, source.begin());
      transfer_history(source.data(), histories.data() + (histories.size() - history_length), 0, 0);
    }
  }
  std::vector<const int *> rows_of_neighbours(count, nullptr);
  std::vector<int *> rows_of_touching(count, nullptr);
  std::vector<double *> rows_of_histories(count, nullptr);
  for (int k = 0; k < rows.owned; k++) {
    rows_of_neighbours[k] = neighbours.data() + begins[k];
    rows_of_touching[k] = touching.data() + begins[k];
    rows_of_histories[k] = histories.data() + begins[k] * history_length;
  }
  EllgranNeighbourList pairs = ELLGRAN_INIT(EllgranNeighbourList);
  pairs.count = central.size();
  pairs.central = central.data();
  pairs.neighbour_counts = counts.data();
  pairs.neighbours = rows_of_neighbours.data();
  pairs.index_mask = -1;
  pairs.touching = (history_length > 0) ? rows_of_touching.data() : nullptr;
  pairs.history = (history_length > 0) ? rows_of_histories.data() : nullptr;

  EllgranTallies sums = ELLGRAN_INIT(EllgranTallies);
  sums.particle_energies = eflag_atom ? eatom : nullptr;
  sums.particle_virials = vflag_atom ? vatom[0] : nullptr;
  if (ellgran_compute_pairs(laws, workspace, &particles, &pairs, &step, &sums) != ELLGRAN_SUCCESS)
    error->one(FLERR, "{}: {}", CALLER, ellgran_last_error());
  add_tallies(sums);
}

int PairGranEllipsoidDevice::pack_forward_comm_kokkos(int n, DAT::tdual_int_1d indices, DAT::tdual_double_1d &buffer, int, int *)
{
  grains.pack_motion(n, indices, buffer);
  return n * grains.motion_length();
}

void PairGranEllipsoidDevice::unpack_forward_comm_kokkos(int n, int first, DAT::tdual_double_1d &buffer)
{
  grains.unpack_motion(n, first, buffer);
}

/* The same where MPI reads the memory of the host alone, and LAMMPS has turned 'package kokkos comm/pair/forward' to 'no': by way of a copy
   there. */

int PairGranEllipsoidDevice::pack_forward_comm(int n, int *indices, double *buffer, int, int *)
{
  const int length = grow_messages(n);
  std::copy_n(indices, n, sent_grains.view_host().data());
  sent_grains.modify_host();
  sent_grains.sync_device();
  grains.pack_motion(n, sent_grains, message);
  message.modify_device();
  message.sync_host();
  std::copy_n(message.view_host().data(), length, buffer);
  return length;
}

void PairGranEllipsoidDevice::unpack_forward_comm(int n, int first, double *buffer)
{
  const int length = grow_messages(n);
  std::copy_n(buffer, length, message.view_host().data());
  message.modify_host();
  message.sync_device();
  grains.unpack_motion(n, first, message);
}

/* Makes room for the message of so many grains; its length. */

int PairGranEllipsoidDevice::grow_messages(int n)
{
  const auto count = static_cast<std::size_t>(n), length = count * grains.motion_length();
  if (sent_grains.extent(0) < count) sent_grains = DAT::tdual_int_1d("ellgran:sent_grains", count);
  if (message.extent(0) < length) message = DAT::tdual_double_1d("ellgran:message", length);
  return static_cast<int>(length);
}

void PairGranEllipsoidDevice::init_style()
{
  // What follows reads the arrays of the host.
  atomKK->sync(Host, ALL_MASK);
  require_settings();
  end_of_run.set_up_since = true;
  refuse_what_the_gpu_has_not();
  refuse_other_atoms_after_reading();
  motion = nullptr;
  for (auto *fix : modify->get_fix_list())
    if (auto *found = dynamic_cast<FixNVEEllipsoidDevice *>(fix)) motion = found;
  // Before a scene is made anew, which knows nothing of the atoms of the last run.
  if (motion) motion->follow_atoms(this);
  keep_what_contacts_remember();
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
  place_history_fix();
  if (!fix_history) device_history = nullptr;
  take_laws();

  grains.use_velocities_of_step(motion && motion->has_velocities_of_step());

  auto *const request = neighbor->add_request(this, NeighConst::REQ_FULL);
  request->set_kokkos_host(0);
  request->set_kokkos_device(1);
}

FixEllgranHistory *PairGranEllipsoidDevice::make_history_fix(const std::string &id)
{
  device_history = replace_by_history<FixEllgranDeviceHistory>(modify, id_history, id, history_length);
  device_history->grains = &grains;
  return device_history;
}

std::vector<FixWallGranEllipsoidDevice *> PairGranEllipsoidDevice::walls() const
{
  std::vector<FixWallGranEllipsoidDevice *> all;
  for (auto *fix : modify->get_fix_list())
    if (auto *wall = dynamic_cast<FixWallGranEllipsoidDevice *>(fix)) all.push_back(wall);
  return all;
}

bool PairGranEllipsoidDevice::SceneLaws::is(const SceneLaws &other) const
{
  return given.size() == other.given.size() && is_set == other.is_set &&
      std::memcmp(given.data(), other.given.data(), given.size() * sizeof(EllgranLawParameters)) == 0;
}

/* Walls have types behind those of the atoms. */

PairGranEllipsoidDevice::SceneLaws PairGranEllipsoidDevice::wanted_laws() const
{
  const auto all = walls();
  const int types = atom->ntypes + static_cast<int>(all.size());
  SceneLaws wanted;
  fill_laws(types, wanted.given, wanted.is_set);
  for (std::size_t k = 0; k < all.size(); k++)
    for (int i = 0; i <= atom->ntypes + static_cast<int>(k); i++) {
      const std::size_t place = static_cast<std::size_t>(i) * types + atom->ntypes + k;
      wanted.given[place] = all[k]->contact_law();
      wanted.is_set[place] = 1;
    }
  return wanted;
}

/* Contacts are remembered on the GPU, by kernels that were made for the laws. */

bool PairGranEllipsoidDevice::scene_serves(const SceneLaws &wanted) const
{
  const auto all = walls();
  return grains.has_scene() && options_of_scene == laws_options && wanted.is(laws_of_scene) &&
      std::all_of(all.begin(), all.end(), [](const auto *wall) { return wall->is_in_scene(); });
}

/* Between two runs the GPU finds contacts by the IDs that atoms had when the first one ended. Where these are others now, or the scene is
   to be made anew, the atoms take what their contacts remember. */

void PairGranEllipsoidDevice::keep_what_contacts_remember()
{
  if (!device_history || device_history->is_held() || !grains.has_list()) return;
  if (device_history->atoms_have_changed() || !scene_serves(wanted_laws())) device_history->take_from_device();
}

void PairGranEllipsoidDevice::take_laws()
{
  const auto all_walls = walls();
  const SceneLaws wanted = wanted_laws();
  if (scene_serves(wanted)) return;
  const int types = atom->ntypes + static_cast<int>(all_walls.size());
  EllgranLaws *all = nullptr;
  if (ellgran_laws_new(types, wanted.given.data(), wanted.is_set.data(), laws_options, &all) != ELLGRAN_SUCCESS)
    error->all(FLERR, "{}: {}", CALLER, ellgran_last_error());
  grains.set_laws(all);
  ellgran_laws_free(all);
  for (std::size_t k = 0; k < all_walls.size(); k++) all_walls[k]->add_to_scene(grains, atom->ntypes + 1 + static_cast<int>(k));
  laws_of_scene = wanted;
  options_of_scene = laws_options;
}

void PairGranEllipsoidDevice::refuse_what_the_gpu_has_not() const
{
  const auto refuse = [this](const std::string &what, const char *cure) {
    error->all(FLERR, "{}: {} not on the GPU: {}", CALLER, what, cure);
  };
  of(lmp, CALLER);
  if (comm->nprocs > 1 && comm->style != Comm::BRICK) refuse("comm_style tiled with several ranks is", "use 'comm_style brick'");
  if (update->whichflag == 2) refuse("minimisation is", "use a run with damping");
  if (input->command && std::strcmp(input->command, "rerun") == 0) refuse("'rerun' is", "start LAMMPS without '-k on'");
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
    if (fix->rigid_flag || utils::strmatch(style, "^freeze") || (fix->box_change & ~Fix::BOX_CHANGE_DOMAIN))
      refuse("fix " + style + " is", "remove it, or start LAMMPS without '-k on'");
    if (dynamic_cast<const FixWallGranEllipsoid *>(fix) && !dynamic_cast<const FixWallGranEllipsoidDevice *>(fix))
      refuse("fix wall/gran/ellipsoid without the suffix is", "use wall/gran/ellipsoid/kk ('-sf kk')");
    if (dynamic_cast<const FixNVEEllipsoid *>(fix))
      refuse("fix nve/ellipsoid without the suffix is", "use nve/ellipsoid/kk ('-sf kk')");
  }
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
  atomKK->sync(Host, X_MASK | TAG_MASK);
  if (comm->nprocs > 1) grains_at_end = present_grains();
  note_end_of_run();
  between_runs = true;
}
