// SPDX-License-Identifier: MIT OR Apache-2.0
// For tests of LAMMPS' styles for a GPU without one. Kokkos for the host has its arrays in the memory of the host; the stand-in for NVIDIA's
// driver takes addresses of its own memory alone. Each function here stands for the one of ellgran_gpu.h whose name follows `__wrap_`
// (the linker's option --wrap): it copies the arrays of the caller to the stand-in, calls the function, which is `__real_...`, and copies
// back what that has written. An array has its place there by its address on the host.

#include "ellgran_gpu.h"

#include "cuda.h"

#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>
#include <unordered_map>

namespace {

constexpr std::size_t VECTOR = 3, QUATERNION = 4;    // components
constexpr std::size_t LOAD = 6 * sizeof(double);

struct Place {
  CUdeviceptr address = 0;
  std::size_t bytes = 0;
};

std::unordered_map<const void *, Place> places;

[[noreturn]] void stop(const char *what, int result)
{
  std::fprintf(stderr, "memory of the stand-in: %s failed with result %d of the driver\n", what, result);
  std::abort();
}

void require(CUresult result, const char *what)
{
  if (result != CUDA_SUCCESS) stop(what, static_cast<int>(result));
}

/* A place as large as the array. One that the array has outgrown is given up and not freed: kernels may still know its address. */

template <class T> T *place_of(T *host, std::size_t bytes)
{
  if (!host) return nullptr;
  Place &place = places[host];
  if (bytes == 0) bytes = sizeof(double);
  if (place.bytes < bytes) {
    require(cuMemAlloc(&place.address, bytes), "cuMemAlloc");
    place.bytes = bytes;
  }
  return reinterpret_cast<T *>(place.address);
}

template <class T> T *copied(T *host, std::size_t bytes)
{
  T *const there = place_of(host, bytes);
  if (host && bytes > 0) require(cuMemcpyHtoD(reinterpret_cast<CUdeviceptr>(there), host, bytes), "cuMemcpyHtoD");
  return there;
}

void copy_back(void *host, std::size_t bytes, CUstream stream)
{
  if (!host || bytes == 0) return;
  const auto found = places.find(host);
  if (found == places.end()) stop("finding an array", -1);
  require(cuStreamSynchronize(stream), "cuStreamSynchronize");
  require(cuMemcpyDtoH(host, found->second.address, bytes), "cuMemcpyDtoH");
}

/* From the first component of the first vector to the last of the last one, with all that is between. */

std::size_t bytes_of(const EllgranGpuVectors &host, std::size_t count, std::size_t components)
{
  if (count == 0) return 0;
  return sizeof(double) * ((count - 1) * host.per_grain + (components - 1) * host.per_component + 1);
}

EllgranGpuVectors copied(const EllgranGpuVectors &host, std::size_t count, std::size_t components)
{
  EllgranGpuVectors there = host;
  there.first = copied(host.first, bytes_of(host, count, components));
  return there;
}

void copy_back(const EllgranGpuVectors &host, std::size_t count, std::size_t components, CUstream stream)
{
  copy_back(host.first, bytes_of(host, count, components), stream);
}

EllgranGpuGrains copied(const EllgranGpuGrains &host)
{
  EllgranGpuGrains there = host;
  const std::size_t count = host.count, named = host.owners ? host.owned_count : count;
  there.positions = copied(host.positions, count, VECTOR);
  there.velocities = copied(host.velocities, named, VECTOR);
  there.angular_momenta = copied(host.angular_momenta, named, VECTOR);
  there.velocity_changes = copied(host.velocity_changes, LOAD * named);
  there.masses = copied(host.masses, sizeof(double) * named);
  there.semi_axes = copied(host.semi_axes, host.body_count, VECTOR);
  there.quaternions = copied(host.quaternions, host.body_count, QUATERNION);
  there.owners = copied(host.owners, sizeof(int32_t) * count);
  there.body_places = copied(host.body_places, sizeof(int32_t) * named);
  there.types = copied(host.types, sizeof(int32_t) * count);
  there.identifiers = copied(host.identifiers, sizeof(int32_t) * count);
  return there;
}

EllgranGpuMotion copied(const EllgranGpuMotion &host)
{
  EllgranGpuMotion there = host;
  const std::size_t count = host.count;
  there.positions = copied(host.positions, count, VECTOR);
  there.velocities = copied(host.velocities, count, VECTOR);
  there.angular_momenta = copied(host.angular_momenta, count, VECTOR);
  there.quaternions = copied(host.quaternions, host.body_count, QUATERNION);
  there.semi_axes = copied(host.semi_axes, host.body_count, VECTOR);
  there.body_places = copied(host.body_places, sizeof(int32_t) * count);
  there.masses = copied(host.masses, sizeof(double) * count);
  there.forces = copied(host.forces, count, VECTOR);
  there.torques = copied(host.torques, count, VECTOR);
  there.velocity_changes = copied(host.velocity_changes, LOAD * count);
  there.loads_before = copied(host.loads_before, LOAD * count);
  return there;
}

/* What a step of motion writes. */

void copy_back(const EllgranGpuMotion &host, CUstream stream)
{
  const std::size_t count = host.count;
  copy_back(host.positions, count, VECTOR, stream);
  copy_back(host.velocities, count, VECTOR, stream);
  copy_back(host.angular_momenta, count, VECTOR, stream);
  copy_back(host.quaternions, host.body_count, QUATERNION, stream);
  copy_back(host.velocity_changes, LOAD * count, stream);
  copy_back(host.loads_before, LOAD * count, stream);
}

EllgranGpuLoads copied(const EllgranGpuLoads &host, std::size_t count)
{
  EllgranGpuLoads there = host;
  there.forces = copied(host.forces, count, VECTOR);
  there.torques = copied(host.torques, count, VECTOR);
  return there;
}

void copy_back(const EllgranGpuLoads &host, std::size_t count, CUstream stream)
{
  copy_back(host.forces, count, VECTOR, stream);
  copy_back(host.torques, count, VECTOR, stream);
}

/* The file of the stand-in that this one is linked with. */

void name_the_driver()
{
  Dl_info about{};
  if (!dladdr(reinterpret_cast<void *>(&cuInit), &about) || !about.dli_fname) stop("finding its file", -1);
  setenv("ELLGRAN_GPU_DRIVER", about.dli_fname, 1);
}

}    // namespace

#define REAL(name) decltype(ellgran_gpu_##name) __real_ellgran_gpu_##name

extern "C" {

REAL(open_current);
REAL(new_list);
REAL(prepare);
REAL(check);
REAL(write_histories);
REAL(write_wall_histories);
REAL(tally_pairs);
REAL(compute_pairs);
REAL(compute_plane);
REAL(compute_wall);
REAL(start_step);
REAL(finish_step);

/* KOKKOS for CUDA has a context by then. */

int32_t __wrap_ellgran_gpu_open_current(EllgranGpu **gpu)
{
  name_the_driver();
  require(cuInit(0), "cuInit");
  CUdevice device = 0;
  require(cuDeviceGet(&device, 0), "cuDeviceGet");
  CUcontext context = nullptr;
  require(cuDevicePrimaryCtxRetain(&context, device), "cuDevicePrimaryCtxRetain");
  require(cuCtxPushCurrent(context), "cuCtxPushCurrent");
  return __real_ellgran_gpu_open_current(gpu);
}

int32_t __wrap_ellgran_gpu_new_list(EllgranGpuScene *scene, const EllgranGpuGrains *grains, const EllgranGpuList *list, void *stream)
{
  const EllgranGpuGrains there = copied(*grains);
  EllgranGpuList rows = *list;
  const std::size_t owned = grains->owned_count;
  const std::size_t entries = list->starts[owned];
  rows.starts = copied(list->starts, sizeof(uint32_t) * (owned + 1));
  rows.neighbours = copied(list->neighbours, sizeof(uint32_t) * entries);
  return __real_ellgran_gpu_new_list(scene, &there, &rows, stream);
}

int32_t __wrap_ellgran_gpu_prepare(EllgranGpuScene *scene, const EllgranGpuGrains *grains, void *stream)
{
  const EllgranGpuGrains there = copied(*grains);
  return __real_ellgran_gpu_prepare(scene, &there, stream);
}

int32_t __wrap_ellgran_gpu_check(EllgranGpuScene *scene, const EllgranGpuGrains *grains, void *stream)
{
  const EllgranGpuGrains there = copied(*grains);
  return __real_ellgran_gpu_check(scene, &there, stream);
}

int32_t __wrap_ellgran_gpu_write_histories(EllgranGpuScene *scene, const EllgranGpuGrains *grains, int32_t plane, const uint32_t *touching,
                                           const double *histories, void *stream)
{
  const EllgranGpuGrains there = copied(*grains);
  return __real_ellgran_gpu_write_histories(scene, &there, plane, touching, histories, stream);
}

int32_t __wrap_ellgran_gpu_write_wall_histories(EllgranGpuScene *scene, const EllgranGpuGrains *grains, int32_t number, const EllgranWall *wall,
                                                const EllgranLaws *laws, int32_t part, const double *histories, void *stream)
{
  const EllgranGpuGrains there = copied(*grains);
  return __real_ellgran_gpu_write_wall_histories(scene, &there, number, wall, laws, part, histories, stream);
}

int32_t __wrap_ellgran_gpu_tally_pairs(EllgranGpuScene *scene, const EllgranGpuGrains *grains, const EllgranStep *step, EllgranGpuTallies *tallies,
                                       void *stream)
{
  const EllgranGpuGrains there = copied(*grains);
  return __real_ellgran_gpu_tally_pairs(scene, &there, step, tallies, stream);
}

int32_t __wrap_ellgran_gpu_compute_pairs(EllgranGpuScene *scene, const EllgranGpuGrains *grains, const EllgranStep *step,
                                         const EllgranGpuLoads *loads, void *stream)
{
  const EllgranGpuGrains there = copied(*grains);
  const EllgranGpuLoads added_to = copied(*loads, grains->owned_count);
  const int32_t status = __real_ellgran_gpu_compute_pairs(scene, &there, step, &added_to, stream);
  copy_back(*loads, grains->owned_count, static_cast<CUstream>(stream));
  return status;
}

int32_t __wrap_ellgran_gpu_compute_plane(EllgranGpuScene *scene, const EllgranGpuGrains *grains, int32_t plane, const EllgranPlane *at,
                                         int32_t wall_type, const EllgranStep *step, const EllgranGpuLoads *loads, void *stream)
{
  const EllgranGpuGrains there = copied(*grains);
  const EllgranGpuLoads added_to = copied(*loads, grains->owned_count);
  const int32_t status = __real_ellgran_gpu_compute_plane(scene, &there, plane, at, wall_type, step, &added_to, stream);
  copy_back(*loads, grains->owned_count, static_cast<CUstream>(stream));
  return status;
}

int32_t __wrap_ellgran_gpu_compute_wall(EllgranGpuScene *scene, const EllgranGpuGrains *grains, int32_t wall, const EllgranWallMotion *motion,
                                        int32_t wall_type, const EllgranStep *step, const EllgranGpuLoads *loads, void *stream)
{
  const EllgranGpuGrains there = copied(*grains);
  const EllgranGpuLoads added_to = copied(*loads, grains->owned_count);
  const int32_t status = __real_ellgran_gpu_compute_wall(scene, &there, wall, motion, wall_type, step, &added_to, stream);
  copy_back(*loads, grains->owned_count, static_cast<CUstream>(stream));
  return status;
}

int32_t __wrap_ellgran_gpu_start_step(EllgranGpuScene *scene, const EllgranGpuMotion *motion, double time_step, void *stream)
{
  const EllgranGpuMotion there = copied(*motion);
  const int32_t status = __real_ellgran_gpu_start_step(scene, &there, time_step, stream);
  copy_back(*motion, static_cast<CUstream>(stream));
  return status;
}

int32_t __wrap_ellgran_gpu_finish_step(EllgranGpuScene *scene, const EllgranGpuMotion *motion, double time_step, void *stream)
{
  const EllgranGpuMotion there = copied(*motion);
  const int32_t status = __real_ellgran_gpu_finish_step(scene, &there, time_step, stream);
  copy_back(*motion, static_cast<CUstream>(stream));
  return status;
}

}    // extern "C"
