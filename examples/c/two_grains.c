/* SPDX-License-Identifier: MIT OR Apache-2.0 */
/*
 * Two viscoelastic ellipsoids of aspect ratio 2 in an oblique collision with friction: the contact law alone, one
 * contact over a small time loop. C99. SI units.
 *
 *   cc -std=c99 two_grains.c $(pkg-config --cflags --libs ellgran) -o two_grains && ./two_grains
 *
 * Prints a line every 100 steps while the grains touch - time, penetration, normal force, tangential force, energy held
 * by the deformation, energy dissipated, and the sum of these energies and of the motion, which must stay - then the
 * velocities after. Fails if that sum strays by more than a thousandth, or momentum by more than rounding.
 *
 *    time/us  delta/um     F_n/N     F_t/N  elastic/uJ  dissipated/uJ   total/uJ
 *        200     48.69     0.259     0.081       3.157          4.354     409.10
 *        300     96.53     0.550     0.172      17.501         11.787     409.12
 *        400    137.93     0.834     0.267      42.983         19.175     409.13
 *        500    169.66     1.056     0.353      72.902         24.558     409.13
 *        600    189.23     1.173     0.416      97.348         27.247     409.13
 *        700    195.39     1.169     0.446     107.998         27.967     409.13
 *        800    188.32     1.052     0.434     101.675         28.568     409.13
 *        900    169.49     0.850     0.384      81.718         30.573     409.13
 *       1000    141.31     0.605     0.302      55.215         34.957     409.14
 *       1100    106.65     0.357     0.178      26.253         45.289     409.14
 *       1200     68.27     0.146     0.073       8.017         52.701     409.14
 *       1300     28.48     0.010     0.005       0.772         56.763     409.14
 * velocities after: (-0.1359, -0.3020) and (-0.1141, -0.1980) m/s, spins 28.86 and -58.62 rad/s
 * dissipated: 14.1 % of the energy
 */
#include <ellgran.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define DENSITY 2500.0
#define TIME_STEP 1e-6
#define STEPS 1500

typedef struct Grain {
  EllgranBody body;
  double inertia[3];           /* principal moments, along the body axes */
  double angular_momentum[3];  /* world frame */
} Grain;

static void check(int32_t status)
{
  if (status != ELLGRAN_SUCCESS) {
    fprintf(stderr, "ellgran: error %d: %s\n", (int) status, ellgran_last_error());
    exit(EXIT_FAILURE);
  }
}

static double dot(const double *a, const double *b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The body's axes in the world frame: the columns of the rotation. */
static void body_axes(const double *q, double axes[3][3])
{
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  axes[0][0] = 1.0 - 2.0 * (y * y + z * z);
  axes[0][1] = 2.0 * (x * y + w * z);
  axes[0][2] = 2.0 * (x * z - w * y);
  axes[1][0] = 2.0 * (x * y - w * z);
  axes[1][1] = 1.0 - 2.0 * (x * x + z * z);
  axes[1][2] = 2.0 * (y * z + w * x);
  axes[2][0] = 2.0 * (x * z + w * y);
  axes[2][1] = 2.0 * (y * z - w * x);
  axes[2][2] = 1.0 - 2.0 * (x * x + y * y);
}

static void angular_velocity(const Grain *grain, const double *q, double omega[3])
{
  double axes[3][3];
  int k, m;
  body_axes(q, axes);
  omega[0] = omega[1] = omega[2] = 0.0;
  for (k = 0; k < 3; ++k) {
    const double along = dot(axes[k], grain->angular_momentum) / grain->inertia[k];
    for (m = 0; m < 3; ++m) omega[m] += along * axes[k][m];
  }
}

/* Turns q by the angular velocity omega over a time. */
static void turn(const double *q, const double *omega, double time, double *turned)
{
  const double speed = sqrt(dot(omega, omega));
  const double s = speed > 0.0 ? sin(0.5 * speed * time) / speed : 0.0;
  const double w = cos(0.5 * speed * time), x = s * omega[0], y = s * omega[1], z = s * omega[2];
  turned[0] = w * q[0] - x * q[1] - y * q[2] - z * q[3];
  turned[1] = w * q[1] + x * q[0] + y * q[3] - z * q[2];
  turned[2] = w * q[2] - x * q[3] + y * q[0] + z * q[1];
  turned[3] = w * q[3] + x * q[2] - y * q[1] + z * q[0];
}

static Grain new_grain(double x, double z, double tilt, double velocity_x, double velocity_z)
{
  const double pi = 3.14159265358979323846;
  Grain grain = {ELLGRAN_INIT(EllgranBody), {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  double *a = grain.body.semi_axes;
  a[0] = a[1] = 0.005;
  a[2] = 0.01;
  grain.body.particle_type = 1;
  grain.body.position[0] = x;
  grain.body.position[2] = z;
  grain.body.quaternion[0] = cos(0.5 * tilt * pi / 180.0);
  grain.body.quaternion[2] = sin(0.5 * tilt * pi / 180.0);
  grain.body.velocity[0] = velocity_x;
  grain.body.velocity[2] = velocity_z;
  grain.body.mass = DENSITY * 4.0 / 3.0 * pi * a[0] * a[1] * a[2];
  grain.inertia[0] = 0.2 * grain.body.mass * (a[1] * a[1] + a[2] * a[2]);
  grain.inertia[1] = 0.2 * grain.body.mass * (a[0] * a[0] + a[2] * a[2]);
  grain.inertia[2] = 0.2 * grain.body.mass * (a[0] * a[0] + a[1] * a[1]);
  return grain;
}

/* Velocity Verlet: the first half of a step. The force is then that at the new place, with the velocities of half way. */
static void start_step(Grain *grain, const double *force, const double *torque)
{
  double omega[3], half_way[4], turned[4];
  int k;
  for (k = 0; k < 3; ++k) {
    grain->body.velocity[k] += 0.5 * TIME_STEP / grain->body.mass * force[k];
    grain->body.position[k] += TIME_STEP * grain->body.velocity[k];
    grain->angular_momentum[k] += 0.5 * TIME_STEP * torque[k];
  }
  angular_velocity(grain, grain->body.quaternion, omega);
  turn(grain->body.quaternion, omega, 0.5 * TIME_STEP, half_way);
  angular_velocity(grain, half_way, omega);
  turn(grain->body.quaternion, omega, TIME_STEP, turned);
  for (k = 0; k < 4; ++k) grain->body.quaternion[k] = turned[k];
  angular_velocity(grain, turned, grain->body.angular_velocity);
}

static void finish_step(Grain *grain, const double *force, const double *torque)
{
  int k;
  for (k = 0; k < 3; ++k) {
    grain->body.velocity[k] += 0.5 * TIME_STEP / grain->body.mass * force[k];
    grain->angular_momentum[k] += 0.5 * TIME_STEP * torque[k];
  }
  angular_velocity(grain, grain->body.quaternion, grain->body.angular_velocity);
}

static double kinetic_energy(const Grain *grain)
{
  return 0.5 * grain->body.mass * dot(grain->body.velocity, grain->body.velocity) +
         0.5 * dot(grain->body.angular_velocity, grain->angular_momentum);
}

int main(void)
{
  /*                                      E      nu    eta1   eta2                         mu */
  static const char *const words[] = {"nfd", "1e7", "0.3", "400", "400", "tangential", "tfd", "0.5"};
  EllgranLawParameters parameters = ELLGRAN_INIT(EllgranLawParameters);
  EllgranLaws *laws = NULL;
  const uint8_t is_set = 1;
  EllgranStep step = ELLGRAN_INIT(EllgranStep);
  EllgranContactGeometry geometry = ELLGRAN_INIT(EllgranContactGeometry);
  EllgranContactForce contact = ELLGRAN_INIT(EllgranContactForce);
  Grain i = new_grain(0.0, -0.006, 60.0, 0.0, 0.0);
  Grain j = new_grain(0.003, 0.0061, -75.0, -0.25, -0.5);
  double force_i[3] = {0.0, 0.0, 0.0}, force_j[3] = {0.0, 0.0, 0.0};
  double torque_i[3] = {0.0, 0.0, 0.0}, torque_j[3] = {0.0, 0.0, 0.0};
  int32_t touching = 0, length;
  double *history;
  double work = 0.0, before, after, momentum, strayed;
  int count, k;

  if (ellgran_abi_version() != ELLGRAN_ABI_VERSION) {
    fprintf(stderr, "ellgran.h and libellgran.a are of different versions\n");
    return EXIT_FAILURE;
  }
  step.time_step = TIME_STEP;
  step.advance_history = 1;
  i.body.identifier = 1;
  j.body.identifier = 2;
  check(ellgran_law_parameters_parse(sizeof words / sizeof *words, words, NULL, &parameters));
  check(ellgran_laws_new(1, &parameters, &is_set, 0, &laws));
  length = ellgran_laws_history_length(laws);
  history = calloc((size_t) length + 1, sizeof *history);
  if (history == NULL) return EXIT_FAILURE;

  before = kinetic_energy(&i) + kinetic_energy(&j);
  printf("   time/us  delta/um     F_n/N     F_t/N  elastic/uJ  dissipated/uJ   total/uJ\n");
  for (count = 1; count <= STEPS; ++count) {
    start_step(&i, force_i, torque_i);
    start_step(&j, force_j, torque_j);
    check(ellgran_contact(laws, &i.body, &j.body, &step, &touching, history, &geometry, &contact));
    for (k = 0; k < 3; ++k) {
      force_j[k] = contact.force[k];
      force_i[k] = -contact.force[k];
      torque_i[k] = contact.torque_i[k];
      torque_j[k] = contact.torque_j[k];
    }
    finish_step(&i, force_i, torque_i);
    finish_step(&j, force_j, torque_j);
    work += TIME_STEP * (contact.viscous_power + contact.tangential_power);
    if (geometry.touching && count % 100 == 0) {
      const double elastic = contact.elastic_energy + contact.tangential_energy;
      const double dissipated = work - contact.tangential_energy;
      const double total = kinetic_energy(&i) + kinetic_energy(&j) + elastic + dissipated;
      printf("%10.0f %9.2f %9.3f %9.3f %11.3f %14.3f %10.2f\n", 1e6 * count * TIME_STEP, 1e6 * geometry.penetration,
             contact.normal_force, sqrt(dot(contact.tangential_force, contact.tangential_force)), 1e6 * elastic,
             1e6 * dissipated, 1e6 * total);
    }
  }
  printf("velocities after: (%.4f, %.4f) and (%.4f, %.4f) m/s, spins %.2f and %.2f rad/s\n", i.body.velocity[0],
         i.body.velocity[2], j.body.velocity[0], j.body.velocity[2], i.body.angular_velocity[1],
         j.body.angular_velocity[1]);
  printf("dissipated: %.1f %% of the energy\n", 100.0 * work / before);

  after = kinetic_energy(&i) + kinetic_energy(&j) + work;
  strayed = fabs(after - before) / before;
  momentum = fabs(i.body.velocity[0] + j.body.velocity[0] + 0.25) + fabs(i.body.velocity[2] + j.body.velocity[2] + 0.5);
  free(history);
  ellgran_laws_free(laws);
  if (geometry.touching || strayed > 1e-3 || momentum > 1e-12) {
    fprintf(stderr, "wrong: energy strayed by %g of itself, velocity of the centre of mass by %g m/s\n", strayed,
            momentum);
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
