// SPDX-License-Identifier: GPL-2.0-or-later

#include "pair_gran_ellipsoid.h"

#include "ellgran_contact_sources.h"
#include "ellgran_energy_balance.h"
#include "ellgran_half_step.h"
#include "ellgran_history.h"
#include "ellgran_kokkos.h"
#include "ellgran_refusals.h"
#include "ellgran_restart_format.h"
#include "ellgran_scene_step.h"
#include "ellgran_step_velocity.h"
#include "fix_nve_ellipsoid.h"

#include "atom.h"
#include "comm.h"
#include "compute.h"
#include "domain.h"
#include "error.h"
#include "fix.h"
#include "force.h"
#include "input.h"
#include "memory.h"
#include "modify.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "output.h"
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>

using namespace LAMMPS_NS;

namespace {

const char CALLER[] = "Pair gran/ellipsoid";

// Extra values of `compute pair`, in the order of its vector.
enum {
  NORMAL_ELASTIC,
  TANGENTIAL_ELASTIC,
  DISSIPATED,
  TOUCHING,
  VISCOUS_DISSIPATION,
  FRICTIONAL_DISSIPATION,
  NUMBER_OF_EXTRA
};

constexpr int LOADS_PER_ATOM = 12;

// Extra values of `compute pair/local`: p1 is the first. Keep README.md in step.
enum {
  P_NORMAL_FORCE,
  P_TANGENTIAL_FORCE,                             // 3 components, on the first atom
  P_TANGENTIAL_MAGNITUDE = P_TANGENTIAL_FORCE + 3,
  P_CONTACT_POINT,                                // 3
  P_NORMAL = P_CONTACT_POINT + 3,                 // 3, from the first atom to the second
  P_PENETRATION = P_NORMAL + 3,
  P_CURVATURE_A,
  P_CURVATURE_B,
  P_MAJOR_SEMI_AXIS,
  P_MINOR_SEMI_AXIS,
  P_DISPLACEMENT,                                 // 3
  P_DISPLACEMENT_MAGNITUDE = P_DISPLACEMENT + 3,
  P_FORCE,                                        // 3, on the first atom
  P_TORQUE_FIRST = P_FORCE + 3,                   // 3
  P_TORQUE_SECOND = P_TORQUE_FIRST + 3,           // 3
  P_NORMAL_ENERGY = P_TORQUE_SECOND + 3,
  P_TANGENTIAL_ENERGY,
  P_VISCOUS_POWER,
  P_TANGENTIAL_POWER,
  NUMBER_OF_SINGLE
};

// Pairs of types whose law the log shows.
constexpr int LINES_OF_LAWS = 20;

std::string history_fix_id(int instance)
{
  return fmt::format("NEIGH_HISTORY_ELLGRAN_{}", instance);
}

std::string half_step_fix_id(const std::string &id)
{
  return "HALF_STEP_" + id;
}

// The fix is called `id` while it keeps the place, and `id`_LENGTH when it keeps history.
bool history_fix_exists(Modify *modify, const std::string &id)
{
  for (const auto *fix : modify->get_fix_list())
    if (id == fix->id || utils::strmatch(fix->id, "^" + id + "_")) return true;
  return false;
}

// The group of `comm_modify group`, 0 for all: LAMMPS shows it to kinds of communication alone.
struct BorderGroup : Comm {
  static int of(const Comm *comm) { return comm->*(&BorderGroup::bordergroup); }
};

double length(const double *v)
{
  return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

// The laws of `types` types from those that are chosen for the first `ntypes`.
void complete_laws(int ntypes, const std::vector<EllgranLawParameters> &parameters, const std::vector<uint8_t> &chosen, int types,
                   std::vector<EllgranLawParameters> &given, std::vector<uint8_t> &is_set)
{
  const auto from = [ntypes](int i, int j) { return static_cast<std::size_t>(i - 1) * ntypes + (j - 1); };
  const auto to = [types](int i, int j) { return static_cast<std::size_t>(i - 1) * types + (j - 1); };
  given.assign(static_cast<std::size_t>(types) * types, parameters.front());
  is_set.assign(given.size(), 0);
  EllgranLawParameters example = parameters.front();
  for (int i = 1; i <= ntypes; i++)
    for (int j = i; j <= ntypes; j++) {
      given[to(i, j)] = parameters[from(i, j)];
      if (!chosen[from(i, j)]) continue;
      is_set[to(i, j)] = 1;
      example = parameters[from(i, j)];
    }

  // Each pair of types must have a law, one that belongs to another style alone too: any that is in use.
  for (int i = 1; i <= ntypes; i++)
    for (int j = i; j <= ntypes; j++)
      if (!chosen[from(i, j)] && !(chosen[from(i, i)] && chosen[from(j, j)])) {
        is_set[to(i, j)] = 1;
        given[to(i, j)] = example;
      }
}

}    // namespace

PairGranEllipsoid::PairGranEllipsoid(LAMMPS *lmp) :
    Pair(lmp), atoms(lmp, CALLER), cutoff_global(-1.0), laws(nullptr), laws_options(0),
    limits(lmp, CALLER), step_told(0.0), step_sums(nullptr), step_sums_from(0), workspace(nullptr),
    history_length(0), fix_history(nullptr), neighbour_previous(0), fix_step_velocity(nullptr),
    velocities_of_step(nullptr),
    shapes_may_change(false), shapes_in_message(false), momenta_in_message(false), images_differ(false), evaluation_wanted(false), contacts_wanted(false), step_of_contacts(-1), listed(0), fix_rigid(nullptr),
    freeze_group_bit(0), contact_mass_differs(false), tallies(ELLGRAN_INIT(EllgranTallies)), friction(0.0),
    image_powers{}, fix_half_step(nullptr), work_wanted(false), deep_told(0)
{
  single_enable = 1;
  single_extra = NUMBER_OF_SINGLE;
  svector = new double[single_extra];
  std::fill_n(svector, single_extra, 0.0);

  nextra = NUMBER_OF_EXTRA;
  pvector = new double[nextra];
  std::fill_n(pvector, nextra, 0.0);

  restartinfo = 1;
  no_virial_fdotr_compute = 1;
  centroidstressflag = CENTROID_NOTAVAIL;
  finitecutflag = 1;
  comm_forward = EllgranAtoms::SHAPE_SIZE;    // shapes, or masses of rigid bodies
  comm_reverse = LOADS_PER_ATOM;
  nondefault_history_transfer = 1;

  if (ellgran_abi_version() != ELLGRAN_ABI_VERSION)
    error->all(FLERR, "{}: compiled for ABI version {} of ellgran, but linked with version {}",
               CALLER, static_cast<int>(ELLGRAN_ABI_VERSION),
               static_cast<int>(ellgran_abi_version()));
  if (ellgran_workspace_new(&workspace) != ELLGRAN_SUCCESS)
    error->one(FLERR, "{}: {}", CALLER, ellgran_last_error());

  // The history fix must stand where the pair style was declared in the list of fixes, although
  // its size is known only when the run starts: a placeholder keeps the position. The number tells
  // instances under pair_style hybrid apart and is the same again after read_restart.
  int instance = 1;
  while (history_fix_exists(modify, history_fix_id(instance))) instance++;
  id_placeholder = history_fix_id(instance);
  id_history = id_placeholder;
  modify->add_fix(id_placeholder + " all DUMMY");
}

PairGranEllipsoid::~PairGranEllipsoid()
{
  delete[] svector;
  delete[] pvector;
  svector = pvector = nullptr;

  if (modify->get_fix_by_id(id_history)) modify->delete_fix(id_history);
  if (fix_step_velocity && modify->get_fix_by_id(id_step_velocity))
    modify->delete_fix(id_step_velocity);
  if (fix_half_step && modify->get_fix_by_id(half_step_fix_id(id_placeholder)))
    modify->delete_fix(half_step_fix_id(id_placeholder));

  ellgran_laws_free(laws);
  ellgran_workspace_free(workspace);

  if (allocated) {
    memory->destroy(setflag);
    memory->destroy(cutsq);
  }
}

void PairGranEllipsoid::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  if (neighbor->ago > 0) require_listed_atoms();
  if (!update->setupflag) require_end_of_run();
  end_of_run.known = false;
  listed = atom->nlocal + atom->nghost;
  // Commands may have changed types, masses and shapes before a run that goes on with an old list ('run ... pre no', 'run ... every'). LAMMPS
  // computes no forces when such a run starts.
  const bool grains_may_differ = shapes_may_change || update->setupflag || update->ntimestep == update->firststep + 1;
  if (neighbor->ago == 0 || grains_may_differ) require_allowed_sizes();
  if (neighbor->ago == 0) {
    // A fix may have added atoms.
    atoms.require_shapes(~0);
    atoms.sort_shapes();
    refresh_body_masses();
  } else if (grains_may_differ) {
    // Ghosts were given theirs when the list was built.
    shapes_in_message = true;
    comm->forward_comm(this);
    shapes_in_message = false;
    // A new list is a new beginning for contacts of atoms that have got another type, and between lists there is none.
    if (shapes_may_change && !update->setupflag && fix_history && fix_history->types_have_changed())
      error->all(FLERR,
                 "{}: a fix has given atoms another type, under whose law contacts remember something else, between two neighbour lists: use "
                 "'neigh_modify every 1 check no', or laws that remember the same",
                 CALLER);
  }
  require_same_images();
  refresh_contact_masses();
  std::fill_n(pvector, nextra, 0.0);
  reserve_loads();
  tallies.normal_elastic_energy = tallies.tangential_elastic_energy = tallies.touching_count = 0.0;
  std::fill_n(tallies.virial, 6, 0.0);
  const bool records = contacts_wanted && computes_ask_for_contacts(modify, update->ntimestep);
  step_of_contacts = records ? update->ntimestep : -1;
  // A processor without atoms still takes part in the messages of others.
  if (atom->nlocal + atom->nghost > 0 || fix_step_velocity || velocities_of_step) add_forces();
  follow_dissipation();
  // What acts on a ghost acts on its owner.
  if (work_wanted && force->newton_pair) {
    const bool others = images_move();
    if (others) image_powers = inelastic_powers(atom->nlocal + atom->nghost);
    comm->reverse_comm(this);
    if (others) {
      const auto of_owners = inelastic_powers(atom->nlocal);
      for (int k = 0; k < 2; k++) image_powers[k] -= of_owners[k];
    } else
      image_powers = {};
  }
  if (work_wanted && update->ntimestep == output->next_restart) gather_work();
}

EllgranNeighbourList PairGranEllipsoid::view_list() const
{
  EllgranNeighbourList neighbours = ELLGRAN_INIT(EllgranNeighbourList);
  neighbours.count = list->inum;
  neighbours.central = list->ilist;
  neighbours.neighbour_counts = list->numneigh;
  neighbours.neighbours = list->firstneigh;
  neighbours.index_mask = NEIGHMASK;
  neighbours.special_shift = SBBITS;
  neighbours.special_factors = (atom->molecular == Atom::ATOMIC) ? nullptr : force->special_lj;
  neighbours.touching = fix_history ? fix_history->firstflag : nullptr;
  neighbours.history = fix_history ? fix_history->firstvalue : nullptr;
  neighbours.newton = force->newton_pair;
  // LAMMPS counts the calls since it last built the list; what init() resolves comes with a new list.
  neighbours.unchanged = (neighbor->ago > 0) ? 1 : 0;
  // In a run the fix that owns the arrays asks for what they miss before it reads them, and before the
  // list is built anew. Elsewhere (set-up, minimisation, rerun) a new list may come unannounced.
  // What records the histories before each evaluation reads them in each step.
  neighbours.keep_history =
      (fix_history && !evaluation_wanted && update->setupflag == 0 && update->whichflag == 1) ? 1 : 0;
  return neighbours;
}

void PairGranEllipsoid::write_history()
{
  if (!fix_history || !list) return;
  if (update->setupflag == 0) require_listed_atoms();
  const EllgranNeighbourList neighbours = view_list();
  if (ellgran_write_history(workspace, &neighbours) != ELLGRAN_SUCCESS)
    error->one(FLERR, "{}: {}", CALLER, ellgran_last_error());
}

void PairGranEllipsoid::add_forces()
{
  EllgranParticles particles = atoms.view();
  // Without friction the law takes the velocities of the step for all, and nobody asks for those of the half step.
  const bool half_step_wanted = work_wanted || evaluation_wanted || ellgran_laws_memory_offset(laws) >= 0;
  if (velocities_of_step) velocities_of_step->lend_changes(particles, half_step_wanted);
  if (fix_step_velocity) fix_step_velocity->replace_velocities(particles, true);
  if (contact_mass_differs) particles.contact_masses = contact_masses.data();
  EllgranNeighbourList neighbours = view_list();
  neighbours.record_contacts = has_contacts_of(update->ntimestep) ? 1 : 0;
  positions_of_contacts.clear();
  if (neighbours.record_contacts && particles.count > 0)
    positions_of_contacts.assign(particles.positions, particles.positions + 3 * particles.count);

  EllgranStep step = ELLGRAN_INIT(EllgranStep);
  step.time_step = update->dt;
  step.advance_history = time_passes() ? 1 : 0;

  evaluation.count = -1;
  if (evaluation_wanted) record_evaluation(particles, neighbours, step);

  const bool tally = evflag || work_wanted;
  tallies.particle_energies = eflag_atom ? eatom : nullptr;
  tallies.particle_virials = vflag_atom ? vatom[0] : nullptr;
  tallies.inelastic_loads = work_wanted ? inelastic_loads.data() : nullptr;
  const double viscous = tallies.viscous_dissipation;

  step_prepared = -1;
  if (ellgran_compute_pairs(laws, workspace, &particles, &neighbours, &step,
                            tally ? &tallies : nullptr) != ELLGRAN_SUCCESS)
    error->one(FLERR, "{}: {}", CALLER, ellgran_last_error());
  if (time_passes()) step_prepared = update->ntimestep;
  if (!tally) return;

  // Nobody asked for what is dissipated: the sums stand still.
  if (!work_wanted) tallies.viscous_dissipation = viscous;
  if (eflag_global) eng_vdwl += tallies.normal_elastic_energy + tallies.tangential_elastic_energy;
  if (vflag_global)
    for (int k = 0; k < 6; k++) virial[k] += tallies.virial[k];
}

/* Friction has dissipated the work of the tangential forces less what the contacts hold of it. Where no time passes
   - when a run starts, perhaps with other laws or after steps that nobody followed - nothing is dissipated. */

void PairGranEllipsoid::follow_dissipation()
{
  if (work_wanted && time_passes())
    friction = tallies.tangential_work - tallies.tangential_elastic_energy;
  else
    tallies.tangential_work = friction + tallies.tangential_elastic_energy;
  if (!eflag_global) return;
  pvector[NORMAL_ELASTIC] = tallies.normal_elastic_energy;
  pvector[TANGENTIAL_ELASTIC] = tallies.tangential_elastic_energy;
  pvector[DISSIPATED] = tallies.viscous_dissipation + friction;
  pvector[TOUCHING] = tallies.touching_count;
  pvector[VISCOUS_DISSIPATION] = tallies.viscous_dissipation;
  pvector[FRICTIONAL_DISSIPATION] = friction;
}

/* LAMMPS computes forces anew when a run starts, from the state that the last run left: time does
   not pass then. Nor does it in a minimisation. */

bool PairGranEllipsoid::time_passes() const
{
  return update->setupflag == 0 && update->whichflag != 2;
}

void PairGranEllipsoid::place_half_step_fix()
{
  if (!work_wanted || modify->get_fix_by_id(half_step_fix_id(id_placeholder))) return;
  fix_half_step = add_half_step(modify, half_step_fix_id(id_placeholder));
  fix_half_step->after_half_step = [this] { add_following_half_step(); };
}

/* Before the first evaluation of a run there are no loads, as on a rank without atoms. */

void PairGranEllipsoid::reserve_loads()
{
  tallies.inelastic_loads = nullptr;
  if (!work_wanted) return;
  inelastic_loads.assign(static_cast<std::size_t>(atom->nlocal + atom->nghost) * LOADS_PER_ATOM, 0.0);
}

/* Half of the work of a force is done with the velocity to which it has led. */

void PairGranEllipsoid::add_following_half_step()
{
  if (!work_wanted || !tallies.inelastic_loads) return;
  EllgranStep step = ELLGRAN_INIT(EllgranStep);
  step.time_step = update->dt;
  step.advance_history = 1;
  EllgranParticles particles = atoms.view();
  if (velocities_of_step) velocities_of_step->lend_changes(particles, false);
  if (fix_step_velocity && fix_step_velocity->box_moves()) fix_step_velocity->replace_velocities(particles, false);
  if (ellgran_tally_following_half_step(&particles, &step, &tallies) != ELLGRAN_SUCCESS)
    error->one(FLERR, "{}: {}", CALLER, ellgran_last_error());
  // Loads of images act on their owners now, but images across the boundaries of a deforming box have other velocities.
  tallies.viscous_dissipation -= 0.5 * update->dt * image_powers[0];
  tallies.tangential_work -= 0.5 * update->dt * image_powers[1];
  atoms.require_finite(tallies.viscous_dissipation, tallies.tangential_work);
}

/* Powers of the viscous forces and of the other tangential ones on the centres of the first atoms. Images turn as their
   owners do, so that torques do not tell them apart. */

std::array<double, 2> PairGranEllipsoid::inelastic_powers(int count) const
{
  std::array<double, 2> powers{};
  const bool found = fix_step_velocity && fix_step_velocity->box_moves();
  for (int i = 0; i < count; i++) {
    const double *const load = &inelastic_loads[static_cast<std::size_t>(i) * LOADS_PER_ATOM];
    for (int k = 0; k < 3; k++) {
      const double velocity = atom->v[i][k] + (found ? fix_step_velocity->found(i)[k] : 0.0);
      powers[0] += load[k] * velocity;
      powers[1] += load[6 + k] * velocity;
    }
  }
  return powers;
}

int PairGranEllipsoid::pack_reverse_comm(int n, int first, double *buffer)
{
  if (step_sums) {
    const int length = std::min(LOADS_PER_ATOM, ELLGRAN_STEP_SUMS_LENGTH - step_sums_from);
    for (int k = 0; k < n; k++)
      buffer = std::copy_n(step_sums + static_cast<std::size_t>(first + k) * ELLGRAN_STEP_SUMS_LENGTH + step_sums_from,
                           length, buffer);
    return n * length;
  }
  std::copy_n(inelastic_loads.data() + static_cast<std::size_t>(first) * LOADS_PER_ATOM,
              n * LOADS_PER_ATOM, buffer);
  return n * LOADS_PER_ATOM;
}

void PairGranEllipsoid::unpack_reverse_comm(int n, int *indices, double *buffer)
{
  if (step_sums) {
    const int length = std::min(LOADS_PER_ATOM, ELLGRAN_STEP_SUMS_LENGTH - step_sums_from);
    for (int k = 0; k < n; k++) {
      double *of_atom = step_sums + static_cast<std::size_t>(indices[k]) * ELLGRAN_STEP_SUMS_LENGTH + step_sums_from;
      for (int c = 0; c < length; c++) of_atom[c] += *buffer++;
    }
    return;
  }
  for (int k = 0; k < n; k++) {
    double *loads = &inelastic_loads[static_cast<std::size_t>(indices[k]) * LOADS_PER_ATOM];
    for (int c = 0; c < LOADS_PER_ATOM; c++) loads[c] += buffer[k * LOADS_PER_ATOM + c];
  }
}

/* Grains may have been moved since the forces were computed: 'fix deform' changes the box at the end of a step. */

void PairGranEllipsoid::add_to_grain_sums(const EllgranParticles &present, double *sums) const
{
  EllgranParticles particles = present;
  if (positions_of_contacts.size() != 3 * particles.count)
    error->one(FLERR, "{}: atoms have come or gone since the contacts of this step were recorded: {} were there, and {} are there now", CALLER,
               positions_of_contacts.size() / 3, particles.count);
  particles.positions = positions_of_contacts.data();
  if (ellgran_add_recorded_to_grain_sums(workspace, &particles, force->newton_pair, sums) != ELLGRAN_SUCCESS)
    error->one(FLERR, "{}: {}", CALLER, ellgran_last_error());
}

void PairGranEllipsoid::record_evaluation(const EllgranParticles &particles,
                                          const EllgranNeighbourList &neighbours,
                                          const EllgranStep &step)
{
  Evaluation &e = evaluation;
  e.step = step;
  e.count = atom->nlocal + atom->nghost;
  e.positions.clear();
  e.velocities.clear();
  e.angular_momenta.clear();
  if (e.count > 0) {
    e.positions.assign(particles.positions, particles.positions + 3 * e.count);
    e.velocities.assign(particles.velocities, particles.velocities + 3 * e.count);
    e.angular_momenta.assign(particles.angular_momenta, particles.angular_momenta + 3 * e.count);
  }
  e.of_step = particles.velocity_changes != nullptr;
  e.changes.assign(e.of_step ? 6 * static_cast<std::size_t>(e.count) : 0, 0.0);
  // Without friction the library does not read them.
  if (e.of_step && e.count > 0 && ellgran_laws_memory_offset(laws) >= 0)
    std::copy_n(particles.velocity_changes, e.changes.size(), e.changes.begin());
  e.rows.assign(e.count, -1);
  e.touching.clear();
  e.history.clear();
  if (!fix_history) return;
  for (std::size_t k = 0; k < neighbours.count; k++) {
    const int i = neighbours.central[k], n = neighbours.neighbour_counts[i];
    if (n == 0) continue;
    e.rows[i] = static_cast<int>(e.touching.size());
    e.touching.insert(e.touching.end(), neighbours.touching[i], neighbours.touching[i] + n);
    e.history.insert(e.history.end(), neighbours.history[i],
                     neighbours.history[i] + n * history_length);
  }
}

void PairGranEllipsoid::allocate()
{
  allocated = 1;
  const int n = atom->ntypes + 1;
  memory->create(setflag, n, n, "pair:setflag");
  memory->create(cutsq, n, n, "pair:cutsq");
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      setflag[i][j] = 0;
      cutsq[i][j] = 0.0;
    }
  EllgranLawParameters unset = ELLGRAN_INIT(EllgranLawParameters);
  ellgran_law_parameters_default(&unset);
  parameters.assign(static_cast<std::size_t>(atom->ntypes) * atom->ntypes, unset);
}

void PairGranEllipsoid::settings(int narg, char **arg)
{
  if (narg > 1)
    error->all(FLERR,
               "{}: unexpected word '{}': the syntax is 'pair_style gran/ellipsoid [cutoff]'; laws "
               "and their constants belong to pair_coeff",
               CALLER, arg[1]);
  cutoff_global = -1.0;
  if (narg == 1) {
    cutoff_global = utils::numeric(FLERR, arg[0], false, lmp);
    if (!std::isfinite(cutoff_global) || cutoff_global <= 0.0)
      error->all(FLERR, "{}: cutoff {} must be a finite positive length", CALLER, arg[0]);
  }
}

void PairGranEllipsoid::coeff(int narg, char **arg)
{
  const bool from_file = narg == 2 && !restored_flags.empty();
  if (narg < 2) error->all(FLERR, "{}: pair_coeff needs two types and a law: pair_coeff I J LAW", CALLER);
  if (!allocated) allocate();

  int ilo, ihi, jlo, jhi;
  utils::bounds(FLERR, arg[0], 1, atom->ntypes, ilo, ihi, error);
  utils::bounds(FLERR, arg[1], 1, atom->ntypes, jlo, jhi, error);

  EllgranLawParameters given = ELLGRAN_INIT(EllgranLawParameters);
  if (!from_file && ellgran_law_parameters_parse(narg - 2, arg + 2, nullptr, &given) != ELLGRAN_SUCCESS)
    error->all(FLERR, "{}: pair_coeff {} {}: {}", CALLER, arg[0], arg[1], ellgran_last_error());

  int count = 0;
  const int ntypes = atom->ntypes;
  for (int i = ilo; i <= ihi; i++)
    for (int j = std::max(jlo, i); j <= jhi; j++) {
      if (from_file) {
        if (take_restored(i, j)) count++;
        continue;
      }
      parameters[(i - 1) * ntypes + (j - 1)] = given;
      setflag[i][j] = 1;
      count++;
    }
  if (count == 0 && from_file)
    error->all(FLERR, "{}: pair_coeff {} {} names no law, and the restart file has none for these types", CALLER,
               arg[0], arg[1]);
  if (count == 0)
    error->all(FLERR, "{}: pair_coeff {} {} sets no pair of types with I <= J", CALLER, arg[0],
               arg[1]);
}

/* Of LAMMPS' settings, which may change between runs. */

void PairGranEllipsoid::require_settings() const
{
  atoms.require_atom_style();
  if (BorderGroup::of(comm))
    error->all(FLERR,
               "{}: 'comm_modify group' hides ghost atoms of other groups, and contacts with them would be missed: "
               "remove it",
               CALLER);
  if (utils::strmatch(update->integrate_style, "^respa"))
    error->all(FLERR, "{} does not support rRESPA: use 'run_style verlet'", CALLER);
  if (atom->molecular != Atom::ATOMIC)
    for (int k = 1; k < 4; k++)
      if (force->special_lj[k] != 0.0 && force->special_lj[k] != 1.0)
        error->all(FLERR,
                   "{}: special_bonds factor {} scales a contact force: only 0 and 1 are supported",
                   CALLER, force->special_lj[k]);
}

void PairGranEllipsoid::init_style()
{
  require_host_kokkos(lmp, CALLER);
  require_settings();
  end_of_run.set_up_since = true;
  if (comm->ghost_velocity == 0)
    error->all(FLERR,
               "{} requires the velocities of ghost atoms: add 'comm_modify vel yes' to the input",
               CALLER);
  refuse_other_atoms_after_reading();
  atoms.require_shapes(~0);
  atoms.count_ellipsoids();
  warn_of_masses();

  shapes_may_change = atoms.shapes_may_change();

  gather_work();
  work_wanted = computes_ask_for_energies(modify);
  evaluation_wanted = !modify->get_compute_by_style("^pair/local$").empty();
  evaluation.count = -1;
  contacts_wanted = !modify->get_compute_by_style("^contact/ellipsoid/atom$").empty();

  find_largest_semi_axes();
  find_mass_sources();
  build_laws();
  tell_step_limits();
  refuse_what_cannot_work();
  place_history_fix();
  place_step_velocity_fix();
  place_half_step_fix();

  // Only `atom_style ellipsoid superellipsoid` has a per-atom radius that encloses the shape; else
  // the list is cut at the largest semi-axes of the two types. A list cut by radius marks in its
  // entries what may touch; the other does not, and then every entry keeps its history.
  // A list cut by radius holds no pairs that touch only after they have grown.
  const bool by_size = atoms.has_enclosing_radius() && !shapes_may_change;
  int request = NeighConst::REQ_DEFAULT;
  if (by_size) request |= NeighConst::REQ_SIZE;
  if (by_size && history_length > 0) request |= NeighConst::REQ_HISTORY;
  neighbor->add_request(this, request);
  if (fix_history) fix_history->use_bit_flag = by_size ? 1 : 0;
}

/* LAMMPS moves the last atom to the place of one that it deletes, and not what the file has of it for fixes; of one that is added it has nothing. */

void PairGranEllipsoid::refuse_other_atoms_after_reading() const
{
  if (modify->nfix_restart_peratom == 0 || atoms_in_file == 0 || atom->natoms == atoms_in_file) return;
  const bigint gone = atoms_in_file - atom->natoms;
  error->all(FLERR,
             "{}: {} atoms were {} since read_restart, and LAMMPS gives what the file remembers of contacts to other ones: say 'run 0' "
             "after read_restart and the fixes, before them",
             CALLER, std::abs(gone), (gone > 0) ? "deleted" : "added");
}

double PairGranEllipsoid::init_one(int i, int j)
{
  double cutoff = largest[i] + largest[j];
  if (cutoff_global > 0.0) {
    if (cutoff_global < cutoff)
      error->all(FLERR,
                 "{}: cutoff {} is smaller than {}, the sum of the largest semi-axes of types {} "
                 "and {}: contacts would be missed",
                 CALLER, cutoff_global, cutoff, i, j);
    return cutoff_global;
  }
  // A type without atoms yet must not shrink the bins of the neighbour list: let it be as large as
  // the largest.
  if (largest[i] <= 0.0 || largest[j] <= 0.0)
    cutoff = 2.0 * *std::max_element(largest.begin(), largest.end());
  return cutoff;
}

void PairGranEllipsoid::find_largest_semi_axes()
{
  const int ntypes = atom->ntypes;
  std::vector<double> mine = atoms.largest_semi_axes();
  largest.assign(ntypes + 1, 0.0);
  MPI_Allreduce(mine.data(), largest.data(), ntypes + 1, MPI_DOUBLE, MPI_MAX, world);

  // Those that a fix will insert.
  for (auto *fix : modify->get_fix_by_style("^pour/ellipsoid$"))
    for (int type = 1; type <= ntypes; type++) {
      int of_type = type;
      if (const auto *axis = static_cast<const double *>(fix->extract("radius", of_type)))
        largest[type] = std::max(largest[type], *axis);
    }

  const double largest_of_all = *std::max_element(largest.begin(), largest.end());
  allowed = largest;
  for (double &axis : allowed) {
    if (cutoff_global > 0.0)
      axis = 0.5 * cutoff_global;
    else if (axis <= 0.0)
      axis = largest_of_all;
  }
}

/* Some commands between two runs (velocity create, delete_atoms) take images away, or move atoms to other places of the
   arrays. A run without set-up goes on with the list of the one before it. */

void PairGranEllipsoid::require_listed_atoms() const
{
  const int now = atom->nlocal + atom->nghost;
  if (now != listed)
    error->one(FLERR,
               "{}: the neighbour list is of {} atoms and images, but there are {} now: a command between two runs has changed "
               "them: leave out 'pre no' in the run that follows it",
               CALLER, listed, now);
}

/* Others (write_restart, write_data) may leave as many there, and put atoms that have crossed a periodic boundary back into the box, or images into
   another order. */

void PairGranEllipsoid::note_end_of_run()
{
  end_of_run.known = true;
  end_of_run.set_up_since = false;
  end_of_run.ids.assign(atom->tag, atom->tag + atom->nlocal + atom->nghost);
  end_of_run.positions.clear();
  if (atom->nlocal > 0) end_of_run.positions.assign(atom->x[0], atom->x[0] + 3 * static_cast<std::size_t>(atom->nlocal));
}

void PairGranEllipsoid::require_end_of_run()
{
  if (!end_of_run.known) return;
  const auto message = [](const std::string &what) {
    return fmt::format("{}: {} by a command between two runs, and the neighbour list is of what was before: leave out 'pre no' in the run that follows it",
                       CALLER, what);
  };
  // A new list in the first step finds what contacts remember by images that are no longer there. All ranks know it.
  if (end_of_run.set_up_since) error->all(FLERR, message("LAMMPS has been set up anew"));
  if (fix_history && fix_history->types_have_changed())
    error->all(FLERR, message("atoms have got another type, under whose law contacts remember something else,"));
  const auto stop = [this, &message](const std::string &what) { error->one(FLERR, message(what)); };
  if (neighbor->ago == 0) return;
  if (!std::equal(end_of_run.ids.begin(), end_of_run.ids.end(), atom->tag)) stop("atoms or images have been put into another order");
  for (int i = 0; i < atom->nlocal; i++)
    for (int k = 0; k < 3; k++)
      if (domain->periodicity[k] && std::fabs(atom->x[i][k] - end_of_run.positions[3 * static_cast<std::size_t>(i) + k]) > 0.5 * domain->prd[k])
        stop(fmt::format("atom {} has been put back into the periodic box", atom->tag[i]));
}

/* Atoms that another fix made larger, or added, since the cutoffs were made would miss contacts. */

void PairGranEllipsoid::require_allowed_sizes() const
{
  const std::vector<double> now = atoms.largest_semi_axes();
  for (int type = 1; type <= atom->ntypes; type++)
    if (now[type] > allowed[type])
      error->one(FLERR,
                 "{}: a particle of type {} has a semi-axis of {} now, but the cutoffs made when "
                 "the run started allow {}: give 'pair_style gran/ellipsoid' a cutoff of at least {}",
                 CALLER, type, now[type], allowed[type], 2.0 * now[type]);
}

/* LAMMPS of 4 Jul 2026 writes the quaternions of images over velocities of others, where KOKKOS packs the messages itself
   and images have velocities (AtomVecEllipsoidKokkos_PackCommBonus). Told once a list: the first step after it was built. */

void PairGranEllipsoid::require_same_images()
{
  if (!lmp->kokkos || update->setupflag || neighbor->ago != 1) return;
  momenta_in_message = true;
  images_differ = false;
  comm->forward_comm(this, 3);
  momenta_in_message = false;
  if (images_differ)
    error->one(FLERR,
               "{}: KOKKOS gave images of grains other velocities than the grains have, as LAMMPS of 4 Jul 2026 does with 'package "
               "kokkos comm host' and 'comm device': use 'package kokkos comm no'",
               CALLER);
}

void PairGranEllipsoid::warn_of_masses()
{
  const std::string text = atoms.implausible_masses();
  if (!text.empty() && text != warned && comm->me == 0)
    error->warning(FLERR, "{}: {}", CALLER, text);
  warned = text;
}

/* Which time step the grains allow as they are when a run starts, and a warning where that of the run is longer. */

void PairGranEllipsoid::tell_step_limits()
{
  const int ntypes = atom->ntypes;
  std::vector<uint8_t> used(parameters.size(), 0);
  for (int i = 1; i <= ntypes; i++)
    for (int j = i; j <= ntypes; j++) used[(i - 1) * ntypes + (j - 1)] = has_law(i, j) ? 1 : 0;
  limits.find(atoms, laws, parameters, used);
  const std::string text = limits.describe(), excess = limits.excess();
  if (comm->me == 0) {
    if (!text.empty() && text != limits_told) utils::logmesg(lmp, "  {}\n", text);
    if (!excess.empty() && excess != excess_told) error->warning(FLERR, "{}: {}", CALLER, excess);
  }
  limits_told = text;
  excess_told = excess;
}

/* What images do beyond their owners, because the box moves, is known where one processor has a contact and the other is told of it. Said once. */

void PairGranEllipsoid::warn_of_unknown_energies()
{
  if (unknown_energies_told || !work_wanted || force->newton_pair || !images_move()) return;
  unknown_energies_told = true;
  if (comm->me == 0)
    error->warning(FLERR,
                   "{}: the box changes, and with 'newton off' the energies that contacts across its periodic boundaries dissipate are wrong: "
                   "use 'newton on' for values 3, 5 and 6 of compute pair",
                   CALLER);
}

/* Whether images across the boundaries have other velocities than the atoms that they are images of. */

bool PairGranEllipsoid::images_move() const
{
  return domain->deform_vremap || (fix_step_velocity && fix_step_velocity->box_moves());
}

/* A law that needs masses takes those of the grains. That of one which no force moves counts too, as long as nothing tells that it is held: LAMMPS
   does not say whether 'fix move' leaves a direction free. Said once for a number. */

void PairGranEllipsoid::warn_of_grains_at_rest()
{
  if (update->whichflag != 1 || ellgran_laws_uses_mass(laws) == 0) return;
  int moved_by_forces = freeze_group_bit;
  bool integrates = false;
  for (const auto *fix : modify->get_fix_list()) {
    if (!fix->time_integrate || utils::strmatch(fix->style, "^move")) continue;
    moved_by_forces |= fix->groupbit;
    integrates = true;
  }
  bigint here = 0, count = 0;
  for (int i = 0; i < atom->nlocal; i++)
    if (!(atom->mask[i] & moved_by_forces)) here++;
  MPI_Allreduce(&here, &count, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (!integrates || count == at_rest_told) return;
  at_rest_told = count;
  if (count > 0 && comm->me == 0)
    error->warning(FLERR,
                   "{}: {} grains are moved by 'fix move' or by no fix, and count with their own mass in 'damping restitution': what hits them "
                   "rebounds faster than that asks for. Give these grains 'fix freeze', beside 'fix move' too, if no force is to move them",
                   CALLER, count);
}

/* Neighbour lists are built now: a warning where the contacts that exist do not allow the time step. Said once for a step. */

void PairGranEllipsoid::setup()
{
  warn_of_unknown_energies();
  warn_of_grains_at_rest();
  if (update->whichflag == 2 || update->dt == step_told) return;
  EllgranSceneStep scene(lmp, CALLER);
  scene.find_sources();
  if (scene.first_pair() != this) return;    // under pair_style hybrid one speaks for all
  scene.find();
  if (!(update->dt > scene.stable_step())) return;
  step_told = update->dt;
  if (comm->me == 0)
    error->warning(FLERR,
                   "{}: the time step {:.4g} is longer than {:.4g}, the largest with which the contacts that exist now are stable "
                   "(that of atom {} limits it): grains may gain energy and be lost: reduce the time step to that or less",
                   CALLER, update->dt, scene.stable_step(), scene.limiting_particle());
}

void PairGranEllipsoid::add_to_step_sums(EllgranWorkspace *own, const EllgranParticles &particles, double *sums,
                                         EllgranContactExtremes *extremes) const
{
  if (!laws || !list) error->all(FLERR, "{}: there are no contacts yet: 'run 0' first", CALLER);
  const EllgranNeighbourList neighbours = view_list();
  if (ellgran_add_pairs_to_step_sums(laws, own, &particles, &neighbours, sums, extremes) != ELLGRAN_SUCCESS)
    error->one(FLERR, "{}: {}", CALLER, ellgran_last_error());
}

/* In as many messages as the loads of a step have room for. */

void PairGranEllipsoid::add_step_sums_of_images(double *sums)
{
  step_sums = sums;
  for (step_sums_from = 0; step_sums_from < ELLGRAN_STEP_SUMS_LENGTH; step_sums_from += LOADS_PER_ATOM)
    comm->reverse_comm(this, std::min(LOADS_PER_ATOM, ELLGRAN_STEP_SUMS_LENGTH - step_sums_from));
  step_sums = nullptr;
}

void PairGranEllipsoid::tell_contact_masses(std::vector<double> &masses) const
{
  const int count = atom->nlocal + atom->nghost;
  masses.resize(count);
  for (int i = 0; i < count; i++)
    masses[i] = (atom->mask[i] & freeze_group_bit) ? std::numeric_limits<double>::infinity() : contact_mass(i);
}

/* The laws of the pairs of types, a line each, those that were given first. Beyond LINES_OF_LAWS lines only a count. */

std::string PairGranEllipsoid::describe_laws() const
{
  std::string text;
  int lines = 0;
  bigint given_left = 0, mixed_left = 0;
  for (const bool given : {true, false})
    for (int i = 1; i <= atom->ntypes; i++)
      for (int j = i; j <= atom->ntypes; j++) {
        if ((setflag[i][j] != 0) != given || !has_law(i, j)) continue;
        char line[512] = "";
        if (lines == LINES_OF_LAWS)
          (given ? given_left : mixed_left)++;
        else if (ellgran_laws_describe(laws, i, j, line, sizeof line) == ELLGRAN_SUCCESS) {
          text += fmt::format("  {} {}{}: {}\n", i, j, given ? "" : " (mixed)", line);
          lines++;
        }
      }
  if (given_left + mixed_left > 0)
    text += fmt::format("  and {} more pairs of types ({} given, {} mixed)\n", given_left + mixed_left,
                        given_left, mixed_left);
  return text;
}

/* Under pair_style hybrid some types may belong to other styles alone: LAMMPS never asks for their pairs here. */

bool PairGranEllipsoid::has_law(int i, int j) const
{
  return setflag[i][j] || (setflag[i][i] && setflag[j][j]);
}

/* The laws of the pairs of so many types, those of atoms first; the others have none yet. */

void PairGranEllipsoid::fill_laws(int types, std::vector<EllgranLawParameters> &given, std::vector<uint8_t> &is_set) const
{
  const int ntypes = atom->ntypes;
  std::vector<uint8_t> chosen(parameters.size(), 0);
  for (int i = 1; i <= ntypes; i++)
    for (int j = i; j <= ntypes; j++) chosen[(i - 1) * ntypes + (j - 1)] = setflag[i][j] ? 1 : 0;
  complete_laws(ntypes, parameters, chosen, types, given, is_set);
}

void PairGranEllipsoid::build_laws()
{
  const int ntypes = atom->ntypes;
  std::vector<EllgranLawParameters> given;
  std::vector<uint8_t> is_set;
  fill_laws(ntypes, given, is_set);

  // Two spheres need no remembered normal to start the search for contact from.
  int spheres_here = atoms.all_spheres() ? 1 : 0, all_spheres = 0;
  MPI_Allreduce(&spheres_here, &all_spheres, 1, MPI_INT, MPI_MIN, world);
  const bool scene_is_fixed = atom->natoms > 0 && !shapes_may_change;
  laws_options = (all_spheres && scene_is_fixed) ? ELLGRAN_OPTION_NO_WARM_START : 0;

  EllgranLaws *const before = laws ? laws : laws_of_file();
  laws = nullptr;
  if (ellgran_laws_new(ntypes, given.data(), is_set.data(), laws_options, &laws) != ELLGRAN_SUCCESS)
    error->all(FLERR, "{}: {}", CALLER, ellgran_last_error());
  // Those of another length are not kept anyway.
  histories_are_of_other_laws = before && ellgran_laws_history_length(laws) == ellgran_laws_history_length(before) &&
      ellgran_laws_read_histories_of(laws, before) == 0;
  ellgran_laws_free(before);

  std::string text = describe_laws();
  text += fmt::format("  history: {} doubles per contact, instruction set: {}\n",
                      ellgran_laws_history_length(laws),
                      ellgran_workspace_instruction_set(workspace));
  if (text != described && comm->me == 0) {
    utils::logmesg(lmp, "{}, ellgran {}:\n{}", CALLER, ellgran_version(), text);
    int32_t i = 0, j = 0;
    if (ellgran_laws_create_energy(laws, &i, &j) != ELLGRAN_SUCCESS)
      error->one(FLERR, "{}: {}", CALLER, ellgran_last_error());
    if (i > 0)
      error->warning(FLERR,
                     "{}: displacement total and displacement incremental can create energy, and nothing in the "
                     "law of types {} and {} dissipates any: use displacement rescaled, or a law with damping",
                     CALLER, i, j);
  }
  described = text;
}

/* Those with which the contacts of a restart file remembered what they do; nullptr without one. */

EllgranLaws *PairGranEllipsoid::laws_of_file() const
{
  if (modify->nfix_restart_peratom == 0 || restored_flags.empty()) return nullptr;
  const int ntypes = atom->ntypes;
  const std::vector<uint8_t> in_file(restored_flags.begin(), restored_flags.end());
  std::vector<EllgranLawParameters> given;
  std::vector<uint8_t> is_set;
  complete_laws(ntypes, restored, in_file, ntypes, given, is_set);
  EllgranLaws *found = nullptr;
  // Where the file has none that can be used, nothing is known.
  ellgran_laws_new(ntypes, given.data(), is_set.data(), laws_options, &found);
  return found;
}

FixEllgranHistory *PairGranEllipsoid::make_history_fix(const std::string &id)
{
  return replace_by_history(modify, id_history, id, history_length);
}

void PairGranEllipsoid::place_history_fix()
{
  history_length = ellgran_laws_history_length(laws);
  scratch.assign(history_length, 0.0);

  // The length is part of the name, so that a restart file is not read with another length.
  const std::string id = (history_length == 0)
      ? id_placeholder
      : fmt::format("{}_{}", id_placeholder, history_length);
  if (((fix_history && id != id_history) || histories_are_of_other_laws) && history_length > 0 && comm->me == 0)
    error->warning(FLERR,
                   "{}: the laws now keep {} values per contact, which are not those that they kept: contacts that exist start "
                   "with no tangential displacement",
                   CALLER, history_length);
  if (id != id_history) {
    if (history_length == 0) {
      modify->replace_fix(id_history, id + " all DUMMY", 0);
      fix_history = nullptr;
    } else {
      fix_history = make_history_fix(id);
    }
    id_history = id;
  }
  if (!fix_history) return;
  if (!modify->get_fix_by_id(id_history))
    error->all(FLERR, "{}: the fix {} that keeps the history of contacts was deleted", CALLER,
               id_history);
  fix_history->pair = this;
  // As long as before, and of another meaning.
  if (histories_are_of_other_laws) fix_history->forget();
  histories_are_of_other_laws = false;
  fix_history->before_reading = [this] { write_history(); };
  meanings.clear();
  fix_history->means_something_else = {};
  if (ellgran_laws_memory_offset(laws) >= 0)
    fix_history->means_something_else = [this](int before, int now) { return means_something_else(before, now); };
  // Where only normals are remembered, from which a search starts, any will do.
  fix_history->tells_contacts_apart = ellgran_laws_memory_offset(laws) >= 0;
}

/* Whether contacts of an atom with some type or other remember another thing where it has the second type and no longer the first. Of laws of
   one type more the last one is the first type, or the second: what else there is, and so what stands in a history, is the same. */

bool PairGranEllipsoid::means_something_else(int before, int now)
{
  const auto known = meanings.find({before, now});
  if (known != meanings.end()) return known->second;
  const int ntypes = atom->ntypes, types = ntypes + 1;
  const auto at = [types](int i, int j) { return static_cast<std::size_t>(std::min(i, j) - 1) * types + (std::max(i, j) - 1); };
  EllgranLaws *made[2] = {nullptr, nullptr};
  for (const int k : {0, 1}) {
    const int type = (k == 0) ? before : now;
    std::vector<EllgranLawParameters> given;
    std::vector<uint8_t> is_set;
    fill_laws(types, given, is_set);
    for (int i = 1; i <= types; i++) {
      const std::size_t target = at(i, types), from = (i == types) ? at(type, type) : at(i, type);
      given[target] = given[from];
      is_set[target] = is_set[from];
    }
    if (ellgran_laws_new(types, given.data(), is_set.data(), laws_options, &made[k]) != ELLGRAN_SUCCESS)
      error->one(FLERR, "{}: {}", CALLER, ellgran_last_error());
  }
  const bool apart = ellgran_laws_read_histories_of(made[1], made[0]) == 0;
  for (EllgranLaws *const one : made) ellgran_laws_free(one);
  meanings[{before, now}] = apart;
  return apart;
}

/* Stops where LAMMPS would go on and compute something else than it says. */

void PairGranEllipsoid::refuse_what_cannot_work()
{
  const bool remembers = ellgran_laws_history_length(laws) > 0;
  refuse_styles(lmp, CALLER, remembers);
  if (remembers && input->command && std::strcmp(input->command, "rerun") == 0)
    error->all(FLERR,
               "{}: 'rerun' reads positions and velocities from a dump, but no orientations, angular "
               "momenta and histories of contacts, which would be those of the last run: write "
               "restart files ('restart N frame.*'), and 'read_restart' and 'run 0' each",
               CALLER);
  if (input->command && std::strcmp(input->command, "pair_write") == 0)
    error->all(FLERR,
               "{}: 'pair_write' tabulates a force over the distance of centres, on which contact forces do not "
               "depend alone",
               CALLER);
}

void PairGranEllipsoid::place_step_velocity_fix()
{
  velocities_of_step = FixNVEEllipsoid::keeper_of(modify);
  fix_step_velocity = place_step_velocity(modify, fix_step_velocity, "ELLGRAN_STEP_VELOCITY_PAIR", id_step_velocity);
}

void PairGranEllipsoid::find_mass_sources()
{
  const auto freezing = modify->get_fix_by_style("^freeze");
  if (freezing.size() > 1) error->all(FLERR, "{}: only one fix freeze is allowed", CALLER);
  freeze_group_bit = freezing.empty() ? 0 : freezing.front()->groupbit;

  fix_rigid = nullptr;
  for (auto *fix : modify->get_fix_list())
    if (fix->rigid_flag) {
      if (fix_rigid) error->all(FLERR, "{}: only one fix rigid is allowed", CALLER);
      fix_rigid = fix;
    }
}

void PairGranEllipsoid::refresh_body_masses()
{
  contact_mass_differs =
      (fix_rigid || freeze_group_bit) && ellgran_laws_uses_mass(laws) != 0;
  if (!fix_rigid || !contact_mass_differs) return;

  int dimension;
  const auto *body = static_cast<int *>(fix_rigid->extract("body", dimension));
  const auto *body_masses = static_cast<double *>(fix_rigid->extract("masstotal", dimension));
  body_mass.assign(atom->nmax, 0.0);
  if (body && body_masses)
    for (int i = 0; i < atom->nlocal; i++)
      if (body[i] >= 0) body_mass[i] = body_masses[body[i]];
  comm->forward_comm(this, 1);
}

void PairGranEllipsoid::refresh_contact_masses()
{
  if (!contact_mass_differs) return;
  const int count = atom->nlocal + atom->nghost;
  contact_masses.resize(count);
  for (int i = 0; i < count; i++) contact_masses[i] = contact_mass(i);
}

double PairGranEllipsoid::contact_mass(int i) const
{
  if (!contact_mass_differs) return atom->rmass[i];
  if (atom->mask[i] & freeze_group_bit) return std::numeric_limits<double>::infinity();
  if (fix_rigid && body_mass[i] > 0.0) return body_mass[i];
  return atom->rmass[i];
}

int PairGranEllipsoid::pack_forward_comm(int n, int *indices, double *buffer, int, int *)
{
  if (momenta_in_message) {
    for (int k = 0; k < n; k++) buffer = std::copy_n(atom->angmom[indices[k]], 3, buffer);
    return 3 * n;
  }
  if (shapes_in_message) {
    atoms.pack_shapes(n, indices, buffer);
    return n * EllgranAtoms::SHAPE_SIZE;
  }
  for (int k = 0; k < n; k++) buffer[k] = body_mass[indices[k]];
  return n;
}

void PairGranEllipsoid::unpack_forward_comm(int n, int first, double *buffer)
{
  if (momenta_in_message) {
    for (int i = first; i < first + n; i++, buffer += 3)
      if (!std::equal(buffer, buffer + 3, atom->angmom[i])) images_differ = true;
    return;
  }
  if (shapes_in_message) {
    atoms.unpack_shapes(n, first, buffer);
    return;
  }
  for (int k = 0; k < n; k++) body_mass[first + k] = buffer[k];
}

/* LAMMPS asks for the history of (j,i) where that of (i,j) was kept. */

void PairGranEllipsoid::transfer_history(double *source, double *target, int, int)
{
  if (ellgran_history_swap(laws, source, target) != ELLGRAN_SUCCESS)
    error->one(FLERR, "{}: {}", CALLER, ellgran_last_error());
}

/* Restart files are written by one rank, which then must hold the sum. */

void PairGranEllipsoid::gather_work()
{
  double mine[2] = {tallies.viscous_dissipation, friction};
  double sums[2] = {0.0, 0.0};
  MPI_Allreduce(mine, sums, 2, MPI_DOUBLE, MPI_SUM, world);
  tallies.viscous_dissipation = (comm->me == 0) ? sums[0] : 0.0;
  friction = (comm->me == 0) ? sums[1] : 0.0;
  tallies.tangential_work = friction + tallies.tangential_elastic_energy;
}

void PairGranEllipsoid::finish()
{
  note_end_of_run();
  gather_work();
  const bigint so_far = ellgran_workspace_deep_contacts_count(workspace);
  bigint deep = so_far - deep_told, sum = 0;
  deep_told = so_far;
  MPI_Allreduce(&deep, &sum, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (sum > 0 && comm->me == 0)
    error->warning(FLERR,
                   "{}: in {} contact evaluations the overlap was deeper than half the local radius of "
                   "curvature, where Hertz' law does not hold and the search is slow: use a stiffer "
                   "material or lower speeds",
                   CALLER, sum);
}

/* `pair_style hybrid` writes and reads the settings of its styles and nothing else: so the coefficients are among
   them. LAMMPS still wants to hear which pairs of types belong to which style; 'pair_coeff I J gran/ellipsoid'
   without a law then takes the law of the file. */

void PairGranEllipsoid::write_restart(FILE *fp)
{
  write_restart_settings(fp);
}

void PairGranEllipsoid::read_restart(FILE *fp)
{
  read_restart_settings(fp);
  if (!allocated) allocate();
  const int ntypes = atom->ntypes;
  for (int i = 1; i <= ntypes; i++)
    for (int j = i; j <= ntypes; j++) take_restored(i, j);
}

/* Whether the restart file had a law of these types, which then is theirs. */

bool PairGranEllipsoid::take_restored(int i, int j)
{
  const std::size_t place = static_cast<std::size_t>(i - 1) * atom->ntypes + (j - 1);
  if (place >= restored_flags.size() || !restored_flags[place]) return false;
  parameters[place] = restored[place];
  setflag[i][j] = 1;
  return true;
}

void PairGranEllipsoid::write_restart_settings(FILE *fp)
{
  const int ntypes = atom->ntypes;
  const int head[2] = {EllgranRestart::PAIR_MARK, EllgranRestart::PAIR_FORMAT};
  char writer[EllgranRestart::WRITER_LENGTH] = "";
  std::snprintf(writer, sizeof writer, "%s", ellgran_version());
  const int sizes[2] = {static_cast<int>(sizeof(EllgranLawParameters)), ntypes};
  fwrite(head, sizeof(int), 2, fp);
  fwrite(writer, 1, sizeof writer, fp);
  fwrite(sizes, sizeof(int), 2, fp);
  const double values[3] = {cutoff_global, tallies.viscous_dissipation, friction};
  fwrite(values, sizeof(double), 3, fp);
  for (int i = 1; i <= ntypes; i++)
    for (int j = i; j <= ntypes; j++) {
      const int flag = (allocated && setflag[i][j]) ? 1 : 0;
      fwrite(&flag, sizeof(int), 1, fp);
      if (flag) fwrite(&parameters[(i - 1) * ntypes + (j - 1)], sizeof(EllgranLawParameters), 1, fp);
    }
}

void PairGranEllipsoid::read_restart_settings(FILE *fp)
{
  const auto read = [this, fp](void *target, std::size_t bytes) {
    if (comm->me == 0) utils::sfread(FLERR, target, 1, bytes, fp, nullptr, error);
    MPI_Bcast(target, static_cast<int>(bytes), MPI_BYTE, 0, world);
  };
  int head[2] = {0, 0};
  char writer[EllgranRestart::WRITER_LENGTH] = "";
  int sizes[2] = {0, 0};
  read(head, sizeof head);
  if (head[0] == EllgranRestart::PAIR_MARK)
    read(writer, sizeof writer);
  else if (head[0] != EllgranRestart::PAIR_MARK_1 || head[1] != 1)
    error->all(FLERR,
               "{}: what the restart file holds of this pair style cannot be read: the file is damaged, or was written on a "
               "machine with another byte order, or by a development version before 0.1.0. Use a data file ('write_data') instead",
               CALLER);
  writer[sizeof writer - 1] = '\0';
  if (head[1] > EllgranRestart::PAIR_FORMAT)
    error->all(FLERR,
               "{}: the restart file has format version {}, written by ellgran {}. This is ellgran {}, which reads versions "
               "1 to {}: use the ellgran that wrote the file, or a later one",
               CALLER, head[1], writer, ellgran_version(), EllgranRestart::PAIR_FORMAT);
  atoms_in_file = atom->natoms;
  read(sizes, sizeof sizes);
  const int parameters_size = sizes[0];
  if (parameters_size <= static_cast<int>(sizeof(size_t)) ||
      parameters_size > static_cast<int>(sizeof(EllgranLawParameters)) || sizes[1] != atom->ntypes)
    error->all(FLERR, "{}: the restart file is damaged: laws of {} bytes for {} atom types, with {} types of atoms", CALLER,
               parameters_size, sizes[1], atom->ntypes);

  double values[3] = {-1.0, 0.0, 0.0};
  read(values, sizeof values);
  cutoff_global = values[0];
  tallies.viscous_dissipation = (comm->me == 0) ? values[1] : 0.0;
  friction = (comm->me == 0) ? values[2] : 0.0;

  const int ntypes = atom->ntypes;
  const EllgranLawParameters unset = ELLGRAN_INIT(EllgranLawParameters);
  restored_flags.assign(static_cast<std::size_t>(ntypes) * ntypes, 0);
  restored.assign(restored_flags.size(), unset);
  for (int i = 1; i <= ntypes; i++)
    for (int j = i; j <= ntypes; j++) {
      const std::size_t place = static_cast<std::size_t>(i - 1) * ntypes + (j - 1);
      read(&restored_flags[place], sizeof(int));
      if (!restored_flags[place]) continue;
      // An older and shorter struct: the fields that it lacks are zero, as everywhere in the interface.
      read(&restored[place], parameters_size);
      restored[place].size = unset.size;
    }
}

/* Copies into `scratch` the history of the pair before the last evaluation, or as it is now if that was not
   recorded; zeros if the list does not hold the pair. */

void PairGranEllipsoid::copy_history(int i, int j, int *touching)
{
  *touching = 0;
  std::fill(scratch.begin(), scratch.end(), 0.0);
  if (!fix_history || !fix_history->firstflag || !list) return;

  const auto find = [this](int central, int other) -> int {
    if (central >= atom->nlocal) return -1;
    const int *neighbours = list->firstneigh[central];
    const int count = list->numneigh[central];
    for (int k = 0; k < count; k++) {
      neighbour_previous++;
      if (neighbour_previous >= count) neighbour_previous = 0;
      if ((neighbours[neighbour_previous] & NEIGHMASK) == other) return neighbour_previous;
    }
    return -1;
  };
  const bool recorded = evaluation.count == atom->nlocal + atom->nghost;
  const auto flag = [&](int central, int k) {
    return recorded ? &evaluation.touching[evaluation.rows[central] + k]
                    : &fix_history->firstflag[central][k];
  };
  const auto values = [&](int central, int k) {
    return recorded
        ? &evaluation.history[static_cast<std::size_t>(evaluation.rows[central] + k) * history_length]
        : &fix_history->firstvalue[central][k * history_length];
  };
  int k = find(i, j);
  if (k >= 0) {
    *touching = *flag(i, k);
    std::copy_n(values(i, k), history_length, scratch.begin());
  } else if ((k = find(j, i)) >= 0) {
    *touching = *flag(j, k);
    transfer_history(values(j, k), scratch.data(), atom->type[j], atom->type[i]);
  }
}

double PairGranEllipsoid::single(int i, int j, int, int, double rsq, double, double factor_lj,
                                 double &fforce)
{
  fforce = 0.0;
  std::fill_n(svector, single_extra, 0.0);
  if (factor_lj == 0.0) return 0.0;
  if (!laws) error->one(FLERR, "{}: no forces yet: 'run 0' first", CALLER);

  // The force that acted: computed once more from what it was computed from.
  const bool recorded = evaluation.count == atom->nlocal + atom->nghost;
  const auto body = [&](int k) {
    if (!recorded) return atoms.body(k, contact_mass(k));
    EllgranBody found = atoms.body(k, contact_mass(k), &evaluation.velocities[3 * k], &evaluation.angular_momenta[3 * k]);
    std::copy_n(&evaluation.positions[3 * static_cast<std::size_t>(k)], 3, found.position);
    if (!evaluation.of_step) return found;
    found.velocities_of_step = 1;
    const double *const change = &evaluation.changes[6 * static_cast<std::size_t>(k)];
    std::copy_n(change, 3, found.velocity_change);
    // Angular velocities are linear in angular momenta.
    const EllgranBody of_change = atoms.body(k, found.mass, change, change + 3);
    std::copy_n(of_change.angular_velocity, 3, found.angular_velocity_change);
    return found;
  };
  const EllgranBody body_i = body(i), body_j = body(j);
  int touching = 0;
  if (!recorded) write_history();
  copy_history(i, j, &touching);

  EllgranStep step = ELLGRAN_INIT(EllgranStep);
  step.time_step = update->dt;
  step.advance_history = 0;
  if (recorded) step = evaluation.step;
  EllgranContactGeometry geometry = ELLGRAN_INIT(EllgranContactGeometry);
  EllgranContactForce contact = ELLGRAN_INIT(EllgranContactForce);
  const bool remembers = history_length > 0;
  if (ellgran_contact(laws, &body_i, &body_j, &step, remembers ? &touching : nullptr,
                      remembers ? scratch.data() : nullptr, &geometry, &contact) != ELLGRAN_SUCCESS)
    error->one(FLERR, "{}: {}", CALLER, ellgran_last_error());
  if (!geometry.touching) return 0.0;

  svector[P_NORMAL_FORCE] = contact.normal_force;
  svector[P_TANGENTIAL_MAGNITUDE] = length(contact.tangential_force);
  svector[P_PENETRATION] = geometry.penetration;
  svector[P_CURVATURE_A] = geometry.curvature_a;
  svector[P_CURVATURE_B] = geometry.curvature_b;
  svector[P_MAJOR_SEMI_AXIS] = contact.contact_semi_axes[0];
  svector[P_MINOR_SEMI_AXIS] = contact.contact_semi_axes[1];
  svector[P_DISPLACEMENT_MAGNITUDE] = length(contact.displacement);
  svector[P_NORMAL_ENERGY] = contact.elastic_energy;
  svector[P_TANGENTIAL_ENERGY] = contact.tangential_energy;
  svector[P_VISCOUS_POWER] = contact.viscous_power;
  svector[P_TANGENTIAL_POWER] = contact.tangential_power;
  for (int k = 0; k < 3; k++) {
    svector[P_TANGENTIAL_FORCE + k] = -contact.tangential_force[k];
    svector[P_CONTACT_POINT + k] = geometry.contact_point[k];
    svector[P_NORMAL + k] = geometry.normal[k];
    svector[P_DISPLACEMENT + k] = contact.displacement[k];
    svector[P_FORCE + k] = -contact.force[k];
    svector[P_TORQUE_FIRST + k] = contact.torque_i[k];
    svector[P_TORQUE_SECOND + k] = contact.torque_j[k];
  }
  if (rsq > 0.0) fforce = contact.normal_force / std::sqrt(rsq);
  return contact.elastic_energy + contact.tangential_energy;
}

void *PairGranEllipsoid::extract(const char *name, int &dimension)
{
  dimension = 0;
  if (std::strcmp(name, "history_length") == 0) return &history_length;
  if (std::strcmp(name, "viscous_dissipation") == 0) return &tallies.viscous_dissipation;
  if (std::strcmp(name, "frictional_dissipation") == 0) return &friction;
  if (std::strcmp(name, "normal_elastic_energy") == 0) return &tallies.normal_elastic_energy;
  if (std::strcmp(name, "tangential_elastic_energy") == 0) return &tallies.tangential_elastic_energy;
  if (std::strcmp(name, "contact_virial") == 0) {
    dimension = 1;
    return tallies.virial;
  }
  return nullptr;
}

double PairGranEllipsoid::memory_usage()
{
  double bytes = Pair::memory_usage();
  bytes += static_cast<double>(body_mass.capacity() + contact_masses.capacity()) * sizeof(double);
  bytes += static_cast<double>(inelastic_loads.capacity() + positions_of_contacts.capacity()) * sizeof(double);
  const Evaluation &e = evaluation;
  bytes += static_cast<double>(e.positions.capacity() + e.velocities.capacity() + e.angular_momenta.capacity() + e.changes.capacity() +
                               e.history.capacity()) * sizeof(double);
  bytes += static_cast<double>(e.rows.capacity() + e.touching.capacity()) * sizeof(int);
  bytes += static_cast<double>(ellgran_workspace_bytes(workspace));
  bytes += static_cast<double>(parameters.capacity()) * sizeof(EllgranLawParameters);
  return bytes;
}
