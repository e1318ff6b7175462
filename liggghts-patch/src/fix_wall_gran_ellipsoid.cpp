/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_wall_gran_ellipsoid.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "atom.h"
#include "contact_models.h"
#include "ellgran_contact.h"
#include "error.h"
#include "fix_contact_history_mesh.h"
#include "fix_neighlist_mesh.h"
#include "fix_property_atom.h"
#include "force.h"
#include "math_extra_liggghts.h"
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

bool is(const char *word, const char *what)
{
  return strcmp(word, what) == 0;
}

}

FixWallGranEllipsoid::FixWallGranEllipsoid(LAMMPS *lmp, int narg, char **arg) :
    FixWallGran(lmp, narg, arg),
    kind_(MESH),
    axis_(0),
    storage_(NULL),
    found_(NULL),
    own_wall_(0)
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
  body.kind = atom->type[i];
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

void FixWallGranEllipsoid::post_create()
{
  FixWallGran::post_create();
  const int length = slots() * slot_length();
  std::vector<const char *> words;
  words.push_back(storage_name_.c_str());
  words.push_back("all");
  words.push_back("property/atom");
  words.push_back(storage_name_.c_str());
  words.push_back("vector");
  words.push_back("yes");
  words.push_back("no");
  words.push_back("no");
  for (int k = 0; k < length; k++) words.push_back("0.");
  modify->add_fix(words.size(), const_cast<char **>(&words[0]));
  storage_ = static_cast<FixPropertyAtom *>(
      modify->find_fix_property(storage_name_.c_str(), "property/atom", "vector", length, 0, style));
}

void FixWallGranEllipsoid::pre_delete(bool unfixflag)
{
  if (unfixflag && storage_) modify->delete_fix(storage_->id);
  FixWallGran::pre_delete(unfixflag);
}

void FixWallGranEllipsoid::init()
{
  FixWallGran::init();
  storage_ = static_cast<FixPropertyAtom *>(modify->find_fix_property(
      storage_name_.c_str(), "property/atom", "vector", slots() * slot_length(), 0, style));
  find_walls();
}

void FixWallGranEllipsoid::find_walls()
{
  walls_.clear();
  for (int f = 0; f < modify->nfix; f++) {
    if (!is(modify->fix[f]->style, style)) continue;
    FixWallGranEllipsoid *const wall = static_cast<FixWallGranEllipsoid *>(modify->fix[f]);
    if (wall->kind_ != MESH) continue;
    if (wall == this) own_wall_ = walls_.size();
    walls_.push_back(wall);
  }
}

bool FixWallGranEllipsoid::acts_alone(const Contact &contact)
{
  return contact.surface.others_share == 0.0;
}

bool FixWallGranEllipsoid::in_group(int particle) const
{
  return atom->mask[particle] & groupbit;
}

void FixWallGranEllipsoid::forget(int particle)
{
  if (computeflag_) vectorZeroizeN(storage_->array_atom[particle], slots() * slot_length());
}

// All contacts of a particle with the wall. Each finds what is remembered of it by where it was a step ago: a contact moves
// from triangle to triangle, but it does not jump. Faces that share a contact may find the same: what is remembered belongs
// to the contact as a whole, of which each face takes its share, so that friction goes on from one face to the next.
void FixWallGranEllipsoid::act(int particle, std::vector<Contact> &contacts)
{
  const int length = slot_length();
  const int count = contacts.size();
  // Of faces that share a contact any number act; those beyond the room for what is remembered find it with the others.
  const int whole = std::stable_partition(contacts.begin(), contacts.end(), acts_alone) - contacts.begin();
  if (whole > slots()) {
    char message[200];
    snprintf(message, sizeof(message), "particle %d has %d contacts with the wall; %d is the most that are remembered",
             atom->tag[particle], whole, slots());
    error->fix_error(FLERR, this, message);
  }
  double *const stored = storage_->array_atom[particle];
  const double *const x = atom->x[particle];
  std::vector<double> before(stored, stored + slots() * length);
  std::vector<double> now(std::max(count, slots()) * length, 0.0);
  for (int c = 0; c < count; c++) {
    const Contact &contact = contacts[c];
    double point[3];
    vectorSubtract3D(contact.surface.point, x, point);
    int best = -1;
    double least = HUGE_VAL;
    for (int s = 0; s < slots(); s++) {
      const double *const slot = &before[s * length];
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
    double *const slot = &now[c * length];
    if (best >= 0) {
      vectorCopyN(&before[best * length], slot, length);
      before[best * length] = TAKEN;
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
    sidata.contact_history = &now[c * length + HISTORY];
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
      if (counts_contacts() && mesh) {
        double *unused;
        fix_mesh->contactHistory()->handleContact(particle, mesh->id(contact.triangle), unused, true, false);
      }
      impl->compute_force(this, sidata, true, contact.surface.velocity, fix_mesh, contact.mesh, mesh, contact.triangle);
    } else
      now[c * length] = 0.0;
    EllgranContact::acting_wall = NULL;
  }
  if (computeflag_) vectorCopyN(&now[0], stored, slots() * length);
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

// Triangles near each particle, of all meshes of all walls together: meshes that meet are one surface, whose contacts each wall
// finds alike and of which it acts by those on its own triangles.
void FixWallGranEllipsoid::gather_near()
{
  const int nlocal = atom->nlocal;
  if (near_.size() < size_t(nlocal)) near_.resize(nlocal);
  for (int i = 0; i < nlocal; i++) near_[i].clear();
  for (size_t w = 0; w < walls_.size(); w++) {
    FixWallGranEllipsoid *const wall = walls_[w];
    for (int m = 0; m < wall->n_FixMesh_; m++) {
      TriMesh *const mesh = wall->FixMesh_list_[m]->triMesh();
      FixNeighlistMesh *const list = wall->FixMesh_list_[m]->meshNeighlist();
      const int triangles = mesh->sizeLocal() + mesh->sizeGhost();
      for (int t = 0; t < triangles; t++) {
        const std::vector<int> &particles = list->get_contact_list(t);
        if (particles.empty()) continue;
        const Near triangle = {int(w), m, mesh->id(t), t};
        for (size_t k = 0; k < particles.size(); k++)
          if (particles[k] < nlocal && wall->in_group(particles[k])) near_[particles[k]].push_back(triangle);
      }
    }
  }
}

void FixWallGranEllipsoid::post_force_mesh(int)
{
  const int nlocal = atom->nlocal;
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
        TriMesh *const mesh = walls_[near[k].wall]->FixMesh_list_[near[k].mesh]->triMesh();
        for (int node = 0; node < 3; node++) mesh->node(near[k].place, node, &corners[9 * k + 3 * node]);
      }
      const EllgranBody particle = body(i);
      check(ellgran_triangle_contacts(found_, &particle, near.size(), &corners[0]));
      for (size_t c = 0; c < ellgran_wall_contacts_count(found_); c++) {
        EllgranWallContact found = ELLGRAN_INIT(EllgranWallContact);
        Contact contact;
        contact.surface = ELLGRAN_INIT(EllgranWallSurface);
        check(ellgran_wall_contacts_get(found_, c, &found, &contact.surface));
        if (near[found.triangle].wall != own_wall_) continue;
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
