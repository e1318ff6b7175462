/* SPDX-License-Identifier: MIT OR Apache-2.0 */
/*
 * Plays a scene through the C interface of whichever revision it is compiled against. C99 and POSIX.
 *
 *   player SCENE trajectory STEPS > numbers
 *     Leapfrog from the first frame on. Writes three arrays, each a 64-bit count and as many doubles: positions, velocities,
 *     angular velocities and quaternions; forces and torques of the last step and
 *     summed over all steps, and the sums of the last step; what is remembered of the contacts.
 *   player SCENE time
 *     Goes through the frames. Prints the number of contacts, then reads a number of steps from each line and prints the
 *     processor time of the calls in them, ns.
 *
 * scene.rs writes the scenes. The motion is computed here, so that it is the same in each revision. WITHOUT_WALLS is defined
 * where the interface has no ellgran_wall_add_shape, PARTICLES_HAVE_UNCHANGED where EllgranParticles have such a field; fields with other names are renamed on the command line.
 */
#define _POSIX_C_SOURCE 199309L

#include <ellgran.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define LONGEST_LINE 4096
#define MOST_WORDS 64
#define WARM_UP_STEPS 32

typedef struct Frame {
  double *positions, *velocities, *spins, *quaternions;
} Frame;

typedef struct Scene {
  size_t count, frame_count, pair_count;
  Frame *frames;
  double *semi_axes, *masses, *forces, *torques, *momenta, *impulses;
  int32_t *types;
  EllgranLaws *laws;
  EllgranWorkspace *workspace;
  /* the list */
  int32_t *central, *row_lengths, *neighbours, *touching, **row_touching;
  const int32_t **rows;
  double *histories, **row_histories;
  size_t history_length;
  /* the wall */
  int32_t wall_type;
  double *wall_histories;
  size_t wall_histories_length;
#ifndef WITHOUT_WALLS
  EllgranWall *wall;
#endif
  double wall_contacts;
  EllgranTallies tallies;
  int tallied, cold, single;
  EllgranStep step;
  double pull;
  int64_t steps_done;
} Scene;

static void stop(const char *why)
{
  fprintf(stderr, "player: %s\n", why);
  exit(EXIT_FAILURE);
}

static void check(int32_t status)
{
  if (status != ELLGRAN_SUCCESS) stop(ellgran_last_error());
}

static void *zeros(size_t count, size_t size)
{
  void *memory = calloc(count > 0 ? count : 1, size);
  if (memory == NULL) stop("no memory");
  return memory;
}

static char *word(FILE *file)
{
  static char text[LONGEST_LINE];
  if (fscanf(file, "%4095s", text) != 1) stop("the scene ends early");
  return text;
}

static void expect(FILE *file, const char *name)
{
  if (strcmp(word(file), name) != 0) {
    fprintf(stderr, "player: '%s' is due in the scene\n", name);
    exit(EXIT_FAILURE);
  }
}

static double number(FILE *file)
{
  char *text = word(file), *end;
  const double value = strtod(text, &end);
  if (*end != '\0') stop("a number is due in the scene");
  return value;
}

static double named(FILE *file, const char *name)
{
  expect(file, name);
  return number(file);
}

static void numbers(FILE *file, double *values, size_t count)
{
  size_t k;
  for (k = 0; k < count; ++k) values[k] = number(file);
}

/* `law` and the words of a deck, to the end of the line. */
static EllgranLawParameters law(FILE *file)
{
  char line[LONGEST_LINE];
  const char *words[MOST_WORDS];
  size_t count = 0, read = 0;
  EllgranLawParameters parameters = ELLGRAN_INIT(EllgranLawParameters);
  char *next;
  expect(file, "law");
  if (fgets(line, sizeof line, file) == NULL) stop("the scene ends early");
  for (next = strtok(line, " \n"); next != NULL && count < MOST_WORDS; next = strtok(NULL, " \n")) {
    words[count++] = next;
  }
  check(ellgran_law_parameters_parse(count, words, &read, &parameters));
  if (read != count) stop("a word is no word of a law");
  return parameters;
}

static void read_laws(Scene *scene, FILE *file)
{
  const int32_t types = (int32_t) named(file, "types");
  const size_t entries = (size_t) types * (size_t) types;
  EllgranLawParameters *parameters = zeros(entries, sizeof *parameters);
  uint8_t *is_set = zeros(entries, 1);
  int32_t k;
  uint32_t options;
  parameters[0].size = sizeof *parameters;
  for (k = 0; k < types; ++k) {
    parameters[k * (types + 1)] = law(file);
    is_set[k * (types + 1)] = 1;
  }
  options = named(file, "normals_are_kept") != 0.0 ? 0 : ELLGRAN_OPTION_NO_WARM_START;
  check(ellgran_laws_new(types, parameters, is_set, options, &scene->laws));
  free(parameters);
  free(is_set);
}

/* Shapes, and the corners of triangles. */
static void read_wall(Scene *scene, FILE *file)
{
  size_t shapes, triangles, k;
  scene->wall_type = (int32_t) named(file, "wall_type");
  shapes = (size_t) named(file, "shapes");
#ifdef WITHOUT_WALLS
  if (scene->wall_type > 0) stop("this revision has no walls of shapes");
  for (k = 0; k < shapes; ++k) word(file);
  triangles = (size_t) named(file, "triangles");
  for (k = 0; k < triangles; ++k) word(file);
#else
  check(ellgran_wall_new(&scene->wall));
  for (k = 0; k < shapes; ++k) {
    EllgranWallShape shape = ELLGRAN_INIT(EllgranWallShape);
    char name[64];
    strncpy(name, word(file), sizeof name - 1);
    name[sizeof name - 1] = '\0';
    shape.name = name;
    numbers(file, shape.point, 3);
    numbers(file, shape.axis, 3);
    numbers(file, shape.radii, 2);
    numbers(file, shape.bounds, 2);
    shape.side = ELLGRAN_SIDE_INSIDE;
    check(ellgran_wall_add_shape(scene->wall, &shape));
  }
  triangles = (size_t) named(file, "triangles");
  if (triangles > 0) {
    double *corners = zeros(9 * triangles, sizeof *corners);
    numbers(file, corners, 9 * triangles);
    check(ellgran_wall_add_triangles(scene->wall, triangles, corners));
    free(corners);
  }
#endif
}

static void read_grains(Scene *scene, FILE *file)
{
  size_t k, f;
  scene->count = (size_t) named(file, "grains");
  scene->types = zeros(scene->count, sizeof *scene->types);
  scene->semi_axes = zeros(3 * scene->count, sizeof(double));
  scene->masses = zeros(scene->count, sizeof(double));
  scene->forces = zeros(3 * scene->count, sizeof(double));
  scene->torques = zeros(3 * scene->count, sizeof(double));
  scene->momenta = zeros(3 * scene->count, sizeof(double));
  scene->impulses = zeros(6 * scene->count, sizeof(double));
  for (k = 0; k < scene->count; ++k) {
    scene->types[k] = (int32_t) number(file);
    numbers(file, scene->semi_axes + 3 * k, 3);
    scene->masses[k] = number(file);
  }
  scene->frame_count = (size_t) named(file, "frames");
  scene->frames = zeros(scene->frame_count, sizeof *scene->frames);
  for (f = 0; f < scene->frame_count; ++f) {
    Frame *frame = &scene->frames[f];
    frame->positions = zeros(3 * scene->count, sizeof(double));
    frame->velocities = zeros(3 * scene->count, sizeof(double));
    frame->spins = zeros(3 * scene->count, sizeof(double));
    frame->quaternions = zeros(4 * scene->count, sizeof(double));
    for (k = 0; k < scene->count; ++k) {
      numbers(file, frame->positions + 3 * k, 3);
      numbers(file, frame->velocities + 3 * k, 3);
      numbers(file, frame->spins + 3 * k, 3);
      numbers(file, frame->quaternions + 4 * k, 4);
    }
  }
}

/* Half a neighbour list: a row for each grain. */
static void read_list(Scene *scene, FILE *file)
{
  const size_t count = scene->count;
  size_t i, k, at = 0;
  scene->pair_count = (size_t) named(file, "pairs");
  scene->history_length = (size_t) ellgran_laws_history_length(scene->laws);
  scene->central = zeros(count, sizeof(int32_t));
  scene->row_lengths = zeros(count, sizeof(int32_t));
  scene->neighbours = zeros(scene->pair_count, sizeof(int32_t));
  scene->touching = zeros(scene->pair_count, sizeof(int32_t));
  scene->histories = zeros(scene->pair_count * scene->history_length, sizeof(double));
  scene->rows = zeros(count, sizeof *scene->rows);
  scene->row_touching = zeros(count, sizeof *scene->row_touching);
  scene->row_histories = zeros(count, sizeof *scene->row_histories);
  for (i = 0; i < count; ++i) {
    scene->central[i] = (int32_t) i;
    scene->row_lengths[i] = (int32_t) number(file);
    scene->rows[i] = scene->neighbours + at;
    scene->row_touching[i] = scene->touching + at;
    scene->row_histories[i] = scene->histories + at * scene->history_length;
    for (k = 0; k < (size_t) scene->row_lengths[i]; ++k) {
      if (at == scene->pair_count) stop("more pairs than the scene says");
      scene->neighbours[at++] = (int32_t) number(file);
    }
  }
}

static void read_scene(Scene *scene, const char *path)
{
  FILE *file = fopen(path, "r");
  if (file == NULL) stop("the scene cannot be read");
  memset(scene, 0, sizeof *scene);
  read_laws(scene, file);
  read_wall(scene, file);
  read_grains(scene, file);
  read_list(scene, file);
  scene->step = ELLGRAN_INIT(EllgranStep);
  scene->step.time_step = named(file, "time_step");
  scene->step.advance_history = 1;
  scene->pull = named(file, "pull");
  scene->tallied = named(file, "tallied") != 0.0;
  scene->cold = named(file, "cold") != 0.0;
  scene->single = named(file, "single") != 0.0;
  fclose(file);
  check(ellgran_workspace_new(&scene->workspace));
  scene->tallies = ELLGRAN_INIT(EllgranTallies);
  if (scene->tallied) {
    scene->tallies.particle_energies = zeros(scene->count, sizeof(double));
    scene->tallies.particle_virials = zeros(6 * scene->count, sizeof(double));
  }
#ifndef WITHOUT_WALLS
  if (scene->wall_type > 0) {
    scene->wall_histories_length =
        scene->count * ellgran_wall_histories_length(scene->wall, scene->laws);
    scene->wall_histories = zeros(scene->wall_histories_length, sizeof(double));
  }
#endif
}

/* One call for the pairs, one for the wall; NULL: without sums. */
static void compute(Scene *scene, const Frame *frame, int keep_history, EllgranTallies *tallies)
{
  EllgranParticles particles = ELLGRAN_INIT(EllgranParticles);
  particles.owned_count = particles.count = scene->count;
  particles.positions = frame->positions;
  particles.velocities = frame->velocities;
  particles.angular_velocities = frame->spins;
  particles.masses = scene->masses;
  particles.types = scene->types;
  particles.semi_axes = scene->semi_axes;
  particles.semi_axes_stride = 3 * sizeof(double);
  particles.quaternions = frame->quaternions;
  particles.quaternions_stride = 4 * sizeof(double);
  particles.identifier_bytes = 4;
  particles.forces = scene->forces;
  particles.torques = scene->torques;
  if (scene->pair_count > 0) {
    EllgranNeighbourList list = ELLGRAN_INIT(EllgranNeighbourList);
    list.count = scene->count;
    list.central = scene->central;
    list.neighbour_counts = scene->row_lengths;
    list.neighbours = scene->rows;
    list.index_mask = -1;
    list.newton = 1;
    list.unchanged = scene->steps_done > 0 && !scene->cold;
    list.keep_history = keep_history;
    list.touching = scene->row_touching;
    list.history = scene->row_histories;
    check(ellgran_compute_pairs(scene->laws, scene->workspace, &particles, &list, &scene->step, tallies));
  }
#ifndef WITHOUT_WALLS
#ifdef PARTICLES_HAVE_UNCHANGED
  particles.unchanged = scene->steps_done > 0;
#endif
  if (scene->wall_type > 0) {
    EllgranWallLoad load = ELLGRAN_INIT(EllgranWallLoad);
    check(ellgran_compute_wall(scene->laws, scene->workspace, scene->wall, &particles, NULL, 1,
                               scene->wall_type, NULL, scene->wall_histories, &scene->step, &load,
                               NULL));
    scene->wall_contacts = (double) load.contact_count;
  }
#endif
  ++scene->steps_done;
}

/* The axes of a body in the world frame. */
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

/* `to` = inertia^power `from`, power 1 or -1, world frame. */
static void through_inertia(const Scene *scene, size_t k, const double *q, int power,
                            const double *from, double *to)
{
  const double *a = scene->semi_axes + 3 * k, m = 0.2 * scene->masses[k];
  const double inertia[3] = {m * (a[1] * a[1] + a[2] * a[2]), m * (a[0] * a[0] + a[2] * a[2]),
                             m * (a[0] * a[0] + a[1] * a[1])};
  double axes[3][3], result[3] = {0.0, 0.0, 0.0};
  int axis, c;
  body_axes(q, axes);
  for (axis = 0; axis < 3; ++axis) {
    double along = 0.0;
    for (c = 0; c < 3; ++c) along += axes[axis][c] * from[c];
    along = power > 0 ? along * inertia[axis] : along / inertia[axis];
    for (c = 0; c < 3; ++c) result[c] += along * axes[axis][c];
  }
  memcpy(to, result, sizeof result);
}

/* Turned by an angular velocity to the first order, and of unit length. */
static void turn(double *q, const double *spin, double time)
{
  const double w = q[0], x = q[1], y = q[2], z = q[3], h = 0.5 * time;
  double length;
  int c;
  q[0] = w - h * (spin[0] * x + spin[1] * y + spin[2] * z);
  q[1] = x + h * (spin[0] * w + spin[1] * z - spin[2] * y);
  q[2] = y + h * (spin[1] * w + spin[2] * x - spin[0] * z);
  q[3] = z + h * (spin[2] * w + spin[0] * y - spin[1] * x);
  length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (c = 0; c < 4; ++c) q[c] /= length;
}

static void one_step(Scene *scene)
{
  Frame *frame = &scene->frames[0];
  const double dt = scene->step.time_step;
  size_t k, c;
  for (k = 0; k < scene->count; ++k) {
    for (c = 3 * k; c < 3 * k + 3; ++c) frame->positions[c] += dt * frame->velocities[c];
    turn(frame->quaternions + 4 * k, frame->spins + 3 * k, dt);
  }
  memset(scene->forces, 0, 3 * scene->count * sizeof(double));
  memset(scene->torques, 0, 3 * scene->count * sizeof(double));
  compute(scene, frame, 0, &scene->tallies);
  for (k = 0; k < scene->count; ++k) {
    for (c = 3 * k; c < 3 * k + 3; ++c) {
      frame->velocities[c] += dt * (scene->forces[c] / scene->masses[k] - scene->pull * frame->positions[c]);
      scene->momenta[c] += dt * scene->torques[c];
      scene->impulses[c] += scene->forces[c];
      scene->impulses[3 * scene->count + c] += scene->torques[c];
    }
    through_inertia(scene, k, frame->quaternions + 4 * k, -1, scene->momenta + 3 * k,
                    frame->spins + 3 * k);
  }
}

static void put(const double *values, size_t count)
{
  if (fwrite(values, sizeof *values, count, stdout) != count) stop("the numbers cannot be written");
}

static void put_count(size_t count)
{
  const int64_t number_of_doubles = (int64_t) count;
  if (fwrite(&number_of_doubles, sizeof number_of_doubles, 1, stdout) != 1) {
    stop("the numbers cannot be written");
  }
}

static void trajectory(Scene *scene, long steps)
{
  const size_t n = scene->count;
  const Frame *frame = &scene->frames[0];
  const EllgranTallies *t = &scene->tallies;
  double sums[12];
  size_t k;
  long done;
  for (k = 0; k < n; ++k) {
    through_inertia(scene, k, frame->quaternions + 4 * k, 1, frame->spins + 3 * k,
                    scene->momenta + 3 * k);
  }
  for (done = 0; done < steps; ++done) one_step(scene);
  put_count(13 * n);
  put(frame->positions, 3 * n);
  put(frame->velocities, 3 * n);
  put(frame->spins, 3 * n);
  put(frame->quaternions, 4 * n);
  sums[0] = t->viscous_dissipation;
  sums[1] = t->tangential_work;
  sums[2] = t->normal_elastic_energy;
  sums[3] = t->tangential_elastic_energy;
  memcpy(sums + 4, t->virial, sizeof t->virial);
  sums[10] = t->touching_count;
  sums[11] = scene->wall_contacts;
  put_count(12 * n + 12);
  put(scene->forces, 3 * n);
  put(scene->torques, 3 * n);
  put(scene->impulses, 6 * n);
  put(sums, 12);
  put_count(scene->pair_count * (1 + scene->history_length) + scene->wall_histories_length);
  for (k = 0; k < scene->pair_count; ++k) {
    const double flag = scene->touching[k];
    put(&flag, 1);
  }
  put(scene->histories, scene->pair_count * scene->history_length);
  put(scene->wall_histories, scene->wall_histories_length);
}

/* Processor time of this thread, ns. */
static double now(void)
{
  struct timespec time;
  if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time) != 0) stop("the system has no clock of a thread's time");
  return 1e9 * (double) time.tv_sec + (double) time.tv_nsec;
}

static EllgranBody body(const Scene *scene, const Frame *frame, size_t k)
{
  EllgranBody one = ELLGRAN_INIT(EllgranBody);
  memcpy(one.position, frame->positions + 3 * k, sizeof one.position);
  memcpy(one.velocity, frame->velocities + 3 * k, sizeof one.velocity);
  memcpy(one.angular_velocity, frame->spins + 3 * k, sizeof one.angular_velocity);
  memcpy(one.quaternion, frame->quaternions + 4 * k, sizeof one.quaternion);
  memcpy(one.semi_axes, scene->semi_axes + 3 * k, sizeof one.semi_axes);
  one.mass = scene->masses[k];
  one.particle_type = scene->types[k];
  one.identifier = (int64_t) k;
  return one;
}

/* The touching pairs, a call for each. */
static void compute_one_by_one(Scene *scene, const Frame *frame)
{
  size_t i, k, at = 0;
  for (i = 0; i < scene->count; ++i) {
    for (k = 0; k < (size_t) scene->row_lengths[i]; ++k, ++at) {
      if (scene->touching[at]) {
        const EllgranBody first = body(scene, frame, i);
        const EllgranBody second = body(scene, frame, (size_t) scene->neighbours[at]);
        EllgranContactGeometry geometry = ELLGRAN_INIT(EllgranContactGeometry);
        EllgranContactForce force = ELLGRAN_INIT(EllgranContactForce);
        /* A pair that parts in one frame touches again in the next: it stays in the list. */
        int32_t touches = 1;
        check(ellgran_contact(scene->laws, &first, &second, &scene->step, &touches,
                              scene->histories + at * scene->history_length, &geometry, &force));
      }
    }
  }
}

static void answer(Scene *scene)
{
  const int keep_history = !scene->single;
  EllgranTallies *tallies = scene->tallied ? &scene->tallies : NULL;
  EllgranTallies counted = ELLGRAN_INIT(EllgranTallies);
  long steps;
  int k;
  for (k = 0; k < WARM_UP_STEPS; ++k) {
    compute(scene, &scene->frames[(size_t) scene->steps_done % scene->frame_count], keep_history, tallies);
  }
  compute(scene, &scene->frames[(size_t) scene->steps_done % scene->frame_count], keep_history, &counted);
  printf("%.17g\n", scene->wall_type > 0 ? scene->wall_contacts : counted.touching_count);
  fflush(stdout);
  while (scanf("%ld", &steps) == 1) {
    double spent = 0.0;
    for (; steps > 0; --steps) {
      const Frame *frame = &scene->frames[(size_t) scene->steps_done % scene->frame_count];
      double start;
      if (scene->cold) {
        check(ellgran_forget_history(scene->workspace));
        memset(scene->touching, 0, scene->pair_count * sizeof(int32_t));
        memset(scene->histories, 0, scene->pair_count * scene->history_length * sizeof(double));
      }
      start = now();
      if (scene->single) {
        compute_one_by_one(scene, frame);
        ++scene->steps_done;
      } else {
        compute(scene, frame, keep_history, tallies);
      }
      spent += now() - start;
    }
    printf("%.17g\n", spent);
    fflush(stdout);
  }
}

int main(int count, char **words)
{
  Scene scene;
  if (count == 4 && strcmp(words[2], "trajectory") == 0) {
    read_scene(&scene, words[1]);
    trajectory(&scene, atol(words[3]));
  } else if (count == 3 && strcmp(words[2], "time") == 0) {
    read_scene(&scene, words[1]);
    answer(&scene);
  } else {
    stop("wanted: SCENE trajectory STEPS, or SCENE time");
  }
  return EXIT_SUCCESS;
}
