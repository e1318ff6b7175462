# SPDX-License-Identifier: GPL-2.0-or-later
#
# The sources of the styles, for the plugin and for a LAMMPS that has them built in.

set(ELLGRAN_STYLE_SOURCES
  compute_contact_ellipsoid_atom.cpp
  compute_energy_ellipsoid.cpp
  compute_timestep_ellipsoid.cpp
  create_ellipsoids.cpp
  ellgran_atoms.cpp
  ellgran_contact_sources.cpp
  ellgran_energy_balance.cpp
  ellgran_grain_mixture.cpp
  ellgran_grain_placement.cpp
  ellgran_half_step.cpp
  ellgran_history.cpp
  ellgran_kokkos.cpp
  ellgran_number_or_variable.cpp
  ellgran_refusals.cpp
  ellgran_region.cpp
  ellgran_scene_step.cpp
  ellgran_step_limits.cpp
  ellgran_step_velocity.cpp
  ellgran_wall_servo.cpp
  ellgran_wall_shape.cpp
  ellgran_wall_velocity.cpp
  fix_nve_ellipsoid.cpp
  fix_pour_ellipsoid.cpp
  fix_wall_gran_ellipsoid.cpp
  pair_gran_ellipsoid.cpp)
list(TRANSFORM ELLGRAN_STYLE_SOURCES PREPEND "${CMAKE_CURRENT_LIST_DIR}/")

# Those for a GPU, compiled with the headers of KOKKOS.
set(ELLGRAN_DEVICE_STYLE_SOURCES
  ellgran_device_grains.cpp
  ellgran_device_history.cpp
  fix_nve_ellipsoid_device.cpp
  fix_wall_gran_ellipsoid_device.cpp
  pair_gran_ellipsoid_device.cpp)
list(TRANSFORM ELLGRAN_DEVICE_STYLE_SOURCES PREPEND "${CMAKE_CURRENT_LIST_DIR}/")
