// SPDX-License-Identifier: GPL-2.0-or-later

#include "fix_wall_gran_ellipsoid_device.h"

#include "pair_gran_ellipsoid_device.h"

#include "atom_kokkos.h"
#include "atom_masks.h"
#include "error.h"
#include "group.h"
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <vector>

using namespace LAMMPS_NS;
using namespace FixConst;

namespace {

const char CALLER[] = "Fix wall/gran/ellipsoid/kk";

}    // namespace

FixWallGranEllipsoidDevice::FixWallGranEllipsoidDevice(LAMMPS *lmp, int narg, char **arg) :
    FixWallGranEllipsoid(checked(lmp), narg, arg, false), atomKK(static_cast<AtomKokkos *>(atom)), pair(nullptr), type_in_scene(0),
    numbers{-1, -1}, number(-1)
{
  refuse_what_the_gpu_has_not();
  // Sums over contacts are not on the GPU.
  scalar_flag = vector_flag = local_flag = 0;
  energy_global_flag = virial_global_flag = virial_peratom_flag = 0;
  create_attribute = restart_global = restart_peratom = maxexchange = 0;
  stores_ids = 1;
  kokkosable = 1;
  execution_space = Device;
  datamask_read = datamask_modify = EMPTY_MASK;
}

// Before the style is made: its own messages would say less.
LAMMPS *FixWallGranEllipsoidDevice::checked(LAMMPS *lmp)
{
  if (!lmp->kokkos)
    lmp->error->all(FLERR,
                    "{}: style wall/gran/ellipsoid/kk needs LAMMPS to run with KOKKOS: start it with '-k on g 1', or use "
                    "wall/gran/ellipsoid",
                    CALLER);
  return lmp;
}

void FixWallGranEllipsoidDevice::refuse_what_the_gpu_has_not() const
{
  const auto refuse = [this](const char *what) {
    error->all(FLERR, "{} {}: {} not on the GPU: start LAMMPS without '-k on'", CALLER, id, what);
  };
  if (has_material) refuse("a material of the wall is");
  if (servo) refuse("'servo' is");
  if (tells_contacts) refuse("'contacts' is");
  if (triangle_file_every > 0) refuse("'vtk' is");
  if (keeps_energies) refuse("'energies yes' is");
  if (igroup != 0) refuse("a wall for a group other than 'all' is");
}

int FixWallGranEllipsoidDevice::setmask()
{
  return POST_FORCE;
}

void FixWallGranEllipsoidDevice::init()
{
  if (utils::strmatch(update->integrate_style, "^respa")) error->all(FLERR, "{} does not support rRESPA: use 'run_style verlet'", CALLER);
  check_periodicity();
  require_region_as_it_was();
  for (const NumberOrVariable &component : velocity) component.require_variable(lmp);
  rotation_rate.require_variable(lmp);
  pair = PairGranEllipsoidDevice::of(lmp, CALLER);
}

void FixWallGranEllipsoidDevice::add_to_scene(EllgranDeviceGrains &grains, int type)
{
  type_in_scene = type;
  if (!is_of_planes()) {
    number = grains.add_wall(wall);
    return;
  }
  for (int k = 0; k < 2; k++)
    if (plane_slots[k] >= 0) numbers[k] = grains.add_plane();
}

void FixWallGranEllipsoidDevice::setup(int vflag)
{
  post_force(vflag);
  atomKK->sync(Host, TYPE_MASK | ELLIPSOID_MASK | BONUS_MASK);
  warn_of_missing_images();
}

void FixWallGranEllipsoidDevice::post_force(int)
{
  const bool time_passes = update->setupflag == 0;
  follow_time(time_passes);
  const EllgranWallMotion motion = motion_of_forces = motion_now(time_passes);
  EllgranStep step = ELLGRAN_INIT(EllgranStep);
  step.time_step = update->dt;
  step.advance_history = time_passes ? 1 : 0;
  atomKK->sync(Device, X_MASK | F_MASK | TORQUE_MASK | TAG_MASK);
  if (is_of_planes())
    add_plane_forces(motion, step);
  else
    pair->grains.add_wall_forces(number, motion, type_in_scene, step);
  atomKK->modified(Device, F_MASK | TORQUE_MASK);
}

void FixWallGranEllipsoidDevice::add_plane_forces(const EllgranWallMotion &motion, const EllgranStep &step)
{
  std::vector<EllgranDeviceGrains::PlaneNow> planes;
  for (int k = 0; k < 2; k++) {
    if (plane_slots[k] < 0) continue;
    EllgranDeviceGrains::PlaneNow plane{numbers[k], ELLGRAN_INIT(EllgranPlane)};
    plane.place.point[dimension] = plane_positions[k];
    plane.place.normal[dimension] = (k == 0) ? 1.0 : -1.0;
    for (int c = 0; c < 3; c++) plane.place.point[c] += motion.displacement[c];
    std::copy_n(motion.velocity, 3, plane.place.velocity);
    planes.push_back(plane);
  }
  pair->grains.add_plane_forces(planes, type_in_scene, step);
}
