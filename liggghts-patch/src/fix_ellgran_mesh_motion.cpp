/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_ellgran_mesh_motion.h"

#include <algorithm>
#include <map>

#include "comm.h"
#include "error.h"
#include "fix_mesh_surface.h"
#include "fix_move_mesh.h"
#include "mesh_mover.h"
#include "modify.h"

using namespace LAMMPS_NS;

namespace {

typedef MultiVectorContainer<double, 3, 3> Velocities;

// In restart files: the version of this, the numbers of triangles and of motions, the values of each triangle, and the point of each motion. In
// version 1 there were no motions.
const double FORMAT = 2.0;
const int HEADER_OF_1 = 2, HEADER = 3, CORNERS = 3, VALUES = 1 + 3 * CORNERS;

std::string id_of(const std::string &mesh)
{
  return "ellgran_mesh_motion_" + mesh;
}

}

FixEllgranMeshMotion::FixEllgranMeshMotion(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), mesh_(narg == 4 ? arg[3] : ""), has_moved_(false)
{
  if (narg != 4) error->fix_error(FLERR, this, "takes the ID of a mesh; fix move/mesh makes it");
  restart_global = 1;
}

void FixEllgranMeshMotion::add(LAMMPS *lmp, const std::string &mesh)
{
  const std::string name = id_of(mesh);
  if (lmp->modify->find_fix(name.c_str()) >= 0) lmp->modify->delete_fix(name.c_str());
  std::vector<char> id(name.c_str(), name.c_str() + name.size() + 1), of(mesh.c_str(), mesh.c_str() + mesh.size() + 1);
  char group[] = "all", style[] = "ellgran/mesh_motion";
  char *words[] = {&id[0], group, style, &of[0]};
  lmp->modify->add_fix(4, words);
}

bool FixEllgranMeshMotion::knows(LAMMPS *lmp, const std::string &mesh)
{
  const FixEllgranMeshMotion *const fix = dynamic_cast<FixEllgranMeshMotion *>(lmp->modify->find_fix_id(id_of(mesh).c_str()));
  return fix && fix->has_moved_;
}

// LIGGGHTS calls setup_pre_force of those fixes that have pre_force.
int FixEllgranMeshMotion::setmask()
{
  return FixConst::PRE_FORCE;
}

// By name: the mesh may be gone.
TriMesh *FixEllgranMeshMotion::mesh() const
{
  FixMeshSurface *const mesh = dynamic_cast<FixMeshSurface *>(modify->find_fix_id(mesh_.c_str()));
  return mesh ? mesh->triMesh() : NULL;
}

std::vector<FixMoveMesh *> FixEllgranMeshMotion::motions() const
{
  std::vector<FixMoveMesh *> found;
  for (int k = 0; k < modify->nfix; k++) {
    FixMoveMesh *const motion = dynamic_cast<FixMoveMesh *>(modify->fix[k]);
    if (motion && motion->fix_mesh_id_ == mesh_) found.push_back(motion);
  }
  return found;
}

// After that of the mesh, which shares out the triangles. Walls compute forces later, in setup.
void FixEllgranMeshMotion::setup_pre_force(int)
{
  TriMesh *const triangles = mesh();
  const std::vector<FixMoveMesh *> moved_by = motions();
  if (triangles && points_of_file_.size() == 3 * moved_by.size())
    for (size_t k = 0; k < moved_by.size(); k++) {
      // LIGGGHTS moves such a point by a way alone: back to zero, and to its place
      double back[3];
      moved_by[k]->move_->get_reference_point(back);
      for (int c = 0; c < 3; c++) back[c] = -back[c];
      moved_by[k]->move(back);
      moved_by[k]->move(&points_of_file_[3 * k]);
    }
  if (triangles) points_of_file_.clear();
  if (of_file_.empty() || !triangles) return;
  std::map<int, const double *> values;
  for (size_t k = 0; k < of_file_.size(); k += VALUES) values[static_cast<int>(of_file_[k])] = &of_file_[k + 1];
  if (!triangles->prop().getElementProperty<Velocities>("v"))
    triangles->prop().addElementProperty<Velocities>("v", "comm_exchange_borders", "frame_invariant", "restart_no");
  Velocities &v = *triangles->prop().getElementProperty<Velocities>("v");
  v.setAll(0.0);
  for (int i = 0; i < triangles->size(); i++) {
    const std::map<int, const double *>::const_iterator found = values.find(triangles->id(i));
    if (found == values.end()) continue;
    for (int j = 0; j < CORNERS; j++) std::copy(found->second + 3 * j, found->second + 3 * j + 3, v(i)[j]);
  }
  of_file_.clear();
  has_moved_ = true;
}

void FixEllgranMeshMotion::write_restart(FILE *fp)
{
  std::vector<double> here;
  TriMesh *const triangles = mesh();
  Velocities *const v = triangles && has_moved_ ? triangles->prop().getElementProperty<Velocities>("v") : NULL;
  for (int i = 0; v && i < triangles->sizeLocal(); i++) {
    here.push_back(triangles->id(i));
    for (int j = 0; j < CORNERS; j++) here.insert(here.end(), (*v)(i)[j], (*v)(i)[j] + 3);
  }
  // a file that was read and written again without a run
  if (comm->me == 0 && !of_file_.empty()) here = of_file_;
  std::vector<double> points = points_of_file_;
  if (points.empty()) {
    const std::vector<FixMoveMesh *> moved_by = motions();
    points.resize(3 * moved_by.size());
    for (size_t k = 0; k < moved_by.size(); k++) moved_by[k]->move_->get_reference_point(&points[3 * k]);
  }

  int count = here.size();
  std::vector<int> counts(comm->nprocs), places(comm->nprocs, 0);
  MPI_Gather(&count, 1, MPI_INT, &counts[0], 1, MPI_INT, 0, world);
  for (int k = 1; k < comm->nprocs; k++) places[k] = places[k - 1] + counts[k - 1];
  std::vector<double> all(comm->me == 0 ? places.back() + counts.back() : 0);
  MPI_Gatherv(here.empty() ? NULL : &here[0], count, MPI_DOUBLE, all.empty() ? NULL : &all[0], &counts[0], &places[0], MPI_DOUBLE, 0, world);
  if (comm->me != 0) return;
  const double header[HEADER] = {FORMAT, static_cast<double>(all.size() / VALUES), static_cast<double>(points.size() / 3)};
  const int size = (HEADER + all.size() + points.size()) * sizeof(double);
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(header, sizeof(double), HEADER, fp);
  if (!all.empty()) fwrite(&all[0], sizeof(double), all.size(), fp);
  if (!points.empty()) fwrite(&points[0], sizeof(double), points.size(), fp);
}

void FixEllgranMeshMotion::restart(char *buffer)
{
  const double *const values = reinterpret_cast<const double *>(buffer);
  if (values[0] > FORMAT)
    error->fix_error(FLERR, this, "a later release of ellgran wrote the restart file: use that one, or a later one");
  const bool has_points = values[0] > 1.0;
  const double *const triangles = values + (has_points ? HEADER : HEADER_OF_1);
  const double *const points = triangles + static_cast<size_t>(values[1]) * VALUES;
  of_file_.assign(triangles, points);
  if (has_points) points_of_file_.assign(points, points + 3 * static_cast<size_t>(values[2]));
}
