// SPDX-License-Identifier: GPL-2.0-or-later

#include "fix_wall_gran_ellipsoid_device.h"

#include "pair_gran_ellipsoid_device.h"

#include "atom_kokkos.h"
#include "atom_masks.h"
#include "comm.h"
#include "error.h"
#include "group.h"
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <unordered_map>
#include <vector>

using namespace LAMMPS_NS;
using namespace FixConst;

namespace {

const char CALLER[] = "Fix wall/gran/ellipsoid/kk";

}    // namespace

FixWallGranEllipsoidDevice::FixWallGranEllipsoidDevice(LAMMPS *lmp, int narg, char **arg) :
    FixWallGranEllipsoid(checked(lmp), narg, arg, false), atomKK(static_cast<AtomKokkos *>(atom)), pair(nullptr), type_in_scene(0),
    numbers{-1, -1}, number(-1), knows_loads(true), held(false)
{
  refuse_what_the_gpu_has_not();
  // From here on nothing stops this constructor: LAMMPS does not know yet whose arrays they are.
  keep_with_atoms();
  // Energies and contacts one by one are not on the GPU.
  scalar_flag = local_flag = 0;
  energy_global_flag = virial_global_flag = virial_peratom_flag = 0;
  stores_ids = 1;
  // As of FixEllgranDeviceHistory.
  sort_device = 1;
  exchange_comm_device = (comm->nprocs == 1) ? 1 : 0;
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

/* LAMMPS compares the names of fixes when it hands out what a restart file has for each atom: it then goes on with and without a GPU. */

void FixWallGranEllipsoidDevice::post_constructor()
{
  FixWallGranEllipsoid::post_constructor();
  delete[] style;
  style = utils::strdup("wall/gran/ellipsoid");
}

int FixWallGranEllipsoidDevice::setmask()
{
  return PRE_EXCHANGE | POST_FORCE;
}

void FixWallGranEllipsoidDevice::init()
{
  if (utils::strmatch(update->integrate_style, "^respa")) error->all(FLERR, "{} does not support rRESPA: use 'run_style verlet'", CALLER);
  check_periodicity();
  require_region_as_it_was();
  for (const NumberOrVariable &component : velocity) component.require_variable(lmp);
  rotation_rate.require_variable(lmp);
  pair = PairGranEllipsoidDevice::of(lmp, CALLER);
  sees_velocities_of_step = pair->grains.uses_velocities_of_step();
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
  const EllgranWallMotion motion = motion_now(time_passes);
  motion_of_forces = motion;
  std::copy_n(motion.displacement, 3, displacement);
  std::copy_n(motion.velocity, 3, wall_velocity);
  has_forces = true;
  summed = knows_loads = false;
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
    std::copy_n(motion.velocity_change, 3, plane.place.velocity_change);
    planes.push_back(plane);
  }
  pair->grains.add_plane_forces(planes, type_in_scene, step);
}

/* The force on the wall and its torque are summed up on the GPU in each step, and are asked for here. */

double FixWallGranEllipsoidDevice::compute_vector(int k)
{
  const bool is_of_one_plane = k < NORMAL_ELASTIC;
  if (k < NUMBER_OF_SUMS && k < FORCE && !is_of_one_plane)
    error->all(FLERR,
               "{} {}: f_{}[{}], an energy or a count, is not on the GPU, where there are forces, torque and power of the wall and its motion: start "
               "LAMMPS without '-k on'",
               CALLER, id, id, k + 1);
  if (is_of_one_plane && rotates && plane_slots[0] >= 0 && plane_slots[1] >= 0)
    error->all(FLERR, "{} {}: f_{}[{}], the force on one of two planes that turn, is not on the GPU: give each plane a fix of its own", CALLER, id,
               id, k + 1);
  if (!knows_loads) take_loads();
  return FixWallGranEllipsoid::compute_vector(k);
}

void FixWallGranEllipsoidDevice::take_loads()
{
  knows_loads = true;
  std::fill_n(output_here, static_cast<int>(NUMBER_OF_SUMS), 0.0);
  const EllgranWallMotion &motion = motion_of_forces;
  double centre[3];
  for (int c = 0; c < 3; c++) centre[c] = motion.origin[c] + motion.displacement[c];
  double *const force = output_here + FORCE, *const torque = output_here + TORQUE;
  const auto add = [&](int32_t of, double *to) {
    const auto load = pair->grains.load_on_wall(of);
    for (int c = 0; c < 3; c++) {
      const int d = (c + 1) % 3, e = (c + 2) % 3;
      force[c] += load.force[c];
      torque[c] += load.torque[c] - (centre[d] * load.force[e] - centre[e] * load.force[d]);
      if (to) to[c] += load.force[c];
    }
  };
  if (is_of_planes()) {
    for (int k = 0; k < 2; k++)
      if (plane_slots[k] >= 0) add(numbers[k], output_here + (k == 0 ? FORCE_LO : FORCE_HI));
  } else {
    // A wall of another kind has neither plane.
    double *const only = (plane_slots[0] >= 0) ? output_here + FORCE_LO : (plane_slots[1] >= 0) ? output_here + FORCE_HI : nullptr;
    add(number, only);
  }
  for (int c = 0; c < 3; c++) output_here[POWER] -= force[c] * motion.velocity[c] + torque[c] * motion.angular_velocity[c];
}

/* The wall of the scene, or its planes, with their parts. */

std::vector<EllgranDeviceGrains::WallOnHost> FixWallGranEllipsoidDevice::on_host() const
{
  if (!is_of_planes()) return {{number, wall, laws, 0}};
  std::vector<EllgranDeviceGrains::WallOnHost> planes;
  for (int k = 0; k < 2; k++)
    if (plane_slots[k] >= 0) planes.push_back({numbers[k], wall, laws, plane_slots[k]});
  return planes;
}

void FixWallGranEllipsoidDevice::take_from_device()
{
  if (histories_length == 0 || !is_in_scene() || !pair->grains.has_list()) return;
  atomKK->sync(Host, TAG_MASK);
  const auto ids = pair->grains.ids_of_owned();
  const auto length = static_cast<std::size_t>(histories_length);
  std::vector<double> values(ids.size() * length);
  for (const auto &part : on_host()) pair->grains.read_wall(part, values.data());
  std::unordered_map<tagint, std::size_t> row_of;
  for (std::size_t k = 0; k < ids.size(); k++) row_of[ids[k]] = k;
  for (int i = 0; i < atom->nlocal; i++) {
    const auto found = row_of.find(atom->tag[i]);
    if (found == row_of.end())
      std::fill_n(contact_histories[i], length, 0.0);
    else
      std::copy_n(&values[found->second * length], length, contact_histories[i]);
  }
  held = true;
}

void FixWallGranEllipsoidDevice::give_to_device()
{
  if (held && histories_length > 0)
    for (const auto &part : on_host()) pair->grains.write_wall(part, atom->nlocal > 0 ? contact_histories[0] : nullptr);
  held = false;
}

void FixWallGranEllipsoidDevice::pre_exchange()
{
  if (comm->nprocs > 1) take_from_device();
}

/* Commands between two runs may delete atoms, give them other IDs, or change what the scene is made of. */

void FixWallGranEllipsoidDevice::post_run()
{
  take_from_device();
}

void FixWallGranEllipsoidDevice::write_restart(FILE *fp)
{
  if (!held) take_from_device();
  FixWallGranEllipsoid::write_restart(fp);
}

int FixWallGranEllipsoidDevice::unpack_exchange(int i, double *buffer)
{
  held = true;
  return FixWallGranEllipsoid::unpack_exchange(i, buffer);
}
