/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "ellgran_contact.h"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>

#include "atom.h"
#include "contact_models.h"
#include "error.h"
#include "force.h"
#include "global_properties.h"
#include "modify.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "neighbor.h"
#include "pair_gran.h"
#include "property_registry.h"
#include "update.h"

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
}

const EllgranWallSurface *EllgranContact::acting_wall = NULL;

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
    entry = new EllgranContact(lmp, model->is_wall());
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

EllgranContact::EllgranContact(LAMMPS *lmp_, bool is_wall_) :
    owner(NULL),
    staged(NULL),
    geometry(ELLGRAN_INIT(EllgranStagedGeometry)),
    laws(NULL),
    types(0),
    is_wall(is_wall_),
    surface_is_ellipsoid(false),
    needs_equivalent_radius(true),
    tangential_is_tfd(false),
    friction(NULL),
    past(ELLGRAN_INIT(EllgranStagedPast)),
    memory_offset(-1),
    lmp(lmp_),
    users(0),
    youngs_modulus(NULL),
    poissons_ratio(NULL),
    list_laws(NULL),
    workspace(NULL),
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
  body.kind = atom->type[i];
  body.identifier = atom->tag[i];
  check_blockiness(i);
  return body;
}

void EllgranContact::check_blockiness(int i) const
{
  const double *blockiness = lmp->atom->blockiness[i];
  if (blockiness[0] == 2.0 && blockiness[1] == 2.0) return;
  char message[200];
  snprintf(message, sizeof(message),
           "ellgran: particle %d: blockiness %g %g: surface ellipsoid needs blockiness 2 2, an ellipsoid",
           lmp->atom->tag[i], blockiness[0], blockiness[1]);
  lmp->error->one(FLERR, message);
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
  body.kind = atom->type[i];
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
  registry.registerProperty("youngsModulus", &MODEL_PARAMS::createYoungsModulus);
  registry.registerProperty("poissonsRatio", &MODEL_PARAMS::createPoissonsRatio);
  registry.connect("youngsModulus", youngs_modulus, caller);
  registry.connect("poissonsRatio", poissons_ratio, caller);
  types = registry.max_type();
  shares.assign((types + 1) * (types + 1), 0.5);
  std::vector<double> compliance(types + 1);
  for (int k = 1; k <= types; k++)
    compliance[k] = (1.0 - poissons_ratio[k] * poissons_ratio[k]) / youngs_modulus[k];
  for (int i = 1; i <= types; i++)
    for (int j = 1; j <= types; j++) shares[i * (types + 1) + j] = compliance[i] / (compliance[i] + compliance[j]);
}

void EllgranContact::check_particles() const
{
  for (int i = 0; i < lmp->atom->nlocal; i++) {
    const EllgranBody body = ellipsoid(i);
    EllgranContactGeometry unused = ELLGRAN_INIT(EllgranContactGeometry);
    EllgranPlane plane = ELLGRAN_INIT(EllgranPlane);
    plane.normal[2] = 1.0;
    check(ellgran_contact_geometry_plane(&body, &plane, &unused));
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
  for (int i = 0; i < count; i++) check_blockiness(i);
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
  return all;
}

void EllgranContact::prepare_particles()
{
  const EllgranParticles all = particles();
  check(ellgran_staged_prepare(staged, &all));
}

EllgranStep EllgranContact::step(int advance_history) const
{
  EllgranStep step = ELLGRAN_INIT(EllgranStep);
  step.time_step = lmp->update->dt;
  step.advance_history = advance_history;
  return step;
}

void EllgranContact::build_laws(const double *shear, const double *bulk, bool conservative, bool ting, bool limit_force)
{
  std::vector<EllgranLawParameters> parameters(types * types, ELLGRAN_INIT(EllgranLawParameters));
  std::vector<uint8_t> is_set(types * types, 0);
  for (int k = 0; k < types; k++) {
    EllgranLawParameters &p = parameters[k * types + k];
    check(ellgran_law_parameters_default(&p));
    p.normal = ELLGRAN_NORMAL_NFD;
    p.tangential = tangential_is_tfd ? ELLGRAN_TANGENTIAL_TFD : ELLGRAN_TANGENTIAL_NONE;
    // The coefficient of friction is per pair of types and given with each contact: any value that is not zero serves.
    p.friction = 1.0;
    p.unloading = ting ? ELLGRAN_UNLOADING_TING : ELLGRAN_UNLOADING_FIRST_ORDER;
    p.conservative = conservative;
    p.limit_force = limit_force;
    p.youngs_modulus = youngs_modulus[k + 1];
    p.poissons_ratio = poissons_ratio[k + 1];
    p.shear_viscosity = shear[k + 1];
    p.bulk_viscosity = bulk[k + 1];
    is_set[k * types + k] = 1;
  }
  EllgranLaws *built = NULL;
  check(ellgran_laws_new(types, &parameters[0], &is_set[0], 0, &built));
  ellgran_laws_free(laws);
  laws = built;
  ellgran_laws_free(list_laws);
  list_laws = NULL;
}

void EllgranContact::build_list_laws()
{
  std::vector<double> coefficients(types * types, 0.0);
  if (tangential_is_tfd)
    for (int i = 0; i < types; i++)
      for (int j = 0; j < types; j++) coefficients[i * types + j] = friction[i + 1][j + 1];
  check(ellgran_laws_with_friction(laws, &coefficients[0], &list_laws));
}

bool EllgranContact::compute_list(PairGran *pair, int eflag, int vflag, int addflag)
{
  const Atom *const atom = lmp->atom;
  NeighList *const list = pair->list;
  // a step of LIGGGHTS' own loop changes the histories
  const int64_t lists_last = lists_before;
  lists_before = -1;
  // Virial, stored contact forces, compute pair/gran/local and the like are told of each contact by LIGGGHTS' own loop.
  if (vflag || !pair->computeflag() || (pair->cpl() && addflag)) return false;
  if (pair->storeContactForces() || pair->storeContactForcesStress() || pair->storeSumDelta()) return false;
  if (pair->store_sum_normal_force()) return false;
  if (lmp->modify->n_fixes_style("insert/stream/predefined")) return false;
  // another fix keeps numbers of its own with each contact
  if (!pair->listgranhistory || pair->dnum() != ellgran_laws_history_length(laws)) return false;

  if (eflag)
    pair->ev_setup(eflag, vflag);
  else
    pair->evflag = pair->vflag_fdotr = 0;
  if (atom->nlocal + atom->nghost == 0) return true;
  if (!workspace) check(ellgran_workspace_new(&workspace));
  // the library is told when it sees what it saw before, but for the motion
  const bool seen = list_laws && !lmp->update->setupflag && lmp->neighbor->ago > 0 && lmp->neighbor->ncalls == lists_last;
  if (!list_laws) build_list_laws();
  const EllgranParticles all = particles();

  EllgranNeighbourList neighbours = ELLGRAN_INIT(EllgranNeighbourList);
  neighbours.count = list->inum;
  neighbours.central = list->ilist;
  neighbours.neighbour_counts = list->numneigh;
  neighbours.neighbours = list->firstneigh;
  neighbours.index_mask = NEIGHMASK;
  neighbours.touching = pair->listgranhistory->firstneigh;
  neighbours.history = pair->listgranhistory->firstdouble;
  neighbours.newton = lmp->force->newton_pair;
  neighbours.unchanged = seen;

  const EllgranStep now = step(pair->shearupdate());
  check(ellgran_compute_pairs(list_laws, workspace, &all, &neighbours, &now, NULL));
  lists_before = lmp->neighbor->ncalls;
  return true;
}

}
}
