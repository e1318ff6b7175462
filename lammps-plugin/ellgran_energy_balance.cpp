// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_energy_balance.h"

#include "fix_nve_ellipsoid.h"

#include "ellgran_restart_format.h"
#include "ellgran_substitute.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "modify.h"
#include "pair.h"
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <cstring>
#include <mpi.h>

using namespace LAMMPS_NS;

namespace {

const char PAIR_STYLE[] = "gran/ellipsoid";

// Sign of a term in the sum that stays.
double sign_of(int term)
{
  return (term == FixEllgranEnergyBalance::WORK_OF_WALLS || term == FixEllgranEnergyBalance::WORK_OF_BOX ||
          term == FixEllgranEnergyBalance::BROUGHT)
      ? -1.0
      : 1.0;
}

double dot(const double *a, const double *b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

}    // namespace

FixEllgranEnergyBalance::FixEllgranEnergyBalance(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), atoms(lmp, "Compute energy/ellipsoid"), start{}, before{}, runs(false), walls_are_ready(false),
    box_deforms(false), lower_corner{}, inverse_edges{}, edge_rates{}, corner_rate{}, gradient{}, contact_power(0.0), power(0.0),
    spin{}, work_of_box(0.0), brought(0.0), energy_then(0.0), noted(false)
{
  restart_global = 1;
  nevery = 1;
}

int FixEllgranEnergyBalance::setmask()
{
  using namespace FixConst;
  return INITIAL_INTEGRATE | POST_INTEGRATE | PRE_EXCHANGE | PRE_NEIGHBOR | POST_FORCE | END_OF_STEP;
}

bool LAMMPS_NS::computes_ask_for_energies(const Modify *modify)
{
  return !modify->get_compute_by_style("^pair$").empty() || !modify->get_compute_by_style("^energy/ellipsoid$").empty();
}

void FixEllgranEnergyBalance::init()
{
  find_sources();
  refuse_what_cannot_work();
  box_deforms = domain->deform_vremap != 0;
}

void FixEllgranEnergyBalance::find_sources()
{
  // An error message names the compute, whose ID that of this fix begins with.
  const std::string own = id;
  caller = "Compute energy/ellipsoid " + own.substr(0, own.rfind("_ENERGY_BALANCE"));

  pairs.clear();
  if (utils::strmatch(force->pair_style ? force->pair_style : "", "^hybrid")) {
    for (int number = 1; Pair *found = force->pair_match(PAIR_STYLE, 0, number); number++) {
      // One alone is found by every number.
      if (!pairs.empty() && found == pairs.front()) break;
      pairs.push_back(found);
    }
  } else if (Pair *found = force->pair_match(PAIR_STYLE, 0))
    pairs.push_back(found);

  walls = modify->get_fix_by_style("^wall/gran/ellipsoid$");
  gravities = modify->get_fix_by_style("^gravity");
}

void FixEllgranEnergyBalance::refuse_what_cannot_work() const
{
  if (pairs.empty())
    error->all(FLERR, "{}: the pair style is '{}', and energies are those of 'pair_style {}': give that one, or one of "
               "'pair_style hybrid'", caller, force->pair_style ? force->pair_style : "none", PAIR_STYLE);
  if (utils::strmatch(force->pair_style, "^hybrid/scaled"))
    error->all(FLERR, "{}: 'pair_style hybrid/scaled' scales forces, and the energies dissipated are those of the forces before "
               "that: use 'pair_style hybrid' or 'hybrid/overlay'", caller);

  for (Fix *wall : walls) {
    int dimension = 0;
    if (*static_cast<const bool *>(wall->extract("leaves_energies_out", dimension)))
      error->all(FLERR, "{}: fix {} of style {} sums up no energies: take 'energies no' away", caller, wall->id, wall->style);
  }

  for (const auto *fix : modify->get_fix_list()) {
    const bool deforms = utils::strmatch(fix->style, "^deform");
    if (!deforms && (fix->box_change & (BOX_CHANGE_X | BOX_CHANGE_Y | BOX_CHANGE_Z | BOX_CHANGE_YZ | BOX_CHANGE_XZ | BOX_CHANGE_XY)))
      error->all(FLERR, "{}: fix {} of style {} changes the box, and its work is not known: use 'fix deform ... remap v', or "
                 "remove the compute", caller, fix->id, fix->style);
    if (!deforms) continue;
    if (!domain->deform_vremap || fix->groupbit != 1)
      error->all(FLERR, "{}: fix {} of style {} needs 'remap v' and the group all: otherwise it moves grains without a velocity that "
                 "contacts could know, and its work is not known", caller, fix->id, fix->style);
    if (!force->newton_pair)
      error->all(FLERR, "{}: fix {} of style {} needs 'newton on' for the work of contacts across the boundaries", caller, fix->id,
                 fix->style);
    const Fix *const outer = !walls.empty() ? walls.front() : !gravities.empty() ? gravities.front() : nullptr;
    if (outer)
      error->all(FLERR, "{}: fix {} of style {} moves all grains, and fix {} of style {} does not move along: their common work is not "
                 "known: remove one of them, or the compute", caller, fix->id, fix->style, outer->id, outer->style);
  }
}

/* The pair style has computed its forces when this is called; walls may do so later. */

void FixEllgranEnergyBalance::setup(int)
{
  work_of_box = brought = 0.0;
  noted = false;
  record_box();
  walls_are_ready = false;
  runs = true;
  FixNVEEllipsoid::with_integrated_velocities(modify, [this] {
    start = terms_now();
    power = contact_power + power_of_motion(spin);
  });
}

/* Nobody's forces change between the set-up and the first step. */

void FixEllgranEnergyBalance::complete_start()
{
  if (walls_are_ready) return;
  walls_are_ready = true;
  const Terms now = terms_now();
  for (const int term : {NORMAL_ELASTIC, TANGENTIAL_ELASTIC, VISCOUS_DISSIPATION, FRICTIONAL_DISSIPATION, WORK_OF_WALLS})
    start[term] = now[term];
}

void FixEllgranEnergyBalance::initial_integrate(int)
{
  // Without a set-up ('run ... pre no') a run begins with what the last one ended with.
  runs = true;
  complete_start();
}

/* Grains are inserted and lost when atoms change ranks. Which of two fixes is called first there depends on the order in which
   they were made: the energy is taken before all of them. */

void FixEllgranEnergyBalance::post_integrate()
{
  noted = false;
  if (box_deforms) return;
  for (const auto *fix : modify->get_fix_list())
    if (fix->force_reneighbor && fix->next_reneighbor == update->ntimestep && !utils::strmatch(fix->style, "^deform")) {
      note_energy();
      return;
    }
}

void FixEllgranEnergyBalance::pre_exchange()
{
  if (!noted && !box_deforms) note_energy();
}

void FixEllgranEnergyBalance::note_energy()
{
  Terms terms{};
  add_motion(terms);
  energy_then = terms[TRANSLATION] + terms[ROTATION] + terms[GRAVITY] + energy_of_half_step();
  noted = true;
}

/* Places are those of the step there, and velocities those of half a step before: what gravity adds to the kinetic energy until both are
   of one time. It is all that is known of the forces of this step. */

double FixEllgranEnergyBalance::energy_of_half_step() const
{
  int dimension = 0;
  double sum = 0.0;
  for (int i = 0; i < atom->nlocal; i++) {
    double kick[3] = {0.0, 0.0, 0.0};
    for (Fix *fix : gravities) {
      const auto *acceleration = static_cast<const double *>(fix->extract("gvec", dimension));
      if (!acceleration || !(atom->mask[i] & fix->groupbit)) continue;
      for (int k = 0; k < 3; k++) kick[k] += 0.5 * update->dt * acceleration[k];
    }
    for (int k = 0; k < 3; k++) sum += atom->rmass[i] * kick[k] * (atom->v[i][k] + 0.5 * kick[k]);
  }
  return sum;
}

void FixEllgranEnergyBalance::pre_neighbor()
{
  if (!noted) return;
  const double earlier = energy_then;
  note_energy();
  noted = false;
  brought += energy_then - earlier;
}

/* The box is still the one in which contacts were computed; a fix that deforms it does so at the end of the step. */

void FixEllgranEnergyBalance::post_force(int)
{
  if (box_deforms) record_box();
}

void FixEllgranEnergyBalance::record_box()
{
  std::copy_n(domain->boxlo, 3, lower_corner);
  std::copy_n(domain->h_inv, 6, inverse_edges);
  if (!box_deforms) return;
  std::copy_n(domain->h_rate, 6, edge_rates);
  std::copy_n(domain->h_ratelo, 3, corner_rate);
  const double *const r = edge_rates, *const i = inverse_edges;
  // upper triangular matrices: xx yy zz yz xz xy
  gradient[0] = r[0] * i[0];
  gradient[1] = r[1] * i[1];
  gradient[2] = r[2] * i[2];
  gradient[3] = r[1] * i[3] + r[3] * i[2];
  gradient[4] = r[0] * i[4] + r[5] * i[3] + r[4] * i[2];
  gradient[5] = r[0] * i[5] + r[5] * i[1];

  // d (x) F with d from the first grain of a pair to the second and F on the second: xx yy zz xy xz yz. The gradient wants
  // d_y F_x in the place of d_x F_y; what is between them is the torque on the grains.
  contact_power = 0.0;
  for (Pair *pair : pairs) {
    int dimension = 0;
    const auto *virial = static_cast<const double *>(pair->extract("contact_virial", dimension));
    contact_power -= dot(gradient, virial) + gradient[3] * virial[5] + gradient[4] * virial[4] + gradient[5] * virial[3];
  }
}

void FixEllgranEnergyBalance::velocity_of_box(const double *position, double *velocity) const
{
  double d[3], share[3];
  for (int k = 0; k < 3; k++) d[k] = position[k] - lower_corner[k];
  const double *const i = inverse_edges, *const r = edge_rates;
  share[0] = i[0] * d[0] + i[5] * d[1] + i[4] * d[2];
  share[1] = i[1] * d[1] + i[3] * d[2];
  share[2] = i[2] * d[2];
  velocity[0] = r[0] * share[0] + r[5] * share[1] + r[4] * share[2] + corner_rate[0];
  velocity[1] = r[1] * share[1] + r[3] * share[2] + corner_rate[1];
  velocity[2] = r[2] * share[2] + corner_rate[2];
}

/* Power of the box on the motion of the grains relative to it, and their angular momentum about their centres. */

double FixEllgranEnergyBalance::power_of_motion(double *spin_now) const
{
  std::fill_n(spin_now, 3, 0.0);
  if (!box_deforms) return 0.0;
  double sum = 0.0;
  for (int i = 0; i < atom->nlocal; i++) {
    double c[3];
    velocity_of_box(atom->x[i], c);
    for (int k = 0; k < 3; k++) {
      c[k] = atom->v[i][k] - c[k];
      spin_now[k] += atom->angmom[i][k];
    }
    sum -= atom->rmass[i] *
        (gradient[0] * c[0] * c[0] + gradient[1] * c[1] * c[1] + gradient[2] * c[2] * c[2] + gradient[3] * c[1] * c[2] +
         gradient[4] * c[0] * c[2] + gradient[5] * c[0] * c[1]);
  }
  return sum;
}

void FixEllgranEnergyBalance::end_of_step()
{
  if (!box_deforms) return;
  double spin_now[3];
  const double power_now = contact_power + power_of_motion(spin_now);
  work_of_box += 0.5 * update->dt * (power + power_now);
  // the torque of the step, see record_box
  work_of_box -= gradient[5] * (spin_now[2] - spin[2]) - gradient[4] * (spin_now[1] - spin[1]) +
      gradient[3] * (spin_now[0] - spin[0]);
  power = power_now;
  std::copy_n(spin_now, 3, spin);
}

double FixEllgranEnergyBalance::sum_over_sources(const char *name) const
{
  double sum = 0.0;
  int dimension = 0;
  for (Pair *pair : pairs) sum += *static_cast<const double *>(pair->extract(name, dimension));
  for (Fix *wall : walls) sum += *static_cast<const double *>(wall->extract(name, dimension));
  return sum;
}

/* Energies of the motion of this rank's grains relative to the box, and of their weight. */

void FixEllgranEnergyBalance::add_motion(Terms &terms) const
{
  int dimension = 0;
  for (int i = 0; i < atom->nlocal; i++) {
    double v[3] = {0.0, 0.0, 0.0};
    if (box_deforms) velocity_of_box(atom->x[i], v);
    for (int k = 0; k < 3; k++) v[k] = atom->v[i][k] - v[k];
    const double mass = atom->rmass[i];
    terms[TRANSLATION] += 0.5 * mass * dot(v, v);
    if (atom->ellipsoid[i] >= 0) terms[ROTATION] += 0.5 * dot(atoms.body(i, mass).angular_velocity, atom->angmom[i]);
  }
  for (Fix *fix : gravities) {
    const auto *acceleration = static_cast<const double *>(fix->extract("gvec", dimension));
    if (!acceleration) continue;
    for (int i = 0; i < atom->nlocal; i++) {
      if (!(atom->mask[i] & fix->groupbit)) continue;
      // where the grain would be without periodic boundaries
      const imageint image = atom->image[i];
      const double turns[3] = {static_cast<double>((image & IMGMASK) - IMGMAX),
                               static_cast<double>((image >> IMGBITS & IMGMASK) - IMGMAX),
                               static_cast<double>((image >> IMG2BITS) - IMGMAX)};
      const double *const x = atom->x[i], *const h = domain->h;
      const double place[3] = {x[0] + h[0] * turns[0] + h[5] * turns[1] + h[4] * turns[2],
                               x[1] + h[1] * turns[1] + h[3] * turns[2], x[2] + h[2] * turns[2]};
      terms[GRAVITY] -= atom->rmass[i] * dot(acceleration, place);
    }
  }
}

FixEllgranEnergyBalance::Terms FixEllgranEnergyBalance::terms_now() const
{
  Terms terms{};
  add_motion(terms);
  terms[NORMAL_ELASTIC] = sum_over_sources("normal_elastic_energy");
  terms[TANGENTIAL_ELASTIC] = sum_over_sources("tangential_elastic_energy");
  terms[VISCOUS_DISSIPATION] = sum_over_sources("viscous_dissipation");
  terms[FRICTIONAL_DISSIPATION] = sum_over_sources("frictional_dissipation");
  int dimension = 0;
  for (Fix *wall : walls) terms[WORK_OF_WALLS] += *static_cast<const double *>(wall->extract("work_of_walls", dimension));
  terms[WORK_OF_BOX] = work_of_box;
  terms[BROUGHT] = brought;
  return terms;
}

/* Since the run began. */

std::array<double, FixEllgranEnergyBalance::NUMBER_OF_COLUMNS> FixEllgranEnergyBalance::changes() const
{
  std::array<double, NUMBER_OF_COLUMNS> change{};
  if (!runs) return change;
  const Terms now = terms_now();
  for (int term = 0; term < NUMBER_OF_TERMS; term++) {
    change[term] = now[term] - start[term];
    change[LEFT_OVER] += sign_of(term) * change[term];
  }
  return change;
}

void FixEllgranEnergyBalance::post_run()
{
  if (!runs) return;
  complete_start();
  const auto change = changes();
  for (int column = 0; column < NUMBER_OF_COLUMNS; column++) before[column] += change[column];
  start = terms_now();
  runs = false;
}

void FixEllgranEnergyBalance::sum_columns(double *columns)
{
  if (runs)
    complete_start();
  else
    find_sources();    // commands between runs may have taken some away
  const Terms now = terms_now();
  auto mine = changes();
  for (int column = 0; column < NUMBER_OF_COLUMNS; column++)
    mine[column] = (column < NUMBER_OF_STATES) ? now[column] : mine[column] + before[column];
  MPI_Allreduce(mine.data(), columns, NUMBER_OF_COLUMNS, MPI_DOUBLE, MPI_SUM, world);
}

void FixEllgranEnergyBalance::write_restart(FILE *fp)
{
  auto mine = changes();
  for (int column = 0; column < NUMBER_OF_COLUMNS; column++) mine[column] += before[column];
  double values[1 + NUMBER_OF_COLUMNS] = {EllgranRestart::ENERGY_BALANCE_FORMAT};
  MPI_Allreduce(mine.data(), values + 1, NUMBER_OF_COLUMNS, MPI_DOUBLE, MPI_SUM, world);
  if (comm->me != 0) return;
  const int size = sizeof values;
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(values, sizeof(double), 1 + NUMBER_OF_COLUMNS, fp);
}

void FixEllgranEnergyBalance::restart(char *buffer)
{
  double values[1 + NUMBER_OF_COLUMNS];
  std::memcpy(values, buffer, sizeof(double));
  if (values[0] > EllgranRestart::ENERGY_BALANCE_FORMAT)
    error->all(FLERR, "Compute energy/ellipsoid: the restart file has format version {} of fix {}. This is ellgran {}, which reads version "
               "{}: use the ellgran that wrote the file, or give the compute another ID and begin anew", static_cast<int>(values[0]), id,
               ellgran_version(), EllgranRestart::ENERGY_BALANCE_FORMAT);
  std::memcpy(values, buffer, sizeof values);
  if (comm->me == 0) std::copy_n(values + 1, static_cast<int>(NUMBER_OF_COLUMNS), before.begin());
}

double FixEllgranEnergyBalance::memory_usage()
{
  return static_cast<double>((pairs.capacity() + walls.capacity() + gravities.capacity()) * sizeof(void *));
}

void FixEllgranEnergyBalance::set_molecule(int, tagint, int, double *, double *, double *)
{
  error->all(FLERR, "Molecule update not implemented for fix {}", style);
}

FixEllgranEnergyBalance *LAMMPS_NS::add_energy_balance(Modify *modify, const std::string &id)
{
  const SubstituteFix<FixEllgranEnergyBalance> substitute(modify, "DUMMY");
  return static_cast<FixEllgranEnergyBalance *>(modify->add_fix(id + " all DUMMY"));
}
