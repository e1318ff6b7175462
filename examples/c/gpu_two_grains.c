/* SPDX-License-Identifier: MIT OR Apache-2.0 */
/*
 * The collision of two_grains.c on a GPU of NVIDIA: the grains stay in its memory, and steps are started on a stream. C99. SI units.
 *
 *   cc -std=c99 examples/c/gpu_two_grains.c -Iinclude target/release/libellgran_gpu.a -lcuda -lm -lpthread -ldl -o gpu_two_grains
 *
 * cuda.h and -lcuda, of CUDA's toolkit, are for the memory and the stream alone, which an engine has already.
 *
 * Prints the velocities after, which are those of two_grains.c:
 *
 * velocities after: (-0.1359, -0.3020) and (-0.1141, -0.1980) m/s
 */
#include <ellgran_gpu.h>

#include <cuda.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define DENSITY 2500.0
#define TIME_STEP 1e-6
#define STEPS 1500

static void check(int32_t status)
{
  if (status != ELLGRAN_SUCCESS) {
    fprintf(stderr, "ellgran: error %d: %s\n", (int) status, ellgran_last_error());
    exit(EXIT_FAILURE);
  }
}

static void check_driver(CUresult result, const char *what)
{
  if (result != CUDA_SUCCESS) {
    fprintf(stderr, "%s: error %d of the driver\n", what, (int) result);
    exit(EXIT_FAILURE);
  }
}

/* An array in the memory of the GPU, with these numbers. */
static void *on_gpu(const void *numbers, size_t bytes)
{
  CUdeviceptr there = 0;
  check_driver(cuMemAlloc(&there, bytes), "cuMemAlloc");
  check_driver(cuMemcpyHtoD(there, numbers, bytes), "cuMemcpyHtoD");
  return (void *) (uintptr_t) there;
}

int main(void)
{
  /*                                      E      nu    eta1   eta2                         mu */
  static const char *const words[] = {"nfd", "1e7", "0.3", "400", "400", "tangential", "tfd", "0.5"};
  const double pi = 3.14159265358979323846;
  const double degree = pi / 180.0;
  const double mass = DENSITY * 4.0 / 3.0 * pi * 0.005 * 0.005 * 0.01;
  const double positions[2][3] = {{0.0, 0.0, -0.006}, {0.003, 0.0, 0.0061}};
  const double velocities[2][3] = {{0.0, 0.0, 0.0}, {-0.25, 0.0, -0.5}};
  const double quaternions[2][4] = {{cos(30.0 * degree), 0.0, sin(30.0 * degree), 0.0},
                                    {cos(-37.5 * degree), 0.0, sin(-37.5 * degree), 0.0}};
  const double semi_axes[2][3] = {{0.005, 0.005, 0.01}, {0.005, 0.005, 0.01}};
  const double masses[2] = {mass, mass};
  const double zeros[6] = {0.0};
  const int32_t types[2] = {1, 1}, identifiers[2] = {1, 2};
  /* Each is the other's neighbour. */
  const uint32_t starts[3] = {0, 1, 2}, neighbours[2] = {1, 0};

  EllgranLawParameters parameters = ELLGRAN_INIT(EllgranLawParameters);
  EllgranLaws *laws = NULL;
  const uint8_t is_set = 1;
  EllgranStep step = ELLGRAN_INIT(EllgranStep);
  EllgranGpu *gpu = NULL;
  EllgranGpuScene *scene = NULL;
  EllgranGpuGrains grains = ELLGRAN_INIT(EllgranGpuGrains);
  EllgranGpuMotion motion = ELLGRAN_INIT(EllgranGpuMotion);
  EllgranGpuList list = ELLGRAN_INIT(EllgranGpuList);
  EllgranGpuLoads loads = ELLGRAN_INIT(EllgranGpuLoads);
  CUdevice device;
  CUcontext context;
  CUstream stream;
  double after[2][3];
  int count;

  /* What an engine has: a context, a stream, its arrays. */
  check_driver(cuInit(0), "cuInit");
  check_driver(cuDeviceGet(&device, 0), "cuDeviceGet");
  check_driver(cuDevicePrimaryCtxRetain(&context, device), "cuDevicePrimaryCtxRetain");
  check_driver(cuCtxPushCurrent(context), "cuCtxPushCurrent");
  check_driver(cuStreamCreate(&stream, 0), "cuStreamCreate");
  motion.positions.first = on_gpu(positions, sizeof positions);
  motion.velocities.first = on_gpu(velocities, sizeof velocities);
  motion.angular_momenta.first = on_gpu(zeros, 6 * sizeof *zeros);
  motion.quaternions.first = on_gpu(quaternions, sizeof quaternions);
  motion.semi_axes.first = on_gpu(semi_axes, sizeof semi_axes);
  motion.masses = on_gpu(masses, sizeof masses);
  motion.forces.first = on_gpu(zeros, 6 * sizeof *zeros);
  motion.torques.first = on_gpu(zeros, 6 * sizeof *zeros);
  motion.count = 2;
  loads.forces = motion.forces;
  loads.torques = motion.torques;
  grains.owned_count = grains.count = 2;
  grains.positions = motion.positions;
  grains.velocities = motion.velocities;
  grains.angular_momenta = motion.angular_momenta;
  grains.quaternions = motion.quaternions;
  grains.semi_axes = motion.semi_axes;
  grains.masses = motion.masses;
  grains.types = on_gpu(types, sizeof types);
  grains.identifiers = on_gpu(identifiers, sizeof identifiers);
  list.starts = on_gpu(starts, sizeof starts);
  list.neighbours = on_gpu(neighbours, sizeof neighbours);
  list.margin = 0.0005;

  /* The laws, as on the host; the GPU of this thread's context; the scene. */
  check(ellgran_law_parameters_parse(sizeof words / sizeof *words, words, NULL, &parameters));
  check(ellgran_laws_new(1, &parameters, &is_set, 0, &laws));
  check(ellgran_gpu_open_current(&gpu));
  check(ellgran_gpu_scene_new(gpu, laws, ELLGRAN_GPU_ANY_SHAPES, &scene));
  ellgran_laws_free(laws);

  /* Whenever the engine has a new neighbour list. */
  check(ellgran_gpu_new_list(scene, &grains, &list, stream));

  step.time_step = TIME_STEP;
  step.advance_history = 1;
  for (count = 1; count <= STEPS; ++count) {
    check(ellgran_gpu_start_step(scene, &motion, TIME_STEP, stream));
    check(ellgran_gpu_prepare(scene, &grains, stream));
    check(ellgran_gpu_compute_pairs(scene, &grains, &step, &loads, stream));
    check(ellgran_gpu_finish_step(scene, &motion, TIME_STEP, stream));
    if (count % 100 == 0) check(ellgran_gpu_check(scene, &grains, stream));
  }

  check_driver(cuStreamSynchronize(stream), "cuStreamSynchronize");
  check_driver(cuMemcpyDtoH(after, (CUdeviceptr) (uintptr_t) motion.velocities.first, sizeof after), "cuMemcpyDtoH");
  printf("velocities after: (%.4f, %.4f) and (%.4f, %.4f) m/s\n", after[0][0], after[0][2], after[1][0], after[1][2]);
  ellgran_gpu_scene_free(scene);
  ellgran_gpu_free(gpu);
  return EXIT_SUCCESS;
}
