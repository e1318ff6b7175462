/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "ellgran_contact.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>

#include "atom.h"
#include "comm.h"
#include "compute_pair_gran_local.h"
#include "contact_models.h"
#include "domain.h"
#include "error.h"
#include "ellgran_pair_history.h"
#include "ellgran_shape.h"
#include "fix_contact_history_ellgran.h"
#include "fix_ellgran_restart_format.h"
#include "fix_nve_ellipsoid.h"
#include "fix_wall_gran.h"
#include "force.h"
#include "global_properties.h"
#include "modify.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "pair_gran.h"
#include "property_registry.h"
#include "update.h"
#include "vector_liggghts.h"

using namespace LAMMPS_NS;

namespace LIGGGHTS {
namespace ContactModels {

namespace {
typedef std::map<ContactModelBase *, EllgranContact *> Table;
Table &table()
{
  static Table all;
  return all;
}

// The neighbour lists are made by the bounding radius, which some commands change without the shape. LIGGGHTS takes it a little
// larger than the largest semi-axis.
void check_radius(LAMMPS *lmp, int i)
{
  const double *const axes = lmp->atom->shape[i];
  const double radius = lmp->atom->radius[i];
  const double reach = std::max(axes[0], std::max(axes[1], axes[2]));
  if (radius >= (1.0 - 1e-9) * reach && radius <= 1.001 * reach) return;
  char message[300];
  snprintf(message, sizeof(message),
           "ellgran: particle %d: its bounding radius is %g and its largest semi-axis %g; change its 'shape', and neither its "
           "'diameter' nor its 'radius'",
           lmp->atom->tag[i], radius, reach);
  lmp->error->one(FLERR, message);
}
}

EllgranContact *EllgranContact::take(LAMMPS *lmp, ContactModelBase *model)
{
  EllgranContact *&entry = table()[model];
  if (!entry) {
    if (ellgran_abi_version() != ELLGRAN_ABI_VERSION) {
      char message[160];
      sprintf(message, "ellgran: built against interface version %d, linked with version %u; rebuild",
              ELLGRAN_ABI_VERSION, ellgran_abi_version());
      lmp->error->all(FLERR, message);
    }
    entry = new EllgranContact(lmp, model);
  }
  entry->users++;
  return entry;
}

void EllgranContact::release(ContactModelBase *model)
{
  Table::iterator entry = table().find(model);
  if (entry != table().end() && --entry->second->users == 0) {
    delete entry->second;
    table().erase(entry);
  }
}

EllgranContact *EllgranContact::of(const IContactHistorySetup *owner)
{
  for (Table::iterator entry = table().begin(); entry != table().end(); ++entry)
    if (entry->second->owner == owner) return entry->second;
  return NULL;
}

bool EllgranContact::any_has_friction()
{
  for (Table::iterator entry = table().begin(); entry != table().end(); ++entry)
    if (entry->second->tangential_is_tfd) return true;
  return false;
}

void EllgranContact::write_kept_histories(LAMMPS *lmp)
{
  for (Table::iterator entry = table().begin(); entry != table().end(); ++entry) {
    EllgranContact *const contact = entry->second;
    if (contact->lmp != lmp || !contact->keeps_histories_of) continue;
    const EllgranNeighbourList neighbours = contact->neighbour_list(contact->keeps_histories_of);
    contact->keeps_histories_of = NULL;
    contact->check(ellgran_write_history(contact->workspace, &neighbours));
  }
}

const EllgranWorkspace *EllgranContact::prepared_for_pairs(LAMMPS *lmp)
{
  const EllgranWorkspace *found = NULL;
  for (Table::iterator entry = table().begin(); entry != table().end(); ++entry) {
    const EllgranContact *const contact = entry->second;
    if (contact->lmp != lmp || contact->is_wall || contact->step_prepared != lmp->update->ntimestep) continue;
    if (found) return NULL;
    found = contact->workspace;
  }
  return found;
}

void EllgranContact::refuse_second_contacts(LAMMPS *lmp)
{
  for (Table::iterator entry = table().begin(); entry != table().end(); ++entry) {
    const EllgranContact *const contact = entry->second;
    const PairGran *const pair = dynamic_cast<PairGran *>(contact->owner);
    if (contact->lmp != lmp || !pair || !contact->surface_is_ellipsoid || !contact->tells_contacts_apart()) continue;
    // two images of a particle that one other particle reaches are no farther from each other than twice the cutoff
    bool possible = false;
    for (int k = 0; k < 3; k++)
      possible = possible || (lmp->domain->periodicity[k] && lmp->domain->prd[k] <= 2.0 * pair->cutforce);
    if (possible) contact->refuse_second_contacts(pair->list, pair->listgranhistory->firstneigh);
  }
}

void EllgranContact::refuse_second_contacts(const NeighList *list, int *const *touching) const
{
  const int *const tag = lmp->atom->tag;
  std::vector<int> others;
  for (int ii = 0; ii < list->inum; ii++) {
    const int i = list->ilist[ii];
    others.clear();
    for (int k = 0; k < list->numneigh[i]; k++)
      if (touching[i][k]) others.push_back(tag[list->firstneigh[i][k] & NEIGHMASK]);
    std::sort(others.begin(), others.end());
    const std::vector<int>::iterator twice = std::adjacent_find(others.begin(), others.end());
    if (twice == others.end()) continue;
    char message[300], other[60] = "itself";
    if (*twice != tag[i]) snprintf(other, sizeof(other), "particle %d in two places", *twice);
    snprintf(message, sizeof(message),
             "surface ellipsoid: particle %d touches %s, across a periodic boundary: LIGGGHTS remembers contacts by particle ID, and "
             "one would take what the other remembers: the periodic box must be longer than twice the largest grain",
             tag[i], other);
    lmp->error->one(FLERR, message);
  }
}

EllgranContact::EllgranContact(LAMMPS *lmp_, ContactModelBase *model_) :
    owner(NULL),
    staged(NULL),
    geometry(ELLGRAN_INIT(EllgranStagedGeometry)),
    laws(NULL),
    types(0),
    is_wall(model_->is_wall()),
    surface_is_ellipsoid(false),
    needs_equivalent_radius(true),
    tangential_is_tfd(false),
    displacement_is_total(false),
    friction(NULL),
    history(ELLGRAN_INIT(EllgranStagedHistory)),
    memory_offset(-1),
    lmp(lmp_),
    model(model_),
    users(0),
    youngs_modulus(NULL),
    poissons_ratio(NULL),
    list_laws(NULL),
    workspace(NULL),
    keeps_histories_of(NULL),
    warned_of_created_energy(false),
    step_prepared(-1),
    lists_before(-1)
{
  check(ellgran_staged_new(&staged));
}

EllgranContact::~EllgranContact()
{
  ellgran_staged_free(staged);
  ellgran_laws_free(laws);
  ellgran_laws_free(list_laws);
  ellgran_workspace_free(workspace);
}

void EllgranContact::check(int32_t status) const
{
  if (status == ELLGRAN_SUCCESS) return;
  char message[1200];
  snprintf(message, sizeof(message), "ellgran: %s", ellgran_last_error());
  lmp->error->one(FLERR, message);
}

EllgranBody EllgranContact::ellipsoid(int i) const
{
  const Atom *atom = lmp->atom;
  EllgranBody body = ELLGRAN_INIT(EllgranBody);
  memcpy(body.position, atom->x[i], sizeof(body.position));
  memcpy(body.quaternion, atom->quaternion[i], sizeof(body.quaternion));
  memcpy(body.semi_axes, atom->shape[i], sizeof(body.semi_axes));
  memcpy(body.velocity, atom->v[i], sizeof(body.velocity));
  memcpy(body.angular_velocity, atom->omega[i], sizeof(body.angular_velocity));
  body.mass = atom->rmass ? atom->rmass[i] : atom->mass[atom->type[i]];
  body.particle_type = atom->type[i];
  body.identifier = atom->tag[i];
  ellgran_check_blockiness(lmp, "surface ellipsoid", i);
  return body;
}

EllgranBody EllgranContact::sphere(int i, double radius) const
{
  const Atom *atom = lmp->atom;
  EllgranBody body = ELLGRAN_INIT(EllgranBody);
  memcpy(body.position, atom->x[i], sizeof(body.position));
  body.quaternion[0] = 1.0;
  body.quaternion[1] = body.quaternion[2] = body.quaternion[3] = 0.0;
  body.semi_axes[0] = body.semi_axes[1] = body.semi_axes[2] = radius;
  memcpy(body.velocity, atom->v[i], sizeof(body.velocity));
  memcpy(body.angular_velocity, atom->omega[i], sizeof(body.angular_velocity));
  body.mass = atom->rmass ? atom->rmass[i] : atom->mass[atom->type[i]];
  body.particle_type = atom->type[i];
  body.identifier = atom->tag[i];
  return body;
}

void EllgranContact::stage_spheres(const SurfacesIntersectData &sidata)
{
  const double half = share(sidata.itype, sidata.jtype);
  const EllgranBody i = sphere(sidata.i, sidata.radi);
  if (sidata.is_wall) {
    EllgranWallSurface wall = ELLGRAN_INIT(EllgranWallSurface);
    for (int k = 0; k < 3; k++) {
      wall.point[k] = i.position[k] - sidata.en[k] * (sidata.radi - sidata.deltan);
      wall.normal[k] = sidata.en[k];
      wall.direction[k] = 0.0;
      wall.velocity[k] = sidata.v_j[k];
    }
    wall.curvatures[0] = wall.curvatures[1] = 0.0;
    wall.turning_radii[0] = wall.turning_radii[1] = HUGE_VAL;
    check(ellgran_staged_wall(staged, &i, &wall, half, &geometry));
  } else {
    const EllgranBody j = sphere(sidata.j, sidata.radj);
    double none[3] = {0.0, 0.0, 0.0};
    check(ellgran_staged_pair(staged, &i, &j, half, none, &geometry));
  }
}

void EllgranContact::connect_moduli(PropertyRegistry &registry, const char *caller)
{
  if (lmp->force->nktv2p != 1.0)
    lmp->error->all(FLERR, "ellgran: this unit style has a pressure that is not force per area; use units si, cgs or lj");
  FixEllgranRestartFormat::add(lmp);
  if (PairGran *const pair = is_wall ? NULL : dynamic_cast<PairGran *>(lmp->force->pair_match("gran", 1)))
    EllgranPairHistory::replace(lmp, pair);
  registry.registerProperty("youngsModulus", &MODEL_PARAMS::createYoungsModulus);
  registry.registerProperty("poissonsRatio", &MODEL_PARAMS::createPoissonsRatio);
  registry.connect("youngsModulus", youngs_modulus, caller);
  registry.connect("poissonsRatio", poissons_ratio, caller);
  types = registry.max_type();
  shares.assign((types + 1) * (types + 1), 0.5);
  // elastic laws, whatever normal model there is
  std::vector<EllgranLawParameters> parameters(types * types, ELLGRAN_INIT(EllgranLawParameters));
  std::vector<uint8_t> is_set(types * types, 0);
  for (int k = 0; k < types; k++) {
    EllgranLawParameters &p = parameters[k * types + k];
    check(ellgran_law_parameters_default(&p));
    p.youngs_modulus = youngs_modulus[k + 1];
    p.poissons_ratio = poissons_ratio[k + 1];
    is_set[k * types + k] = 1;
  }
  EllgranLaws *elastic = NULL;
  check(ellgran_laws_new(types, &parameters[0], &is_set[0], 0, &elastic));
  EllgranMixture mixture = ELLGRAN_INIT(EllgranMixture);
  for (int i = 1; i <= types; i++)
    for (int j = 1; j <= types; j++) {
      check(ellgran_laws_mixture(elastic, i, j, &mixture));
      shares[i * (types + 1) + j] = mixture.share_i;
    }
  ellgran_laws_free(elastic);
}

bool EllgranContact::matches(const char *kind, const char *name) const
{
  if (PairGran *const pair = dynamic_cast<PairGran *>(owner)) return pair->contact_match(kind, name);
  if (FixWallGran *const wall = dynamic_cast<FixWallGran *>(owner)) return wall->contact_match(kind, name);
  return false;
}

bool EllgranContact::has_own_models_alone() const
{
  return laws && surface_is_ellipsoid && (tangential_is_tfd || matches("tangential", "off")) && matches("cohesion", "off") &&
      matches("rolling_friction", "off");
}

bool EllgranContact::tells_contacts_apart() const
{
  return !(matches("tangential", "off") || matches("tangential", "no_history")) ||
      !(matches("rolling_friction", "off") || matches("rolling_friction", "cdt")) || matches("normal", "hooke/hysteresis");
}

std::string EllgranContact::remembered() const
{
  std::string words;
  if (matches("normal", "hooke/hysteresis")) words += " largest_overlap";
  if (matches("tangential", "history")) words += " displacement";
  if (tangential_is_tfd) words += displacement_is_total ? " displacement_of_tfd" : " force_of_tfd";
  if (matches("rolling_friction", "epsd") || matches("rolling_friction", "epsd2") || matches("rolling_friction", "epsd3"))
    words += " rolling_torque";
  return words;
}

void EllgranContact::check_models() const
{
  if (matches("rolling_friction", "luding") && !matches("normal", "luding"))
    lmp->error->all(FLERR, "rolling_friction luding takes its stiffness from model luding; use cdt, epsd, epsd2 or epsd3");
  if (matches("surface", "multicontact"))
    lmp->error->all(FLERR, "model nfd is not available with surface multicontact; use surface default or ellipsoid");
  if (!surface_is_ellipsoid) {
    // Of pairs, surface default would take the sphere around each grain, and say nothing.
    if (lmp->atom->superquadric_flag)
      lmp->error->all(FLERR, "model nfd with atom_style superquadric needs surface ellipsoid: surface default is for spheres");
    return;
  }
  if (!matches("cohesion", "off"))
    lmp->error->all(FLERR, "surface ellipsoid: the cohesion models take each grain for a sphere; "
                           "only 'cohesion off' is available");
  const char *const spheres[] = {"edinburgh", "edinburgh/stiffness", "thornton_ning"};
  for (int k = 0; k < 3; k++)
    if (matches("normal", spheres[k])) {
      char message[200];
      sprintf(message, "surface ellipsoid: model %s takes each grain for a sphere; use nfd, hertz or hooke", spheres[k]);
      lmp->error->all(FLERR, message);
    }
  if (model->get_history_offset("elastic_potential_normal") >= 0)
    lmp->error->all(FLERR, "surface ellipsoid: computeElasticPotential is not available");
}

void EllgranContact::connect_local_output()
{
  PairGran *const pair = dynamic_cast<PairGran *>(owner);
  if (!pair) return;
  const int length = pair->dnum_pair();
  told_history.assign(length + 5, 0.0);
  model->add_history_offset("contact_point_offset", length, true);
  model->add_history_offset("alpha1_offset", length + 3, true);
  model->add_history_offset("alpha2_offset", length + 4, true);
}

EllgranContactReport EllgranContact::geometry_report() const
{
  EllgranContactReport report;
  memset(&report, 0, sizeof(report));
  memcpy(report.normal, geometry.normal, sizeof(report.normal));
  memcpy(report.point, geometry.contact_point, sizeof(report.point));
  report.penetration = geometry.penetration;
  check(ellgran_staged_section_area(staged, &report.area));
  return report;
}

void EllgranContact::report(SurfacesIntersectData &sidata, const ForceData &forces_i)
{
  PairGran *const pair = dynamic_cast<PairGran *>(owner);
  ComputePairGranLocal *const compute = pair ? pair->cpl() : NULL;
  if (!compute) return;
  const int length = told_history.size() - 5;
  memcpy(&told_history[0], sidata.contact_history, length * sizeof(double));
  for (int k = 0; k < 3; k++) told_history[length + k] = geometry.contact_point[k];
  told_history[length + 3] = geometry.penetration;
  told_history[length + 4] = 0.0;
  sidata.contact_history = &told_history[0];
  // the contacts that have a row
  const Atom *const atom = lmp->atom;
  const int i = sidata.i, j = sidata.j;
  if (!(atom->mask[i] & compute->groupbit) || !(atom->mask[j] & compute->groupbit)) return;
  if (lmp->force->newton_pair == 0 && j >= atom->nlocal && atom->tag[i] <= atom->tag[j]) return;
  EllgranContactReport told = geometry_report();
  memcpy(told.force, forces_i.delta_F, sizeof(told.force));
  memcpy(told.torque, forces_i.delta_torque, sizeof(told.torque));
  reports.push_back(told);
}

void EllgranContact::balance_torque_of_mesh(SurfacesIntersectData &sidata, const ForceData &forces_i)
{
  const double square = vectorDot3D(forces_i.delta_F, forces_i.delta_F);
  if (!(square > 1e-200)) return;
  const double along = vectorDot3D(sidata.delta, forces_i.delta_F) / square;
  double across[3];
  vectorCross3D(forces_i.delta_F, forces_i.delta_torque, across);
  for (int k = 0; k < 3; k++) sidata.delta[k] = along * forces_i.delta_F[k] - across[k] / square;
}

void EllgranContact::write_reports()
{
  PairGran *const pair = dynamic_cast<PairGran *>(owner);
  for (size_t row = 0; row < reports.size(); row++) ellgran_write_report(pair->cpl(), row, reports[row]);
  reports.clear();
}

void EllgranContact::check_particles() const
{
  for (int i = 0; i < lmp->atom->nlocal; i++) {
    const EllgranBody body = ellipsoid(i);
    EllgranContactGeometry unused = ELLGRAN_INIT(EllgranContactGeometry);
    EllgranPlane plane = ELLGRAN_INIT(EllgranPlane);
    plane.normal[2] = 1.0;
    check(ellgran_contact_geometry_plane(&body, &plane, &unused));
    check_radius(lmp, i);
  }
}

EllgranParticles EllgranContact::particles() const
{
  const Atom *const atom = lmp->atom;
  const int count = atom->nlocal + atom->nghost;
  EllgranParticles all = ELLGRAN_INIT(EllgranParticles);
  all.owned_count = atom->nlocal;
  all.count = count;
  if (count == 0) return all;
  for (int i = 0; i < count; i++) ellgran_check_blockiness(lmp, "surface ellipsoid", i);
  if (lmp->neighbor->ago == 0)
    for (int i = 0; i < count; i++) check_radius(lmp, i);
  all.positions = atom->x[0];
  all.velocities = atom->v[0];
  all.angular_velocities = atom->omega[0];
  all.types = atom->type;
  all.semi_axes = atom->shape[0];
  all.semi_axes_stride = 3 * sizeof(double);
  all.quaternions = atom->quaternion[0];
  all.quaternions_stride = 4 * sizeof(double);
  all.identifiers = atom->tag;
  all.identifier_bytes = sizeof(atom->tag[0]);
  all.forces = atom->f[0];
  all.torques = atom->torque[0];
  FixNVEEllipsoid::lend_velocities(lmp, all);
  return all;
}

void EllgranContact::prepare_particles()
{
  const EllgranParticles all = particles();
  check(ellgran_staged_set_time_step(staged, lmp->update->dt));
  check(ellgran_staged_prepare(staged, &all));
}

EllgranStep EllgranContact::step(int advance_history) const
{
  EllgranStep step = ELLGRAN_INIT(EllgranStep);
  step.time_step = lmp->update->dt;
  step.advance_history = advance_history;
  return step;
}

void EllgranContact::build_laws(const double *shear, const double *bulk, double *const *restitution, bool conservative,
                                bool ting, bool limit_force)
{
  std::vector<EllgranLawParameters> parameters(types * types, ELLGRAN_INIT(EllgranLawParameters));
  std::vector<uint8_t> is_set(types * types, 0);
  for (int k = 0; k < types; k++) {
    EllgranLawParameters &p = parameters[k * types + k];
    check(ellgran_law_parameters_default(&p));
    p.normal = restitution ? ELLGRAN_NORMAL_HERTZ : ELLGRAN_NORMAL_NFD;
    // The coefficient of restitution is per pair of types too, and replaces this one below.
    if (restitution) p.damping = ELLGRAN_DAMPING_RESTITUTION;
    p.tangential = tangential_is_tfd ? ELLGRAN_TANGENTIAL_TFD : ELLGRAN_TANGENTIAL_NONE;
    if (displacement_is_total) p.displacement = ELLGRAN_DISPLACEMENT_TOTAL;
    // The coefficient of friction is per pair of types and given with each contact: any value that is not zero serves.
    p.friction = 1.0;
    p.unloading = ting ? ELLGRAN_UNLOADING_TING : ELLGRAN_UNLOADING_FIRST_ORDER;
    p.conservative = conservative;
    p.limit_force = limit_force;
    p.youngs_modulus = youngs_modulus[k + 1];
    p.poissons_ratio = poissons_ratio[k + 1];
    if (!restitution) {
      p.shear_viscosity = shear[k + 1];
      p.bulk_viscosity = bulk[k + 1];
    }
    is_set[k * types + k] = 1;
  }
  EllgranLaws *built = NULL;
  // walls remember the normal beside the history
  check(ellgran_laws_new(types, &parameters[0], &is_set[0], is_wall ? ELLGRAN_OPTION_NO_WARM_START : 0, &built));
  if (restitution) {
    std::vector<double> coefficients(types * types);
    for (int i = 0; i < types; i++)
      for (int j = 0; j < types; j++) coefficients[i * types + j] = restitution[i + 1][j + 1];
    EllgranLaws *with_restitution = NULL;
    const int32_t status = ellgran_laws_with_restitution(built, &coefficients[0], &with_restitution);
    ellgran_laws_free(built);
    check(status);
    built = with_restitution;
  }
  ellgran_laws_free(laws);
  laws = built;
  ellgran_laws_free(list_laws);
  list_laws = NULL;
  warn_of_created_energy();
}

void EllgranContact::warn_of_created_energy()
{
  int32_t i = 0, j = 0;
  check(ellgran_laws_create_energy(laws, &i, &j));
  if (i == 0 || warned_of_created_energy) return;
  warned_of_created_energy = true;
  if (lmp->comm->me != 0) return;
  char message[240];
  snprintf(message, sizeof(message),
           "tangential tfd: totalDisplacement on can create energy, and nothing in the law of types %d and %d dissipates "
           "any: leave it off, or give viscosities or restitutionDamping", (int)i, (int)j);
  lmp->error->warning(FLERR, message);
}

void EllgranContact::build_list_laws()
{
  std::vector<double> coefficients(types * types, 0.0);
  if (tangential_is_tfd)
    for (int i = 0; i < types; i++)
      for (int j = 0; j < types; j++) coefficients[i * types + j] = friction[i + 1][j + 1];
  check(ellgran_laws_with_friction(laws, &coefficients[0], &list_laws));
}

const EllgranLaws *EllgranContact::laws_with_friction()
{
  if (laws && !list_laws) build_list_laws();
  return list_laws;
}

bool EllgranContact::takes_list(PairGran *pair, int vflag, int addflag) const
{
  // Virial, stored contact forces, compute pair/gran/local and the like are told of each contact by LIGGGHTS' own loop.
  if (vflag || !pair->computeflag() || (pair->cpl() && addflag)) return false;
  if (pair->storeContactForces() || pair->storeContactForcesStress() || pair->storeSumDelta()) return false;
  if (pair->store_sum_normal_force()) return false;
  if (lmp->modify->n_fixes_style("insert/stream/predefined")) return false;
  // there the mass of a body counts, not that of its particle
  const bool masses = ellgran_laws_uses_mass(laws) == 1;
  if (masses && (lmp->modify->n_fixes_style("rigid") || lmp->modify->n_fixes_style("multisphere"))) return false;
  // another fix keeps numbers of its own with each contact
  return pair->listgranhistory && pair->dnum() == ellgran_laws_history_length(laws);
}

EllgranNeighbourList EllgranContact::neighbour_list(PairGran *pair) const
{
  EllgranNeighbourList neighbours = ELLGRAN_INIT(EllgranNeighbourList);
  neighbours.count = pair->list->inum;
  neighbours.central = pair->list->ilist;
  neighbours.neighbour_counts = pair->list->numneigh;
  neighbours.neighbours = pair->list->firstneigh;
  neighbours.index_mask = NEIGHMASK;
  neighbours.touching = pair->listgranhistory->firstneigh;
  neighbours.history = pair->listgranhistory->firstdouble;
  neighbours.newton = lmp->force->newton_pair;
  return neighbours;
}

bool EllgranContact::compute_list(PairGran *pair, int eflag, int vflag, int addflag)
{
  const Atom *const atom = lmp->atom;
  // a step of LIGGGHTS' own loop changes the histories
  const int64_t lists_last = lists_before;
  lists_before = -1;
  step_prepared = -1;
  if (!takes_list(pair, vflag, addflag)) {
    write_kept_histories(lmp);
    return false;
  }
  if (eflag)
    pair->ev_setup(eflag, vflag);
  else
    pair->evflag = pair->vflag_fdotr = 0;
  if (atom->nlocal + atom->nghost == 0) return true;
  if (!workspace) check(ellgran_workspace_new(&workspace));
  // the library is told when it sees what it saw before, but for the motion
  const bool seen = list_laws && !lmp->update->setupflag && lmp->neighbor->ago > 0 && lmp->neighbor->ncalls == lists_last;
  if (!list_laws) build_list_laws();
  EllgranParticles all = particles();
  if (ellgran_laws_uses_mass(laws) == 1) {
    contact_masses.resize(all.count);
    for (int i = 0; i < all.count; i++) {
      contact_masses[i] = atom->rmass ? atom->rmass[i] : atom->mass[atom->type[i]];
      if (atom->mask[i] & pair->freeze_group_bit()) contact_masses[i] = HUGE_VAL;
    }
    all.masses = all.contact_masses = &contact_masses[0];
  }

  EllgranNeighbourList neighbours = neighbour_list(pair);
  neighbours.unchanged = seen;
  // In a run the histories are asked for before LIGGGHTS reads them. Elsewhere a new list may come unannounced.
  neighbours.keep_history =
      lmp->update->whichflag == 1 && !lmp->update->setupflag && FixContactHistoryEllgran::may_keep(lmp);
  keeps_histories_of = neighbours.keep_history ? pair : NULL;

  const EllgranStep now = step(pair->shearupdate());
  check(ellgran_compute_pairs(list_laws, workspace, &all, &neighbours, &now, NULL));
  lists_before = lmp->neighbor->ncalls;
  if (lmp->update->whichflag == 1 && !lmp->update->setupflag) step_prepared = lmp->update->ntimestep;
  return true;
}

}
}
