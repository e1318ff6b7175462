/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_ellgran_servo.h"

#include <cmath>
#include <cstring>
#include <vector>

#include "comm.h"
#include "error.h"
#include "fix_mesh_surface.h"
#include "mesh_module_stress_servo.h"
#include "modify.h"
#include "update.h"
#include "vector_liggghts.h"

using namespace LAMMPS_NS;

namespace {

const double FORMAT = 1.0;

}

FixEllgranServo::FixEllgranServo(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), mesh_(narg == 4 ? arg[3] : ""), is_of_file_(false), begins_(false)
{
  if (narg != 4) error->fix_error(FLERR, this, "takes the ID of a mesh; fix mesh/surface/stress/servo makes it");
  restart_global = 1;
  memset(&state_, 0, sizeof(state_));
}

// LIGGGHTS calls setup_pre_force of those fixes that have pre_force.
int FixEllgranServo::setmask()
{
  return FixConst::INITIAL_INTEGRATE | FixConst::PRE_FORCE;
}

void FixEllgranServo::add(LAMMPS *lmp, const char *mesh)
{
  const std::string name = std::string("ellgran_servo_") + mesh;
  if (lmp->modify->find_fix(name.c_str()) >= 0) lmp->modify->delete_fix(name.c_str());
  std::vector<char> id(name.c_str(), name.c_str() + name.size() + 1), of(mesh, mesh + strlen(mesh) + 1);
  char group[] = "all", style[] = "ellgran/servo";
  char *words[] = {&id[0], group, style, &of[0]};
  lmp->modify->add_fix(4, words);
}

// By name: the mesh may be gone.
MeshModuleStressServo *FixEllgranServo::servo() const
{
  FixMeshSurface *const mesh = dynamic_cast<FixMeshSurface *>(modify->find_fix_id(mesh_.c_str()));
  return mesh ? dynamic_cast<MeshModuleStressServo *>(mesh->get_module("servo")) : NULL;
}

// A mesh that turns has turned since the velocities of its corners were set.
double FixEllgranServo::turn_of_a_step(const MeshModuleStressServo &controller, const double *motion) const
{
  const bool moves = controller.int_flag_, turns = controller.ctrl_op_ != controller.vcm_(0);
  return moves && turns ? update->dt * vectorDot3D(motion, controller.axis_) : 0.0;
}

// Those of the corners of a mesh that moves so, as they were when it had not turned by this angle yet.
void FixEllgranServo::set_velocities(MeshModuleStressServo &controller, const double *motion, double turned_by) const
{
  double present[3];
  vectorCopy3D(controller.ctrl_op_, present);
  vectorCopy3D(motion, controller.ctrl_op_);
  if (controller.ctrl_op_ == controller.vcm_(0))
    controller.set_v_node();
  else
    controller.set_v_node_rotate();
  vectorCopy3D(present, controller.ctrl_op_);
  if (turned_by == 0.0) return;
  for (int i = 0; i < controller.mesh->size(); i++)
    for (int j = 0; j < controller.mesh->numNodes(); j++) {
      double *const v = (*controller.v_)(i)[j], across[3];
      vectorCross3D(controller.axis_, v, across);
      for (int k = 0; k < 3; k++) v[k] = cos(turned_by) * v[k] - sin(turned_by) * across[k];
    }
}

// After that of the mesh, which shares out the triangles. Walls compute forces later, in setup.
void FixEllgranServo::setup_pre_force(int)
{
  MeshModuleStressServo *const controller = servo();
  if (!controller) return;
  if (is_of_file_) {
    is_of_file_ = false;
    vectorCopy3D(state_.motion, controller->ctrl_op_);
    controller->sum_err_ = state_.sum_of_errors;
    controller->old_pv_mag_ = state_.load_before;
  }
  set_velocities(*controller, state_.motion_before, state_.turned_by);
  begins_ = true;
}

// The mesh, whose fix comes before this one, has moved.
void FixEllgranServo::initial_integrate(int)
{
  MeshModuleStressServo *const controller = servo();
  if (begins_ && controller) set_velocities(*controller, controller->ctrl_op_, turn_of_a_step(*controller, controller->ctrl_op_));
  begins_ = false;
}

void FixEllgranServo::pre_force(int)
{
  MeshModuleStressServo *const controller = servo();
  if (!controller) return;
  vectorCopy3D(controller->ctrl_op_, state_.motion_before);
  state_.turned_by = turn_of_a_step(*controller, state_.motion_before);
}

void FixEllgranServo::write_restart(FILE *fp)
{
  if (comm->me != 0) return;
  MeshModuleStressServo *const controller = servo();
  if (!is_of_file_ && controller && controller->ctrl_op_) {
    vectorCopy3D(controller->ctrl_op_, state_.motion);
    state_.sum_of_errors = controller->sum_err_;
    state_.load_before = controller->old_pv_mag_;
  }
  state_.format = FORMAT;
  const int size = sizeof(state_);
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(&state_, 1, sizeof(state_), fp);
}

void FixEllgranServo::restart(char *buffer)
{
  memcpy(&state_, buffer, sizeof(state_));
  if (state_.format > FORMAT)
    error->fix_error(FLERR, this, "a later release of ellgran wrote the restart file: use that one, or a later one");
  is_of_file_ = true;
}
