# SPDX-License-Identifier: GPL-2.0-or-later
#
# Builds the styles into LAMMPS itself, in place of a plugin. LAMMPS' sources stay as they are:
#
#   cmake -S <lammps>/cmake -B build -DCMAKE_PROJECT_lammps_INCLUDE=<here>/ellgran-builtin.cmake \
#         -DELLGRAN_LIBRARY=<dir>/libellgran.a -DELLGRAN_INCLUDE_DIR=<dir with ellgran.h>
#
# For a LAMMPS with KOKKOS for CUDA -DELLGRAN_GPU=on and libellgran_gpu.a: the styles with the suffix kk then compute on the GPU.

if(CMAKE_VERSION VERSION_LESS 3.19)
  message(FATAL_ERROR "ellgran-builtin.cmake needs CMake 3.19 or later")
endif()
set(ELLGRAN_LIBRARY "" CACHE FILEPATH "libellgran.a")
set(ELLGRAN_INCLUDE_DIR "" CACHE PATH "directory with ellgran.h")
option(ELLGRAN_GPU "styles with the suffix kk for a GPU of NVIDIA" OFF)
if(NOT EXISTS "${ELLGRAN_LIBRARY}" OR NOT EXISTS "${ELLGRAN_INCLUDE_DIR}/ellgran.h")
  message(FATAL_ERROR "Set ELLGRAN_LIBRARY to libellgran.a and ELLGRAN_INCLUDE_DIR to the directory "
                      "with ellgran.h (now '${ELLGRAN_LIBRARY}' and '${ELLGRAN_INCLUDE_DIR}')")
endif()
set(ELLGRAN_STYLES_DIR "${CMAKE_CURRENT_LIST_DIR}")
include("${ELLGRAN_STYLES_DIR}/ellgran-sources.cmake")

# LAMMPS collects the headers of its styles in these two properties before it writes style_*.h.
set_property(GLOBAL APPEND PROPERTY PAIR "${ELLGRAN_STYLES_DIR}/pair_gran_ellipsoid.h")
set_property(GLOBAL APPEND PROPERTY FIX "${ELLGRAN_STYLES_DIR}/fix_wall_gran_ellipsoid.h"
  "${ELLGRAN_STYLES_DIR}/fix_nve_ellipsoid.h" "${ELLGRAN_STYLES_DIR}/fix_pour_ellipsoid.h")
set_property(GLOBAL APPEND PROPERTY COMPUTE "${ELLGRAN_STYLES_DIR}/compute_contact_ellipsoid_atom.h"
  "${ELLGRAN_STYLES_DIR}/compute_energy_ellipsoid.h"
  "${ELLGRAN_STYLES_DIR}/compute_timestep_ellipsoid.h")
set_property(GLOBAL APPEND PROPERTY COMMAND "${ELLGRAN_STYLES_DIR}/create_ellipsoids.h")
if(ELLGRAN_GPU)
  if(NOT PKG_KOKKOS)
    message(FATAL_ERROR "ELLGRAN_GPU needs PKG_KOKKOS")
  endif()
  if(NOT EXISTS "${ELLGRAN_INCLUDE_DIR}/ellgran_gpu.h")
    message(FATAL_ERROR "ELLGRAN_INCLUDE_DIR='${ELLGRAN_INCLUDE_DIR}' has no ellgran_gpu.h: "
                        "'cargo xtask install --prefix DIR --gpu' puts it there")
  endif()
  list(APPEND ELLGRAN_STYLE_SOURCES ${ELLGRAN_DEVICE_STYLE_SOURCES})
  set_property(GLOBAL APPEND PROPERTY PAIR "${ELLGRAN_STYLES_DIR}/pair_gran_ellipsoid_device.h")
  set_property(GLOBAL APPEND PROPERTY FIX "${ELLGRAN_STYLES_DIR}/fix_nve_ellipsoid_device.h"
    "${ELLGRAN_STYLES_DIR}/fix_wall_gran_ellipsoid_device.h")
elseif(PKG_KOKKOS)
  set_property(GLOBAL APPEND PROPERTY PAIR "${ELLGRAN_STYLES_DIR}/pair_gran_ellipsoid_kokkos.h")
  set_property(GLOBAL APPEND PROPERTY FIX "${ELLGRAN_STYLES_DIR}/fix_wall_gran_ellipsoid_kokkos.h"
    "${ELLGRAN_STYLES_DIR}/fix_nve_ellipsoid_kokkos.h")
endif()

# The target `lammps` exists only when LAMMPS' own CMakeLists.txt has been read.
function(ellgran_add_to_lammps)
  if(ELLGRAN_GPU AND NOT "CUDA" IN_LIST Kokkos_DEVICES AND NOT Kokkos_ENABLE_CUDA)
    message(FATAL_ERROR "ELLGRAN_GPU needs KOKKOS for CUDA (Kokkos_ENABLE_CUDA)")
  endif()
  target_sources(lammps PRIVATE ${ELLGRAN_STYLE_SOURCES})
  target_include_directories(lammps PRIVATE "${ELLGRAN_STYLES_DIR}" "${ELLGRAN_INCLUDE_DIR}")
  target_link_libraries(lammps PRIVATE "${ELLGRAN_LIBRARY}" pthread dl m)
endfunction()
cmake_language(DEFER DIRECTORY "${CMAKE_SOURCE_DIR}" CALL ellgran_add_to_lammps)
