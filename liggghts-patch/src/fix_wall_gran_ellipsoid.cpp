/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_wall_gran_ellipsoid.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "atom.h"
#include "comm.h"
#include "compute_pair_gran_local.h"
#include "contact_models.h"
#include "domain.h"
#include "ellgran_contact.h"
#include "ellgran_local_output.h"
#include "error.h"
#include "fix_contact_history_mesh.h"
#include "fix_contact_property_atom_wall.h"
#include "fix_neighlist_mesh.h"
#include "fix_property_atom.h"
#include "force.h"
#include "memory.h"
#include "modify.h"
#include "primitive_wall.h"
#include "tri_mesh.h"
#include "update.h"
#include "vector_liggghts.h"

using namespace LAMMPS_NS;
using LIGGGHTS::ContactModels::EllgranContact;
using LIGGGHTS::ContactModels::SurfacesIntersectData;

namespace {

// 'contact_area constant' among the modes of fix wall/gran
const int CONTACT_AREA_CONSTANT = 1;

// values with which histories of walls began in restart files of format version 1: a normal and a flag
const int OLDER_BEGINNING = 4;

bool is(const char *word, const char *what)
{
  return strcmp(word, what) == 0;
}

// Where 'primitive type T shape' stands among the words of a fix; 0 for nowhere.
int shape_begins(int narg, char **arg)
{
  for (int k = 3; k + 3 < narg; k++)
    if (is(arg[k], "primitive") && is(arg[k + 3], "shape")) return k + 3;
  return 0;
}

// Adds the shapes that begin at a word to a wall, and those of its parts that are planes to a list; where the next words begin.
int read_shapes(LAMMPS *lmp, EllgranWall *wall, int from, int narg, char **arg, std::vector<size_t> &planes)
{
  while (from < narg && is(arg[from], "shape")) {
    size_t read = 0;
    if (from + 1 < narg && is(arg[from + 1], "plane")) planes.push_back(ellgran_wall_part_count(wall));
    if (ellgran_wall_add_shape_words(wall, narg - from - 1, arg + from + 1, &read) != ELLGRAN_SUCCESS) {
      char message[1400];
      snprintf(message, sizeof(message), "Fix %s (%s): %s", arg[0], arg[2], ellgran_last_error());
      lmp->error->all(FLERR, message);
    }
    from += 1 + read;
  }
  return from;
}

// How many walls the words of a fix name: of two, fix wall/gran reads the last, or parts of both.
int walls_among(int narg, char **arg, int mesh_count)
{
  int walls = 0;
  for (int k = 3; k < narg; k++) {
    if (is(arg[k], "primitive") || is(arg[k], "mesh")) walls++;
    // after it stand IDs, which may be any words
    if (is(arg[k], "meshes")) k += mesh_count;
  }
  return walls;
}

// The words as fix wall/gran reads them. It knows no shapes: a cylinder of radius 0, which counts every particle as near, stands for them.
std::vector<char *> words_of_wall_gran(LAMMPS *lmp, int narg, char **arg)
{
  std::vector<char *> words(arg, arg + narg);
  const int from = shape_begins(narg, arg);
  if (from == 0) return words;
  EllgranWall *wall = NULL;
  if (ellgran_wall_new(&wall) != ELLGRAN_SUCCESS) lmp->error->one(FLERR, ellgran_last_error());
  std::vector<size_t> planes;
  const int end = read_shapes(lmp, wall, from, narg, arg, planes);
  ellgran_wall_free(wall);
  static char cylinder[] = "zcylinder", zero[] = "0.0";
  char *const instead[] = {cylinder, zero, zero, zero};
  words.erase(words.begin() + from, words.begin() + end);
  words.insert(words.begin() + from, instead, instead + 4);
  return words;
}

}

FixWallGranEllipsoid::FixWallGranEllipsoid(LAMMPS *lmp, int narg, char **arg) :
    FixWallGran(lmp, words_of_wall_gran(lmp, narg, arg).size(), &words_of_wall_gran(lmp, narg, arg)[0]),
    wall_(NULL),
    workspace_(NULL),
    step_of_one_call_(-1),
    lists_of_one_call_(-1),
    histories_length_(0),
    histories_(NULL),
    histories_are_of_other_models_(false),
    crowded_(0),
    crowd_said_(false),
    row_(0)
{
  across_[0] = across_[1] = across_[2] = NULL;
  check(ellgran_wall_new(&wall_));
  check(ellgran_workspace_new(&workspace_));
  if (!impl->contact_match("surface", "ellipsoid"))
    error->fix_error(FLERR, this, "needs 'surface ellipsoid'; other surfaces have fix wall/gran");
  if (walls_among(narg, arg, n_FixMesh_) > 1)
    error->fix_error(FLERR, this,
                     "takes one 'primitive' or one 'mesh', and more are given: use a fix for each, or several 'shape' after one "
                     "'primitive type N', or 'n_meshes'");
  refuse_meshes_named_twice();
  if (primitiveWall_)
    add_primitive(narg, arg);
  else {
    const EllgranLentTriangles none = ELLGRAN_INIT(EllgranLentTriangles);
    check(ellgran_wall_lend_triangles(wall_, &none));
  }
  histories_length_ = ellgran_wall_found_histories_length(wall_, dnum_);
  restart_global = 1;
  restart_peratom = 1;
  create_attribute = 1;
  grow_arrays(atom->nmax);
  atom->add_callback(0);
  atom->add_callback(1);
  for (int i = 0; i < atom->nlocal; i++) set_arrays(i);
}

FixWallGranEllipsoid::~FixWallGranEllipsoid()
{
  atom->delete_callback(id, 0);
  atom->delete_callback(id, 1);
  memory->destroy(histories_);
  ellgran_wall_free(wall_);
  ellgran_workspace_free(workspace_);
}

void FixWallGranEllipsoid::check(int32_t status) const
{
  if (status == ELLGRAN_SUCCESS) return;
  char message[1200];
  snprintf(message, sizeof(message), "ellgran: %s", ellgran_last_error());
  error->one(FLERR, message);
}

// Under LIGGGHTS' own models such a mesh acts twice. Here triangles that lie on one another are one.
void FixWallGranEllipsoid::refuse_meshes_named_twice() const
{
  for (int m = 0; m < n_FixMesh_; m++) {
    if (std::find(FixMesh_list_, FixMesh_list_ + m, FixMesh_list_[m]) == FixMesh_list_ + m) continue;
    const std::string message = std::string("mesh '") + FixMesh_list_[m]->id + "' is named twice among 'meshes'";
    error->fix_error(FLERR, const_cast<FixWallGranEllipsoid *>(this), message.c_str());
  }
}

// The words after 'primitive' were read and checked by fix wall/gran, which keeps them to itself.
void FixWallGranEllipsoid::add_primitive(int narg, char **arg)
{
  bool is_plane = false;
  if (const int from = shape_begins(narg, arg)) {
    if (shear_) error->fix_error(FLERR, this, "'shear' goes with planes and cylinders along the axes; use a mesh with fix move/mesh");
    std::vector<size_t> planes;
    read_shapes(lmp, wall_, from, narg, arg, planes);
    for (size_t p = 0; p < planes.size(); p++) {
      double normal[3];
      check(ellgran_wall_part_plane(wall_, planes[p], normal, NULL));
      for (int k = 0; k < 3; k++)
        if (normal[k] != 0.0) across_[k] = "shape plane";
    }
    is_plane = is(arg[from + 1], "plane") && ellgran_wall_part_count(wall_) == 1;
  } else
    for (int k = 3; k + 4 < narg; k++) {
      if (!is(arg[k], "primitive")) continue;
      is_plane = is(arg[k + 3] + 1, "plane");
      double parameters[3] = {0.0, 0.0, 0.0};
      for (int m = 0; m < (is_plane ? 1 : 3); m++) parameters[m] = force->numeric(FLERR, arg[k + 4 + m]);
      add_shape(arg[k + 3], parameters);
      break;
    }
  if (!is_plane && store_force_contact_stress_)
    error->fix_error(FLERR, this,
                     "a needle touches a primitive cylinder twice, and store_force_contact_stress (which fix continuum/weighted "
                     "turns on) has room for one contact; use a mesh");
  check_periodicity();
}

// A wall has no images: it must not depend on a coordinate that repeats.
void FixWallGranEllipsoid::check_periodicity() const
{
  for (int k = 0; k < 3; k++) {
    if (!across_[k] || !domain->periodicity[k]) continue;
    char message[300];
    snprintf(message, sizeof(message),
             "%s is across a periodic dimension, %c, and a primitive wall has no periodic images: use 'boundary' with f, s or m in that "
             "dimension, or a mesh, which has them",
             across_[k], "xyz"[k]);
    error->fix_error(FLERR, const_cast<FixWallGranEllipsoid *>(this), message);
  }
}

void FixWallGranEllipsoid::add_shape(const char *style, const double *parameters)
{
  const int axis = style[0] - 'x';
  const bool is_plane = is(style + 1, "plane");
  if (is_plane && shear_ && shearDim_ == axis)
    error->fix_error(FLERR, this, "a plane cannot shear along its own normal; use a mesh with fix move/mesh");
  EllgranWallShape shape = ELLGRAN_INIT(EllgranWallShape);
  shape.name = is_plane ? "plane" : "cylinder";
  shape.side = ELLGRAN_SIDE_OF_CENTRE;
  shape.axis[axis] = 1.0;
  if (is_plane)
    shape.point[axis] = parameters[0];
  else {
    // LIGGGHTS gives the coordinates across a cylinder's axis in cyclic order
    shape.radii[0] = parameters[0];
    shape.point[(axis + 1) % 3] = parameters[1];
    shape.point[(axis + 2) % 3] = parameters[2];
  }
  static const char *const NAMES[2][3] = {{"xplane", "yplane", "zplane"}, {"xcylinder", "ycylinder", "zcylinder"}};
  for (int k = 0; k < 3; k++)
    if (is_plane == (k == axis)) across_[k] = NAMES[is_plane ? 0 : 1][axis];
  vectorCopy3D(shape.point, point_);
  check(ellgran_wall_add_shape(wall_, &shape));
}

double FixWallGranEllipsoid::memory_usage()
{
  return static_cast<double>(atom->nmax) * histories_length_ * sizeof(double);
}

void FixWallGranEllipsoid::grow_arrays(int count)
{
  if (histories_length_ > 0) memory->grow(histories_, count, histories_length_, "wall/gran/ellipsoid:histories");
}

void FixWallGranEllipsoid::copy_arrays(int from, int to, int)
{
  if (histories_length_ > 0) vectorCopyN(histories_[from], histories_[to], histories_length_);
}

void FixWallGranEllipsoid::set_arrays(int particle)
{
  if (histories_length_ > 0) vectorZeroizeN(histories_[particle], histories_length_);
}

int FixWallGranEllipsoid::pack_exchange(int particle, double *buffer)
{
  if (histories_length_ > 0) vectorCopyN(histories_[particle], buffer, histories_length_);
  return histories_length_;
}

int FixWallGranEllipsoid::unpack_exchange(int particle, double *buffer)
{
  if (histories_length_ > 0) vectorCopyN(buffer, histories_[particle], histories_length_);
  return histories_length_;
}

int FixWallGranEllipsoid::size_restart(int)
{
  return 1 + histories_length_;
}

int FixWallGranEllipsoid::maxsize_restart()
{
  return 1 + histories_length_;
}

int FixWallGranEllipsoid::pack_restart(int particle, double *buffer)
{
  buffer[0] = 1 + histories_length_;
  return 1 + pack_exchange(particle, buffer + 1);
}

void FixWallGranEllipsoid::write_restart(FILE *fp)
{
  if (comm->me != 0) return;
  const std::string words = EllgranContact::of(this)->remembered();
  const int size = words.size() + 1;
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(words.c_str(), 1, size, fp);
}

// LIGGGHTS calls it before the histories are read. Files of versions 1 and 2 do not have these words.
void FixWallGranEllipsoid::restart(char *state)
{
  histories_are_of_other_models_ = histories_length_ > 0 && EllgranContact::of(this)->remembered() != state;
  if (!histories_are_of_other_models_ || *state == '\0' || comm->me != 0) return;
  char message[300];
  snprintf(message, sizeof(message),
           "Fix %s (%s): the restart file is of models under which contacts remember something else: contacts that exist start with no "
           "tangential displacement",
           id, style);
  error->warning(FLERR, message);
}

void FixWallGranEllipsoid::unpack_restart(int particle, int place)
{
  if (histories_are_of_other_models_) {
    FixWallGranEllipsoid::set_arrays(particle);
    return;
  }
  double *extra = atom->extra[particle];
  for (int k = 0; k < place; k++) extra += static_cast<int>(*extra);
  if (static_cast<int>(extra[0]) != 1 + histories_length_) {
    // one, not fix_error, which waits for all ranks: those without grains do not come here
    char message[300];
    snprintf(message, sizeof(message),
             "fix %s (%s): the restart file keeps other values per contact: give the fix the models and the wall that it had, or "
             "another ID",
             id, style);
    error->one(FLERR, message);
  }
  unpack_exchange(particle, extra + 1);
}

void FixWallGranEllipsoid::post_create()
{
  // Histories are in our own arrays. LIGGGHTS keeps room for them too: none is needed for a primitive wall, and with a mesh, where it
  // counts contacts, it must have the size of format version 1, or LIGGGHTS refuses older restart files.
  const int history_length = dnum_;
  dnum_ = primitiveWall_ ? 0 : OLDER_BEGINNING + history_length;
  FixWallGran::post_create();
  dnum_ = history_length;
  if (histories_length_ > 0 && modify->nfix_restart_peratom > 0) read_older_histories();
}

// Restart files of format version 1 (see fix_ellgran_restart_format.h) hold the histories of a wall in fixes property/atom, which are
// made here for LIGGGHTS to fill them, and deleted.
void FixWallGranEllipsoid::read_older_histories()
{
  // Of one record of a contact: head, then the history.
  const int head = 7;
  const int record = head + dnum_, older_record = head + OLDER_BEGINNING + dnum_;
  const int records = (histories_length_ - 1) / record;
  const int older_length = records * older_record;
  const int most_values = 20;  // of one such fix
  std::vector<double> older(static_cast<size_t>(atom->nlocal) * older_length, 0.0);
  bool found = false;
  for (int from = 0, piece = 1; from < older_length; from += most_values, piece++) {
    const int count = std::min(most_values, older_length - from);
    char number[16];
    sprintf(number, "_%d", piece);
    const std::string name = std::string("contacts_") + id + number;
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
    const FixPropertyAtom *const values = static_cast<FixPropertyAtom *>(
        modify->find_fix_property(name.c_str(), "property/atom", "vector", count, 0, style));
    if (values->recent_restart) {
      found = true;
      for (int i = 0; i < atom->nlocal; i++)
        vectorCopyN(values->array_atom[i], &older[static_cast<size_t>(i) * older_length + from], count);
    }
    modify->delete_fix(name.c_str());
  }
  if (!found) return;
  recent_restart = 1;  // or LIGGGHTS clears the memory when the run begins
  for (int i = 0; i < atom->nlocal; i++) {
    int kept = 0;
    for (int k = 0; k < records; k++) {
      const double *const from = &older[static_cast<size_t>(i) * older_length + k * older_record];
      if (from[0] == 0.0) continue;
      double *const to = &histories_[i][1 + kept * record];
      to[0] = 1.0;  // the wall's only part
      vectorCopy3D(&from[1], &to[1]);
      for (int c = 0; c < 3; c++) to[4 + c] = -from[4 + c];
      vectorCopyN(&from[head + OLDER_BEGINNING], &to[head], dnum_);
      kept++;
    }
    histories_[i][0] = kept;
  }
}

void FixWallGranEllipsoid::init()
{
  FixWallGran::init();
  check_periodicity();
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
  // commands between runs may change particles without a neighbour list built anew
  step_of_one_call_ = -1;
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
           "Fix %s (%s): particle %d touches the wall in more places than are remembered; all act, but at some of "
           "them friction begins anew in each step, for any particle. This is said once.",
           id, style, particle);
  error->warning(FLERR, message);
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

// One contact. LIGGGHTS' own contact model computes its force and tells its outputs of it.
void FixWallGranEllipsoid::act(EllgranContact &model, size_t index)
{
  EllgranFoundWallContact contact = ELLGRAN_INIT(EllgranFoundWallContact);
  check(ellgran_wall_found(wall_, index, &contact));
  const int i = contact.particle;
  if (contact.is_forgotten) crowded_ = atom->tag[i];
  FixMeshSurface *fix_mesh = NULL;
  TriMesh *mesh = NULL;
  int number = 0, triangle = 0, mesh_index = 0;
  if (is_mesh_wall()) {
    triangle = near_[contact.triangle].place;
    mesh_index = near_[contact.triangle].mesh;
    fix_mesh = FixMesh_list_[mesh_index];
    mesh = fix_mesh->triMesh();
    number = mesh->id(triangle);
    atom_type_wall_ = fix_mesh->atomTypeWall();
    if (store_force_contact_) fix_wallforce_contact_ = fix_mesh->meshforceContact();
    if (store_force_contact_stress_) fix_wallforce_contact_stress_ = fix_mesh->meshforceContactStress();
    if (counts_contacts()) {
      double *unused;
      fix_mesh->contactHistory()->handleContact(i, number, unused, true, false);
    }
  }
  const int type = atom->type[i];
  check(ellgran_staged_found(model.staged, wall_, index, model.share(type, atom_type_wall_), &model.geometry));
  model.history.touched = contact.touched;
  vectorCopy3D(contact.last_normal, model.history.normal);

  SurfacesIntersectData sidata;
  sidata.is_wall = true;
  sidata.is_non_spherical = true;
  sidata.i = i;
  sidata.itype = type;
  sidata.jtype = atom_type_wall_;
  sidata.contact_history = contact.history;
  sidata.computeflag = computeflag_;
  sidata.shearupdate = shearupdate_;
  sidata.radi = atom->radius[i];
  sidata.deltan = model.geometry.penetration;
  vectorSubtract3D(atom->x[i], contact.point, sidata.delta);
  vectorCopy3D(contact.point, sidata.contact_point);
  sidata.fix_mesh = fix_mesh;
  sidata.mesh = mesh;

  const bool stores = store_force_contact_ && computeflag_ && update->ntimestep % store_force_contact_every_ == 0;
  const int place = stores ? fix_wallforce_contact_->has_partner(i, number) : -1;
  double force_before[3], torque_before[3];
  vectorCopy3D(atom->f[i], force_before);
  vectorCopy3D(atom->torque[i], torque_before);
  const bool tells = cwl_ && addflag_ && (atom->mask[i] & cwl_->groupbit);
  double branch[3];
  vectorCopy3D(sidata.delta, branch);
  const bool first_of_stresses = store_force_contact_stress_ && fix_wallforce_contact_stress_->has_partner(i, number) < 0;
  impl->compute_force(this, sidata, true, contact.velocity, fix_mesh, mesh_index, mesh, triangle);
  // the contact model moves it along a mesh for the torque on that, and stresses are of the contact point
  if (first_of_stresses) {
    const int stored = fix_wallforce_contact_stress_->has_partner(i, number);
    if (stored >= 0) vectorCopy3D(branch, fix_wallforce_contact_stress_->contacthistory(i, stored) + 3);
  }
  if (place >= 0) store_again(i, place, force_before, torque_before);
  if (tells) ellgran_write_geometry(cwl_, row_++, model.geometry_report());
}

// Whether nothing asks for the contacts one by one: outputs of single contacts, stored forces, stresses of meshes, heat, or a model that is not
// the library's. Meshes of several materials have laws of their own, too.
bool FixWallGranEllipsoid::takes_one_call(const EllgranContact &model, const EllgranLaws *laws) const
{
  if (!computeflag_ || cwl_ || heattransfer_flag_ || track_energy_ || store_sum_normal_force()) return false;
  if (store_force_ || store_force_contact_ || store_force_contact_stress_ || stress_flag_) return false;
  if (!laws || !model.has_own_models_alone()) return false;
  // there the mass of a body counts, not that of its particle
  if (fix_rigid_ && ellgran_laws_uses_mass(laws) == 1) return false;
  for (int m = 1; m < n_FixMesh_; m++)
    if (FixMesh_list_[m]->atomTypeWall() != FixMesh_list_[0]->atomTypeWall()) return false;
  // another fix keeps numbers of its own with each contact
  return ellgran_wall_histories_length(wall_, laws) == static_cast<size_t>(histories_length_);
}

// Forces of all particles with the wall.
void FixWallGranEllipsoid::act_in_one_call(EllgranContact &model, const EllgranLaws *laws, const EllgranWallMotion *motion)
{
  if (is_mesh_wall()) atom_type_wall_ = FixMesh_list_[0]->atomTypeWall();
  EllgranParticles particles = model.particles();
  if (ellgran_laws_uses_mass(laws) == 1) particles.masses = particles.contact_masses = atom->rmass;
  // the library is told when it sees what it saw before, but for the motion
  const bool seen = !update->setupflag && neighbor->ago > 0 && neighbor->ncalls == lists_of_one_call_ &&
      step_of_one_call_ + 1 == update->ntimestep;
  particles.unchanged = seen;
  if (!update->setupflag) particles.prepared_by = EllgranContact::prepared_for_pairs(lmp);
  const EllgranStep step = model.step(shearupdate_);
  EllgranWallLoad load = ELLGRAN_INIT(EllgranWallLoad);
  if (atom->nlocal > 0)
    check(ellgran_compute_wall(laws, workspace_, wall_, &particles, atom->mask, groupbit, atom_type_wall_, motion,
                               histories_ ? histories_[0] : NULL, &step, &load, NULL));
  if (load.crowded_particle > 0) crowded_ = atom->tag[load.crowded_particle - 1];
  step_of_one_call_ = update->ntimestep;
  lists_of_one_call_ = neighbor->ncalls;
}

// All contacts of all particles with the wall.
void FixWallGranEllipsoid::act(const EllgranWallMotion *motion)
{
  EllgranContact *const model = EllgranContact::of(this);
  const EllgranLaws *const laws = model->laws_with_friction();
  if (takes_one_call(*model, laws)) {
    act_in_one_call(*model, laws, motion);
    return;
  }
  step_of_one_call_ = -1;
  const EllgranParticles particles = model->particles();
  check(ellgran_staged_set_time_step(model->staged, update->dt));
  double *const remembered = histories_ ? histories_[0] : NULL;
  check(ellgran_find_wall_contacts(workspace_, wall_, &particles, atom->mask, groupbit, motion, dnum_, remembered));
  const size_t count = ellgran_wall_found_count(wall_);
  for (size_t index = 0; index < count; index++) act(*model, index);
  if (computeflag_) check(ellgran_remember_wall_contacts(wall_, atom->nlocal, atom->mask, groupbit, remembered));
}

EllgranWallMotion FixWallGranEllipsoid::motion_of_primitive() const
{
  EllgranWallMotion motion = ELLGRAN_INIT(EllgranWallMotion);
  motion.along_itself = 1;
  if (shear_ && shearAxis_ >= 0) {
    vectorCopy3D(point_, motion.origin);
    vectorCopy3D(shearAxisVec_, motion.angular_velocity);
  } else if (shear_)
    motion.velocity[shearDim_] = vshear_;
  return motion;
}

void FixWallGranEllipsoid::post_force_primitive(int)
{
  const EllgranWallMotion motion = motion_of_primitive();
  act(&motion);
}

const EllgranLaws *FixWallGranEllipsoid::laws_with_friction() const
{
  return EllgranContact::of(this)->laws_with_friction();
}

bool FixWallGranEllipsoid::has_laws() const
{
  const EllgranContact *const model = EllgranContact::of(this);
  return model && model->laws;
}

void FixWallGranEllipsoid::add_to_step_sums(const EllgranParticles &particles, double *sums, EllgranContactExtremes *extremes)
{
  EllgranWallMotion motion = ELLGRAN_INIT(EllgranWallMotion);
  if (!is_mesh_wall()) motion = motion_of_primitive();
  check(ellgran_find_wall_contacts(workspace_, wall_, &particles, atom->mask, groupbit, &motion, 0, NULL));
  std::vector<int32_t> types(ellgran_wall_found_count(wall_), atom_type_wall_);
  if (is_mesh_wall())
    for (size_t index = 0; index < types.size(); index++) {
      EllgranFoundWallContact contact = ELLGRAN_INIT(EllgranFoundWallContact);
      check(ellgran_wall_found(wall_, index, &contact));
      types[index] = FixMesh_list_[near_[contact.triangle].mesh]->atomTypeWall();
    }
  const int32_t none = 1;
  check(ellgran_add_wall_to_step_sums(laws_with_friction(), workspace_, wall_, &particles, types.empty() ? &none : &types[0],
                                      sums, extremes));
}

// LIGGGHTS counts the contacts with a mesh in its own history of them, and compute wall/gran/local makes room for as many.
bool FixWallGranEllipsoid::counts_contacts() const
{
  return computeflag_ && cwl_;
}

// Triangles near particles, of all meshes together: meshes that meet are one surface.
void FixWallGranEllipsoid::lend_triangles()
{
  near_.clear();
  for (int m = 0; m < n_FixMesh_; m++) {
    TriMesh *const mesh = FixMesh_list_[m]->triMesh();
    FixNeighlistMesh *const list = FixMesh_list_[m]->meshNeighlist();
    const int triangles = mesh->sizeLocal() + mesh->sizeGhost();
    for (int t = 0; t < triangles; t++) {
      if (list->get_contact_list(t).empty()) continue;
      const Near triangle = {m, mesh->id(t), t};
      near_.push_back(triangle);
    }
  }
  // in an order that does not depend on how the mesh is spread over ranks
  std::sort(near_.begin(), near_.end());

  const int nlocal = atom->nlocal;
  starts_.assign(nlocal + 1, 0);
  corners_.resize(9 * near_.size());
  velocities_.assign(9 * near_.size(), 0.0);
  for (size_t k = 0; k < near_.size(); k++) {
    FixMeshSurface *const fix_mesh = FixMesh_list_[near_[k].mesh];
    TriMesh *const mesh = fix_mesh->triMesh();
    MultiVectorContainer<double, 3, 3> *const moving =
        mesh->prop().getElementProperty<MultiVectorContainer<double, 3, 3> >("v");
    for (int node = 0; node < 3; node++) {
      mesh->node(near_[k].place, node, &corners_[9 * k + 3 * node]);
      if (moving) vectorCopy3D(moving->begin()[near_[k].place][node], &velocities_[9 * k + 3 * node]);
    }
    const std::vector<int> &particles = fix_mesh->meshNeighlist()->get_contact_list(near_[k].place);
    for (size_t n = 0; n < particles.size(); n++)
      if (particles[n] < nlocal) starts_[particles[n] + 1]++;
  }
  for (int i = 0; i < nlocal; i++) starts_[i + 1] += starts_[i];
  std::vector<size_t> next(starts_.begin(), starts_.end() - 1);
  lists_.resize(starts_[nlocal]);
  for (size_t k = 0; k < near_.size(); k++) {
    const std::vector<int> &particles =
        FixMesh_list_[near_[k].mesh]->meshNeighlist()->get_contact_list(near_[k].place);
    for (size_t n = 0; n < particles.size(); n++)
      if (particles[n] < nlocal) lists_[next[particles[n]]++] = k;
  }

  refuse_turning_images();

  EllgranLentTriangles triangles = ELLGRAN_INIT(EllgranLentTriangles);
  triangles.count = near_.size();
  triangles.particle_count = nlocal;
  triangles.near_starts = &starts_[0];
  if (!near_.empty()) {
    triangles.corners = &corners_[0];
    triangles.velocities = &velocities_[0];
  }
  if (!lists_.empty()) triangles.near = &lists_[0];
  check(ellgran_wall_lend_triangles(wall_, &triangles));
}

// Whether a point is outside of the box in a periodic dimension.
bool FixWallGranEllipsoid::is_across(int dimension, const double *point) const
{
  if (!domain->periodicity[dimension]) return false;
  double in_box[3];
  vectorCopy3D(point, in_box);
  if (domain->triclinic) domain->x2lamda(in_box, in_box);
  const double low = domain->triclinic ? 0.0 : domain->boxlo[dimension], high = domain->triclinic ? 1.0 : domain->boxhi[dimension];
  const double rounding = 1e-9 * (high - low);
  return in_box[dimension] < low - rounding || in_box[dimension] > high + rounding;
}

// LIGGGHTS turns images of a mesh, and triangles that it has put to the other side of the box, about the axis of the mesh itself and not about the
// image of that axis. Until lists are built anew such images are not where they should be, such triangles never again.
void FixWallGranEllipsoid::refuse_turning_images() const
{
  if (domain->xperiodic + domain->yperiodic + domain->zperiodic == 0) return;
  const double edges[3][3] = {
      {domain->xprd, 0.0, 0.0}, {domain->xy, domain->yprd, 0.0}, {domain->xz, domain->yz, domain->zprd}};
  for (size_t k = 0; k < near_.size(); k++) {
    if (!FixMesh_list_[near_[k].mesh]->triMesh()->isRotating()) continue;
    const double *const corners = &corners_[9 * k], *const velocities = &velocities_[9 * k];
    double sides[2][3], changes[2][3], normal[3];
    for (int s = 0; s < 2; s++) {
      vectorSubtract3D(corners + 3 * (s + 1), corners, sides[s]);
      vectorSubtract3D(velocities + 3 * (s + 1), velocities, changes[s]);
    }
    vectorCross3D(sides[0], sides[1], normal);
    const double square = vectorMag3DSquared(normal);
    if (!(square > 0.0)) continue;
    // the angular velocity with which all three corners move as they do
    const double along[3] = {vectorDot3D(changes[1], normal), -vectorDot3D(changes[0], normal), vectorDot3D(changes[0], sides[1])};
    double spin[3];
    for (int c = 0; c < 3; c++) spin[c] = (along[0] * sides[0][c] + along[1] * sides[1][c] + along[2] * normal[c]) / square;
    for (int dimension = 0; dimension < 3; dimension++) {
      double apart[3];
      vectorCross3D(spin, edges[dimension], apart);
      if (!(vectorMag3D(apart) > 1e-6 * vectorMag3D(spin) * vectorMag3D(edges[dimension]))) continue;
      if (!is_across(dimension, corners) && !is_across(dimension, corners + 3) && !is_across(dimension, corners + 6)) continue;
      char message[400];
      snprintf(message, sizeof(message),
               "fix %s (%s): mesh %s turns, and reaches across the periodic boundary in %c, where LIGGGHTS turns its images about the axis of the "
               "mesh itself, and they are not where they should be: use 'boundary' with f, s or m in that dimension, or an axis along it",
               id, style, FixMesh_list_[near_[k].mesh]->id, "xyz"[dimension]);
      error->one(FLERR, message);
    }
  }
}

void FixWallGranEllipsoid::post_force_mesh(int)
{
  row_ = 0;
  if (counts_contacts())
    for (int m = 0; m < n_FixMesh_; m++) FixMesh_list_[m]->contactHistory()->markAllContacts();
  lend_triangles();
  act(NULL);
  if (counts_contacts())
    for (int m = 0; m < n_FixMesh_; m++) FixMesh_list_[m]->contactHistory()->cleanUpContacts();
}
