/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_wall_gran_ellipsoid.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "atom.h"
#include "contact_models.h"
#include "comm.h"
#include "compute_pair_gran_local.h"
#include "ellgran_contact.h"
#include "ellgran_local_output.h"
#include "error.h"
#include "fix_contact_history_mesh.h"
#include "fix_contact_property_atom_wall.h"
#include "fix_neighlist_mesh.h"
#include "fix_property_atom.h"
#include "force.h"
#include "math_extra_liggghts.h"
#include "math_extra_liggghts_nonspherical.h"
#include "modify.h"
#include "primitive_wall.h"
#include "tri_mesh.h"
#include "update.h"
#include "vector_liggghts.h"

using namespace LAMMPS_NS;
using LIGGGHTS::ContactModels::EllgranContact;
using LIGGGHTS::ContactModels::SurfacesIntersectData;

namespace {

const int POINT = 1, NORMAL = 4, HISTORY = 7;
// the most wall contacts that are remembered of one particle at a time
const int MOST_CONTACTS = 8;
// mark of a remembered contact that one of the new ones goes on from
const double TAKEN = -1.0;
// 'contact_area constant' among the modes of fix wall/gran
const int CONTACT_AREA_CONSTANT = 1;

bool is(const char *word, const char *what)
{
  return strcmp(word, what) == 0;
}

}

FixWallGranEllipsoid::FixWallGranEllipsoid(LAMMPS *lmp, int narg, char **arg) :
    FixWallGran(lmp, narg, arg),
    kind_(MESH),
    axis_(0),
    found_(NULL),
    crowded_(0),
    crowd_said_(false),
    row_(0)
{
  check(ellgran_wall_contacts_new(&found_));
  if (!impl->contact_match("surface", "ellipsoid"))
    error->fix_error(FLERR, this, "needs 'surface ellipsoid'; other surfaces have fix wall/gran");
  if (primitiveWall_) {
    // The words after 'primitive' were read and checked by fix wall/gran, which keeps them to itself.
    for (int k = 3; k + 4 < narg; k++) {
      if (!is(arg[k], "primitive")) continue;
      const char *style = arg[k + 3];
      axis_ = style[0] - 'x';
      kind_ = is(style + 1, "plane") ? PLANE : CYLINDER;
      const int count = kind_ == PLANE ? 1 : 3;
      for (int m = 0; m < count; m++) parameters_[m] = force->numeric(FLERR, arg[k + 4 + m]);
      break;
    }
  }
  if (kind_ == CYLINDER && store_force_contact_stress_)
    error->fix_error(FLERR, this,
                     "a needle touches a primitive cylinder twice, and store_force_contact_stress (which fix continuum/weighted "
                     "turns on) has room for one contact; use a mesh");
  storage_name_ = std::string("contacts_") + id;
}

FixWallGranEllipsoid::~FixWallGranEllipsoid()
{
  ellgran_wall_contacts_free(found_);
}

void FixWallGranEllipsoid::check(int32_t status) const
{
  if (status == ELLGRAN_SUCCESS) return;
  char message[1200];
  snprintf(message, sizeof(message), "ellgran: %s", ellgran_last_error());
  error->one(FLERR, message);
}

EllgranBody FixWallGranEllipsoid::body(int i) const
{
  EllgranBody body = ELLGRAN_INIT(EllgranBody);
  vectorCopy3D(atom->x[i], body.position);
  vectorCopy4D(atom->quaternion[i], body.quaternion);
  vectorCopy3D(atom->shape[i], body.semi_axes);
  body.mass = 1.0;
  body.particle_type = atom->type[i];
  body.identifier = atom->tag[i];
  return body;
}

int FixWallGranEllipsoid::slots() const
{
  return kind_ == PLANE ? 1 : kind_ == CYLINDER ? 2 : MOST_CONTACTS;
}

int FixWallGranEllipsoid::slot_length() const
{
  return HISTORY + dnum_;
}

std::string FixWallGranEllipsoid::storage_name(int piece) const
{
  char number[16];
  sprintf(number, "_%d", piece + 1);
  return storage_name_ + number;
}

void FixWallGranEllipsoid::post_create()
{
  FixWallGran::post_create();
  const int length = slots() * slot_length();
  for (int from = 0, piece = 0; from < length; from += MOST_VALUES, piece++) {
    const int count = std::min<int>(MOST_VALUES, length - from);
    const std::string name = storage_name(piece);
    std::vector<const char *> words;
    words.push_back(name.c_str());
    words.push_back("all");
    words.push_back("property/atom");
    words.push_back(name.c_str());
    words.push_back(count > 1 ? "vector" : "vector_one_entry");
    words.push_back("yes");
    words.push_back("no");
    words.push_back("no");
    for (int k = 0; k < count; k++) words.push_back("0.");
    modify->add_fix(words.size(), const_cast<char **>(&words[0]));
  }
  find_storage();
}

void FixWallGranEllipsoid::find_storage()
{
  const int length = slots() * slot_length();
  before_.assign(length, 0.0);
  now_.assign(length, 0.0);
  storage_.clear();
  for (int from = 0, piece = 0; from < length; from += MOST_VALUES, piece++)
    storage_.push_back(static_cast<FixPropertyAtom *>(
        modify->find_fix_property(storage_name(piece).c_str(), "property/atom", "vector",
                                  std::min<int>(MOST_VALUES, length - from), 0, style)));
}

void FixWallGranEllipsoid::load(int particle)
{
  const int length = before_.size();
  for (int from = 0, piece = 0; from < length; from += MOST_VALUES, piece++)
    vectorCopyN(storage_[piece]->array_atom[particle], &before_[from], std::min<int>(MOST_VALUES, length - from));
}

void FixWallGranEllipsoid::store(int particle)
{
  const int length = before_.size();
  for (int from = 0, piece = 0; from < length; from += MOST_VALUES, piece++)
    vectorCopyN(&now_[from], storage_[piece]->array_atom[particle], std::min<int>(MOST_VALUES, length - from));
}

void FixWallGranEllipsoid::pre_delete(bool unfixflag)
{
  if (unfixflag)
    for (size_t piece = 0; piece < storage_.size(); piece++) modify->delete_fix(storage_[piece]->id);
  FixWallGran::pre_delete(unfixflag);
}

void FixWallGranEllipsoid::init()
{
  FixWallGran::init();
  find_storage();
}

bool FixWallGranEllipsoid::acts_alone(const Contact &contact)
{
  return contact.surface.others_share == 0.0;
}

void FixWallGranEllipsoid::setup(int vflag)
{
  FixWallGran::setup(vflag);
  // known only now: whether the wall conducts heat
  if (heattransfer_flag_ && area_calculation_mode_ != CONTACT_AREA_CONSTANT)
    error->fix_error(FLERR, this, "takes the area that conducts heat from spheres; give it 'contact_area constant A'");
}

void FixWallGranEllipsoid::pre_neighbor()
{
  FixWallGran::pre_neighbor();
  say_crowded();
}

void FixWallGranEllipsoid::post_run()
{
  say_crowded();
}

// once, by one rank
void FixWallGranEllipsoid::say_crowded()
{
  if (crowd_said_) return;
  int particle = 0;
  MPI_Allreduce(&crowded_, &particle, 1, MPI_INT, MPI_MAX, world);
  if (particle == 0) return;
  crowd_said_ = true;
  if (comm->me != 0) return;
  char message[300];
  snprintf(message, sizeof(message),
           "Fix %s (%s): particle %d has more than %d contacts with the wall; the %d deepest act, for any particle. "
           "This is said once.",
           id, style, particle, slots(), slots());
  error->warning(FLERR, message);
}

bool FixWallGranEllipsoid::in_group(int particle) const
{
  return atom->mask[particle] & groupbit;
}

void FixWallGranEllipsoid::forget(int particle)
{
  if (!computeflag_) return;
  std::fill(now_.begin(), now_.end(), 0.0);
  store(particle);
}

// how deep the surface lies in the ellipsoid: the ellipsoid's extent along the normal less the distance of its centre
double FixWallGranEllipsoid::depth(const EllgranBody &particle, const EllgranWallSurface &surface) const
{
  double normal[3], local[3], arm[3];
  vectorCopy3D(surface.normal, normal);
  vectorNormalize3D(normal);
  MathExtraLiggghtsNonspherical::rotate_global2local(particle.quaternion, normal, local);
  double extent = 0.0;
  for (int k = 0; k < 3; k++) extent += particle.semi_axes[k] * local[k] * particle.semi_axes[k] * local[k];
  vectorSubtract3D(particle.position, surface.point, arm);
  return sqrt(extent) - vectorDot3D(arm, normal);
}

void FixWallGranEllipsoid::keep_deepest(int particle, std::vector<Contact> &contacts)
{
  // Of faces that share a contact any number act; those beyond the room for what is remembered find it with the others.
  const std::vector<Contact>::iterator shared = std::stable_partition(contacts.begin(), contacts.end(), acts_alone);
  if (shared - contacts.begin() <= slots()) return;
  crowded_ = atom->tag[particle];
  const EllgranBody grain = body(particle);
  for (size_t c = 0; c < contacts.size(); c++) contacts[c].depth = depth(grain, contacts[c].surface);
  std::stable_sort(contacts.begin(), shared, deeper);
  contacts.erase(contacts.begin() + slots(), shared);
}

// LIGGGHTS stores the force of the first contact with a primitive wall or a triangle: this is that of a further one, as a needle has
// with a cylinder. The force on the particle has it; a stored force is the sum.
void FixWallGranEllipsoid::store_again(int particle, int place, const double *force_before, const double *torque_before)
{
  double *const stored = fix_wallforce_contact_->contacthistory(particle, place);
  for (int k = 0; k < 3; k++) {
    stored[k] += atom->f[particle][k] - force_before[k];
    stored[3 + k] += atom->torque[particle][k] - torque_before[k];
  }
}

// All contacts of a particle with the wall. Each finds what is remembered of it by where it was a step ago: a contact moves
// from triangle to triangle, but it does not jump. Faces that share a contact may find the same: what is remembered belongs
// to the contact as a whole, of which each face takes its share, so that friction goes on from one face to the next.
void FixWallGranEllipsoid::act(int particle, std::vector<Contact> &contacts)
{
  const int length = slot_length();
  keep_deepest(particle, contacts);
  const int count = contacts.size();
  const double *const x = atom->x[particle];
  load(particle);
  if (now_.size() < size_t(count) * length) now_.resize(count * length);
  std::fill(now_.begin(), now_.end(), 0.0);
  const bool stores = store_force_contact_ && update->ntimestep % store_force_contact_every_ == 0;
  EllgranContact *const model = EllgranContact::of(this);
  for (int c = 0; c < count; c++) {
    const Contact &contact = contacts[c];
    double point[3];
    vectorSubtract3D(contact.surface.point, x, point);
    int best = -1;
    double least = HUGE_VAL;
    for (int s = 0; s < slots(); s++) {
      const double *const slot = &before_[s * length];
      if (slot[0] == 0.0) continue;
      if (slot[0] == TAKEN && acts_alone(contact)) continue;
      if (vectorDot3D(&slot[NORMAL], contact.surface.normal) < 0.5) continue;
      double way[3];
      vectorSubtract3D(&slot[POINT], point, way);
      const double distance = vectorMag3DSquared(way);
      if (distance < least) {
        least = distance;
        best = s;
      }
    }
    double *const slot = &now_[c * length];
    if (best >= 0) {
      vectorCopyN(&before_[best * length], slot, length);
      before_[best * length] = TAKEN;
    }
    slot[0] = 1.0;
    vectorCopy3D(point, &slot[POINT]);
    vectorCopy3D(contact.surface.normal, &slot[NORMAL]);
  }

  for (int c = 0; c < count; c++) {
    Contact &contact = contacts[c];
    SurfacesIntersectData sidata;
    sidata.is_wall = true;
    sidata.i = particle;
    sidata.itype = atom->type[particle];
    sidata.jtype = atom_type_wall_;
    sidata.contact_history = &now_[c * length + HISTORY];
    sidata.computeflag = computeflag_;
    sidata.shearupdate = shearupdate_;
    sidata.radi = atom->radius[particle];
    vectorSubtract3D(x, contact.surface.point, sidata.delta);
    vectorCopy3D(contact.surface.point, sidata.contact_point);
    FixMeshSurface *const fix_mesh = contact.mesh < n_FixMesh_ ? FixMesh_list_[contact.mesh] : NULL;
    TriMesh *const mesh = fix_mesh ? fix_mesh->triMesh() : NULL;
    sidata.fix_mesh = fix_mesh;
    sidata.mesh = mesh;
    if (fix_mesh) {
      atom_type_wall_ = fix_mesh->atomTypeWall();
      sidata.jtype = atom_type_wall_;
    }
    EllgranContact::acting_wall = &contact.surface;
    if (impl->checkSurfaceIntersect(sidata)) {
      sidata.is_non_spherical = true;
      sidata.deltan = model->geometry.penetration;
      if (fix_mesh && store_force_contact_) fix_wallforce_contact_ = fix_mesh->meshforceContact();
      if (fix_mesh && store_force_contact_stress_) fix_wallforce_contact_stress_ = fix_mesh->meshforceContactStress();
      const int triangle = mesh ? mesh->id(contact.triangle) : 0;
      const int place = stores && computeflag_ ? fix_wallforce_contact_->has_partner(particle, triangle) : -1;
      double force_before[3], torque_before[3];
      vectorCopy3D(atom->f[particle], force_before);
      vectorCopy3D(atom->torque[particle], torque_before);
      const bool tells = cwl_ && addflag_ && (atom->mask[particle] & cwl_->groupbit);
      if (counts_contacts() && mesh) {
        double *unused;
        fix_mesh->contactHistory()->handleContact(particle, mesh->id(contact.triangle), unused, true, false);
      }
      impl->compute_force(this, sidata, true, contact.surface.velocity, fix_mesh, contact.mesh, mesh, contact.triangle);
      if (place >= 0) store_again(particle, place, force_before, torque_before);
      if (tells) ellgran_write_geometry(cwl_, row_++, model->geometry_report());
    } else
      now_[c * length] = 0.0;
    EllgranContact::acting_wall = NULL;
  }
  if (computeflag_) store(particle);
}

void FixWallGranEllipsoid::post_force_primitive(int)
{
  int *neighbours;
  const int count = primitiveWall_->getNeighbors(neighbours);
  // LIGGGHTS gives the coordinates across a cylinder's axis in cyclic order
  double point[3] = {0.0, 0.0, 0.0}, axis[3] = {0.0, 0.0, 0.0};
  axis[axis_] = 1.0;
  if (kind_ == PLANE)
    point[axis_] = parameters_[0];
  else {
    point[(axis_ + 1) % 3] = parameters_[1];
    point[(axis_ + 2) % 3] = parameters_[2];
  }
  std::vector<Contact> contacts;
  for (int k = 0; k < count; k++) {
    const int i = neighbours[k];
    if (!in_group(i)) continue;
    const EllgranBody particle = body(i);
    if (kind_ == PLANE)
      check(ellgran_plane_contacts(found_, &particle, point, axis));
    else
      check(ellgran_cylinder_contacts(found_, &particle, point, axis, parameters_[0]));
    contacts.clear();
    for (size_t c = 0; c < ellgran_wall_contacts_count(found_); c++) {
      Contact contact;
      contact.surface = ELLGRAN_INIT(EllgranWallSurface);
      check(ellgran_wall_contacts_get(found_, c, NULL, &contact.surface));
      contact.mesh = contact.triangle = 0;
      if (shear_ && shearAxis_ >= 0) {
        double arm[3];
        vectorSubtract3D(contact.surface.point, point, arm);
        vectorCross3D(shearAxisVec_, arm, contact.surface.velocity);
      } else if (shear_)
        contact.surface.velocity[shearDim_] = vshear_;
      contacts.push_back(contact);
    }
    if (contacts.empty())
      forget(i);
    else
      act(i, contacts);
  }
}

// LIGGGHTS counts the contacts with a mesh in its own history of them, and compute wall/gran/local makes room for as many.
bool FixWallGranEllipsoid::counts_contacts() const
{
  return computeflag_ && cwl_;
}

// Triangles near each particle, of all meshes together: meshes that meet are one surface.
void FixWallGranEllipsoid::gather_near()
{
  const int nlocal = atom->nlocal;
  if (near_.size() < size_t(nlocal)) near_.resize(nlocal);
  for (int i = 0; i < nlocal; i++) near_[i].clear();
  for (int m = 0; m < n_FixMesh_; m++) {
    TriMesh *const mesh = FixMesh_list_[m]->triMesh();
    FixNeighlistMesh *const list = FixMesh_list_[m]->meshNeighlist();
    const int triangles = mesh->sizeLocal() + mesh->sizeGhost();
    for (int t = 0; t < triangles; t++) {
      const std::vector<int> &particles = list->get_contact_list(t);
      if (particles.empty()) continue;
      const Near triangle = {m, mesh->id(t), t};
      for (size_t k = 0; k < particles.size(); k++)
        if (particles[k] < nlocal && in_group(particles[k])) near_[particles[k]].push_back(triangle);
    }
  }
}

void FixWallGranEllipsoid::post_force_mesh(int)
{
  const int nlocal = atom->nlocal;
  row_ = 0;
  if (counts_contacts())
    for (int m = 0; m < n_FixMesh_; m++) FixMesh_list_[m]->contactHistory()->markAllContacts();
  gather_near();
  std::vector<double> corners;
  std::vector<Contact> contacts;
  for (int i = 0; i < nlocal; i++) {
    if (!in_group(i)) continue;
    contacts.clear();
    std::vector<Near> &near = near_[i];
    if (!near.empty()) {
      // in an order that does not depend on how the mesh is spread over ranks
      std::sort(near.begin(), near.end());
      corners.resize(9 * near.size());
      for (size_t k = 0; k < near.size(); k++) {
        TriMesh *const mesh = FixMesh_list_[near[k].mesh]->triMesh();
        for (int node = 0; node < 3; node++) mesh->node(near[k].place, node, &corners[9 * k + 3 * node]);
      }
      const EllgranBody particle = body(i);
      check(ellgran_triangle_contacts(found_, &particle, near.size(), &corners[0]));
      for (size_t c = 0; c < ellgran_wall_contacts_count(found_); c++) {
        EllgranWallContact found = ELLGRAN_INIT(EllgranWallContact);
        Contact contact;
        contact.surface = ELLGRAN_INIT(EllgranWallSurface);
        check(ellgran_wall_contacts_get(found_, c, &found, &contact.surface));
        contact.mesh = near[found.triangle].mesh;
        contact.triangle = near[found.triangle].place;
        MultiVectorContainer<double, 3, 3> *const velocities =
            FixMesh_list_[contact.mesh]->triMesh()->prop().getElementProperty<MultiVectorContainer<double, 3, 3> >("v");
        if (velocities) {
          double **const v = velocities->begin()[contact.triangle];
          for (int k = 0; k < 3; k++)
            contact.surface.velocity[k] =
                found.weights[0] * v[0][k] + found.weights[1] * v[1][k] + found.weights[2] * v[2][k];
        }
        contacts.push_back(contact);
      }
    }
    if (contacts.empty())
      forget(i);
    else
      act(i, contacts);
  }
  if (counts_contacts())
    for (int m = 0; m < n_FixMesh_; m++) FixMesh_list_[m]->contactHistory()->cleanUpContacts();
}
