// SPDX-License-Identifier: GPL-2.0-or-later

#include "fix_wall_gran_ellipsoid.h"

#include "ellgran_contact_sources.h"
#include "ellgran_energy_balance.h"
#include "ellgran_history.h"
#include "ellgran_kokkos.h"
#include "ellgran_refusals.h"
#include "ellgran_restart_format.h"
#include "ellgran_wall_shape.h"
#include "ellgran_step_velocity.h"
#include "fix_nve_ellipsoid.h"
#include "pair_gran_ellipsoid.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "group.h"
#include "input.h"
#include "memory.h"
#include "modify.h"
#include "neighbor.h"
#include "region.h"
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;
using namespace FixConst;

namespace {

const char CALLER[] = "Fix wall/gran/ellipsoid";
const char SYNTAX[] =
    "fix ID group wall/gran/ellipsoid <normal law> [damping ...] [tangential ...] [rolling ...] [twisting ...] [keywords] [material ...] <wall> [motion ...] "
    "[contacts] [vtk N file] [energies yes|no], "
    "wall = xplane|yplane|zplane lo hi, or xcylinder|ycylinder|zcylinder radius, or region ID, or shape NAME ..., or mesh FILE "
    "[scale s] [turn angle ax ay az] [move x y z]";
const char MOTIONS[] =
    "wiggle dim amplitude period, shear dim velocity, velocity vx vy vz, rotate px py pz ax ay az period, omega px py pz ax ay "
    "az rate, servo ax ay az target speed [area A] [gain g]";

constexpr double TWO_PI = 6.283185307179586476925286766559;

// Directions and planes that are parallel but for rounding
constexpr double IN_THE_PLANE = 1e-12;

// A row of the local array
constexpr int CONTACT_COLUMNS = 21;

// Global values in the restart file: see ellgran_restart_format.h.
constexpr int NUMBER_WITH_REGION = 9;
constexpr int NUMBER_OF_STATES = NUMBER_WITH_REGION + 4 + WallServo::NUMBER_OF_STATES;
constexpr int NUMBER_OF_MEANS = 5;
constexpr int NUMBER_AT_STEP = WallVelocityAtStep::NUMBER_OF_STATES + 1;

// Words of a motion that are the same to rounding
constexpr double SAME_WORDS = 1e-9;
constexpr int VALUES_OF_LAW = (sizeof(EllgranLawParameters) + sizeof(double) - 1) / sizeof(double);

double dot(const double *a, const double *b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// The quaternion of a rotation about a unit vector
void quaternion_of(const double *axis, double angle, double *q)
{
  const double sine = std::sin(0.5 * angle);
  q[0] = std::cos(0.5 * angle);
  for (int k = 0; k < 3; k++) q[k + 1] = sine * axis[k];
}

}    // namespace

FixWallGranEllipsoid::FixWallGranEllipsoid(LAMMPS *lmp, int narg, char **arg, bool remembers) :
    Fix(lmp, narg, arg), atoms(lmp, CALLER), remembers_here(remembers), law_words(ELLGRAN_INIT(EllgranLawParameters)),
    wall_words(ELLGRAN_INIT(EllgranLawParameters)), has_material(false), laws(nullptr), workspace(nullptr), wall(nullptr), wall_type(1), dimension(-1),
    plane_slots{-1, -1}, plane_positions{}, is_cylinder(false), is_mesh(false), wiggles(false), shears(false), rotates(false), moves(false), motion_axis(0),
    amplitude(0.0), period(1.0), shear_velocity(0.0), rotation_point{}, rotation_axis{}, varied_displacement{},
    varied_angle(0.0), velocity_now{}, rate_now(0.0), mean_velocity{}, mean_rate(0.0),
    pose_is_known(false), pose{}, region_velocity{}, region_rate(0.0), time_then(0.0), time_step(update->dt),
    step_then(update->ntimestep), last_step(update->ntimestep), fix_step_velocity(nullptr), velocities_of_step(nullptr), histories_length(0),
    contact_histories(nullptr), tells_contacts(false), keeps_energies(false), leaves_energies_out(false), sums_energies(false), scene_may_change(true), step_of_forces(-2), contacts_wanted(false), step_of_contacts(-1), triangle_file_every(0), fix_rigid(nullptr), tallies(ELLGRAN_INIT(EllgranTallies)), friction(0.0),
    work_of_walls(0.0), last_load(ELLGRAN_INIT(EllgranWallLoad)), output_here{}, output_all{}, displacement{}, wall_velocity{}, summed(true),
    motion_of_forces(ELLGRAN_INIT(EllgranWallMotion)), has_forces(false), touches_here(false), said_missing_image(false)
{
  if (ellgran_abi_version() != ELLGRAN_ABI_VERSION)
    error->all(FLERR, "{}: compiled for ABI version {} of ellgran, but linked with version {}",
               CALLER, static_cast<int>(ELLGRAN_ABI_VERSION),
               static_cast<int>(ellgran_abi_version()));
  atoms.require_atom_style();
  check(ellgran_wall_new(&wall));
  check(ellgran_workspace_new(&workspace));

  int iarg = parse_law(narg, arg);
  iarg = parse_wall(iarg, narg, arg);
  parse_keywords(iarg, narg, arg);
  check_periodicity();
  histories_length = static_cast<int>(ellgran_wall_histories_length(wall, laws));

  scalar_flag = vector_flag = 1;
  extscalar = 1;
  extvector = -1;
  size_vector = NUMBER_OF_OUTPUTS;
  extlist = new int[NUMBER_OF_OUTPUTS];
  for (int k = 0; k < NUMBER_OF_OUTPUTS; k++) extlist[k] = (k < NUMBER_OF_SUMS) ? 1 : 0;
  global_freq = 1;
  energy_global_flag = leaves_energies_out ? 0 : 1;
  // As LAMMPS' walls: with 'fix_modify virial yes' alone.
  virial_global_flag = virial_peratom_flag = 1;
  create_attribute = 1;
  restart_global = 1;
  time_depend = wiggles ? 1 : 0;
  restart_peratom = (histories_length > 0) ? 1 : 0;
  maxexchange = 1 + histories_length;
  if (tells_contacts) {
    local_flag = 1;
    size_local_rows = 0;
    size_local_cols = CONTACT_COLUMNS;
    local_freq = 1;
  }

  if (remembers_here) keep_with_atoms();
}

void FixWallGranEllipsoid::keep_with_atoms()
{
  remembers_here = true;
  FixWallGranEllipsoid::grow_arrays(atom->nmax);
  atom->add_callback(Atom::GROW);
  if (restart_peratom) atom->add_callback(Atom::RESTART);
  for (int i = 0; i < atom->nlocal; i++) FixWallGranEllipsoid::set_arrays(i);
}

FixWallGranEllipsoid::~FixWallGranEllipsoid()
{
  if (remembers_here) atom->delete_callback(id, Atom::GROW);
  if (remembers_here && restart_peratom) atom->delete_callback(id, Atom::RESTART);
  memory->destroy(contact_histories);
  delete[] extlist;
  ellgran_wall_free(wall);
  ellgran_laws_free(laws);
  ellgran_workspace_free(workspace);
  // Its place in LAMMPS' list is behind this fix, so that to delete it here shifts nothing before.
  if (fix_step_velocity && modify->nfix > 0 && modify->get_fix_by_id(id_step_velocity))
    modify->delete_fix(id_step_velocity);
}

/* The words of the fix are the law of the contact itself: both sides have these constants, but for a material of the wall. */

int FixWallGranEllipsoid::parse_law(int narg, char **arg)
{
  if (narg < 4) error->all(FLERR, "{}: no law given: {}", CALLER, SYNTAX);
  EllgranLawParameters given = ELLGRAN_INIT(EllgranLawParameters);
  std::size_t consumed = 0;
  if (ellgran_law_parameters_parse(narg - 3, arg + 3, &consumed, &given) != ELLGRAN_SUCCESS)
    error->all(FLERR, "{} {}: {}", CALLER, id, ellgran_last_error());

  std::size_t of_material = 0;
  check_words(ellgran_wall_material_parse(&given, narg - 3 - consumed, arg + 3 + consumed, &of_material, &wall_words));
  consumed += of_material;
  law_words = given;
  has_material = of_material > 0;

  wall_type = atom->ntypes + 1;
  if (make_laws(given, wall_words, &laws) != ELLGRAN_SUCCESS) error->all(FLERR, "{} {}: {}", CALLER, id, ellgran_last_error());
  int32_t i = 0, j = 0;
  if (ellgran_laws_create_energy(laws, &i, &j) != ELLGRAN_SUCCESS)
    error->all(FLERR, "{} {}: {}", CALLER, id, ellgran_last_error());
  if (i > 0 && comm->me == 0)
    error->warning(FLERR,
                   "{} {}: displacement total and displacement incremental can create energy, and nothing in this law "
                   "dissipates any: use displacement rescaled, or a law with damping",
                   CALLER, id);
  return 3 + static_cast<int>(consumed);
}

/* The library mixes what is not set from the two on the diagonal. */

int32_t FixWallGranEllipsoid::make_laws(const EllgranLawParameters &of_grains, const EllgranLawParameters &of_wall, EllgranLaws **made) const
{
  const auto types = static_cast<std::size_t>(wall_type);
  std::vector<EllgranLawParameters> parameters(types * types, of_grains);
  parameters.back() = of_wall;
  std::vector<uint8_t> is_set(types * types, 0);
  for (std::size_t k = 0; k < types; k++) is_set[k * types + k] = 1;
  return ellgran_laws_new(wall_type, parameters.data(), is_set.data(), ELLGRAN_OPTION_NO_WARM_START, made);
}

void FixWallGranEllipsoid::check(int32_t status) const
{
  if (status != ELLGRAN_SUCCESS) error->one(FLERR, "{} {}: {}", CALLER, id, ellgran_last_error());
}

/* What all ranks find alike. */

void FixWallGranEllipsoid::check_words(int32_t status) const
{
  if (status != ELLGRAN_SUCCESS) error->all(FLERR, "{} {}: {}", CALLER, id, ellgran_last_error());
}

double FixWallGranEllipsoid::number(const char *keyword, const char *word) const
{
  const double value = utils::numeric(FLERR, word, false, lmp);
  if (!std::isfinite(value)) error->all(FLERR, "{} {}: {} value {} must be finite", CALLER, id, keyword, word);
  return value;
}

void FixWallGranEllipsoid::require_values(const char *keyword, int count, int iarg, int narg) const
{
  if (iarg + 1 + count > narg)
    error->all(FLERR, "{} {}: '{}' needs {} value{}: {}; motion = {}", CALLER, id, keyword, count, (count == 1) ? "" : "s",
               SYNTAX, MOTIONS);
}

int FixWallGranEllipsoid::parse_wall(int iarg, int narg, char **arg)
{
  if (iarg >= narg) error->all(FLERR, "{} {}: no wall given: {}", CALLER, id, SYNTAX);
  const std::string word = arg[iarg];
  if (word == "region") return parse_region(iarg, narg, arg);
  if (word == "mesh") return parse_mesh(iarg, narg, arg);
  if (word == "shape") return parse_shapes(iarg, narg, arg);
  if (!word.empty() && word[0] >= 'x' && word[0] <= 'z') {
    dimension = word[0] - 'x';
    if (word.substr(1) == "plane") return parse_planes(iarg, narg, arg);
    if (word.substr(1) == "cylinder") return parse_cylinder(iarg, narg, arg);
  }
  error->all(FLERR, "{} {}: unknown word '{}': {}", CALLER, id, word, SYNTAX);
  return narg;
}

int FixWallGranEllipsoid::parse_planes(int iarg, int narg, char **arg)
{
  const char *const word = arg[iarg];
  if (iarg + 3 > narg)
    error->all(FLERR, "{} {}: '{}' needs two positions: {} lo hi, NULL for none", CALLER, id, word,
               word);
  double (&positions)[2] = plane_positions;
  int count = 0;
  for (int k = 0; k < 2; k++) {
    const char *given = arg[iarg + 1 + k];
    if (std::strcmp(given, "NULL") == 0) continue;
    positions[k] = number(word, given);
    EllgranWallShape shape = ELLGRAN_INIT(EllgranWallShape);
    shape.name = "plane";
    shape.point[dimension] = positions[k];
    shape.axis[dimension] = (k == 0) ? 1.0 : -1.0;
    shape.side = ELLGRAN_SIDE_INSIDE;
    check_words(ellgran_wall_add_shape(wall, &shape));
    plane_slots[k] = count++;
    only_plane = Plane{{shape.axis[0], shape.axis[1], shape.axis[2]}, 1.0};
  }
  if (count == 2) only_plane.reset();
  if (count == 0)
    error->all(FLERR, "{} {}: '{} NULL NULL' has no plane: give at least one position", CALLER, id,
               word);
  if (count == 2 && positions[0] >= positions[1])
    error->all(FLERR, "{} {}: {} lo {} must be below hi {}", CALLER, id, word, positions[0],
               positions[1]);
  return iarg + 3;
}

/* As in fix wall/gran the axis goes through the origin, and grains may be inside or outside. */

int FixWallGranEllipsoid::parse_cylinder(int iarg, int narg, char **arg)
{
  const char *const word = arg[iarg];
  require_values(word, 1, iarg, narg);
  is_cylinder = true;
  EllgranWallShape shape = ELLGRAN_INIT(EllgranWallShape);
  shape.name = "cylinder";
  shape.axis[dimension] = 1.0;
  shape.radii[0] = number(word, arg[iarg + 1]);
  shape.side = ELLGRAN_SIDE_OF_CENTRE;
  check_words(ellgran_wall_add_shape(wall, &shape));
  return iarg + 2;
}

int FixWallGranEllipsoid::parse_region(int iarg, int narg, char **arg)
{
  require_values("region", 1, iarg, narg);
  region_id = arg[iarg + 1];
  Region *const region = domain->get_region_by_id(region_id);
  if (!region) error->all(FLERR, "{} {}: region {} does not exist", CALLER, id, region_id);
  add_region(lmp, std::string(CALLER) + " " + id, region, wall);
  region_measures = measures_of_region(region);
  plane_normals = planes_of_region(region, domain->boxlo, domain->boxhi);
  if (ellgran_wall_part_count(wall) == 0)
    error->all(FLERR, "{} {}: region {} has no surface", CALLER, id, region_id);
  if (std::strcmp(region->style, "plane") == 0) only_plane = Plane{plane_normals.front(), region->interior ? 1.0 : -1.0};
  return iarg + 2;
}

int FixWallGranEllipsoid::parse_shapes(int iarg, int narg, char **arg)
{
  const std::string caller = std::string(CALLER) + " " + id;
  while (iarg < narg && std::strcmp(arg[iarg], "shape") == 0) {
    const int words = add_wall_shape(lmp, caller, wall, narg - iarg - 1, arg + iarg + 1);
    if (std::strcmp(arg[iarg + 1], "plane") == 0) {
      Plane plane{{}, 1.0};
      int32_t both_sides = 0;
      check_words(ellgran_wall_part_plane(wall, ellgran_wall_part_count(wall) - 1, plane.normal.data(), &both_sides));
      if (both_sides) plane.side = 0.0;
      plane_normals.push_back(plane.normal);
      only_plane = plane;
    }
    iarg += 1 + words;
  }
  if (ellgran_wall_part_count(wall) != 1) only_plane.reset();
  return iarg;
}

int FixWallGranEllipsoid::parse_mesh(int iarg, int narg, char **arg)
{
  require_values("mesh", 1, iarg, narg);
  const char *const file = arg[iarg + 1];
  double scale = 1.0, quaternion[4] = {1.0, 0.0, 0.0, 0.0}, translation[3] = {};
  is_mesh = true;
  iarg += 2;
  while (iarg < narg) {
    const std::string word = arg[iarg];
    if (word == "scale") {
      require_values("scale", 1, iarg, narg);
      scale = number("scale", arg[iarg + 1]);
      iarg += 2;
    } else if (word == "turn") {
      require_values("turn", 4, iarg, narg);
      double axis[3];
      for (int k = 0; k < 3; k++) axis[k] = number("turn", arg[iarg + 2 + k]);
      const double length = std::hypot(axis[0], axis[1], axis[2]);
      if (length == 0.0) error->all(FLERR, "{} {}: turn needs an axis other than 0 0 0", CALLER, id);
      for (double &component : axis) component /= length;
      quaternion_of(axis, number("turn", arg[iarg + 1]) * TWO_PI / 360.0, quaternion);
      iarg += 5;
    } else if (word == "move") {
      require_values("move", 3, iarg, narg);
      for (int k = 0; k < 3; k++) translation[k] = number("move", arg[iarg + 1 + k]);
      iarg += 4;
    } else
      break;
  }
  std::size_t count = 0;
  check_words(ellgran_wall_add_stl(wall, file, scale, quaternion, translation, &count));
  if (comm->me == 0) utils::logmesg(lmp, "  {} {}: {} triangles from {}\n", CALLER, id, count, file);
  return iarg;
}

int FixWallGranEllipsoid::axis_word(const char *keyword, const char *word) const
{
  if (std::strcmp(word, "x") == 0) return 0;
  if (std::strcmp(word, "y") == 0) return 1;
  if (std::strcmp(word, "z") == 0) return 2;
  error->all(FLERR, "{} {}: {} dimension '{}' must be x, y or z", CALLER, id, keyword, word);
  return -1;
}

int FixWallGranEllipsoid::parse_keywords(int iarg, int narg, char **arg)
{
  const bool region_moves = !region_id.empty() && domain->get_region_by_id(region_id)->dynamic;
  while (iarg < narg) {
    const std::string word = arg[iarg];
    if (word == "contacts") {
      tells_contacts = true;
      iarg++;
      continue;
    }
    if (word == "energies") {
      require_values("energies", 1, iarg, narg);
      keeps_energies = utils::logical(FLERR, arg[iarg + 1], false, lmp) != 0;
      leaves_energies_out = !keeps_energies;
      iarg += 2;
      continue;
    }
    if (word == "vtk") {
      require_values("vtk", 2, iarg, narg);
      parse_triangle_file(arg + iarg);
      iarg += 3;
      continue;
    }
    if (region_moves && (word == "servo" || word == "omega"))
      error->all(FLERR, "{} {}: region {} moves by itself: take '{}' away", CALLER, id, region_id, word);
    if (word == "servo") {
      if (servo) error->all(FLERR, "{} {}: servo is given twice", CALLER, id);
      int consumed = 0;
      servo = std::make_unique<WallServo>(lmp, std::string(CALLER) + " " + id, narg - iarg - 1, arg + iarg + 1, consumed);
      check_servo();
      iarg += 1 + consumed;
      continue;
    }
    const int values = (word == "wiggle" || word == "velocity") ? 3
        : (word == "shear")                                     ? 2
        : (word == "rotate" || word == "omega")                 ? 7
                                                                : 0;
    if (values == 0)
      error->all(FLERR, "{} {}: unknown word '{}' after the wall: {}; motion = {}", CALLER, id, word, SYNTAX, MOTIONS);
    require_values(word.c_str(), values, iarg, narg);
    const bool turns = word == "rotate" || word == "omega";
    if (wiggles || shears || (moves && !turns) || (rotates && word != "velocity"))
      error->all(FLERR,
                 "{} {}: a wall can wiggle or shear or move, once; velocity may go together with rotate or omega, and servo with each",
                 CALLER, id);
    if (region_moves)
      error->all(FLERR, "{} {}: region {} has a motion of its own: remove '{}'", CALLER, id, region_id, word);
    if (word == "wiggle")
      parse_wiggle(arg + iarg);
    else if (word == "shear")
      parse_shear(arg + iarg);
    else if (turns)
      parse_rotate(arg + iarg);
    else {
      moves = true;
      for (int k = 0; k < 3; k++) velocity[k].read(lmp, std::string(CALLER) + " " + id, "velocity", arg[iarg + 1 + k]);
    }
    iarg += 1 + values;
  }
  return iarg;
}

void FixWallGranEllipsoid::parse_wiggle(char **arg)
{
  wiggles = true;
  motion_axis = axis_word("wiggle", arg[1]);
  amplitude = utils::numeric(FLERR, arg[2], false, lmp);
  period = utils::numeric(FLERR, arg[3], false, lmp);
  if (!std::isfinite(amplitude) || !std::isfinite(period) || period <= 0.0)
    error->all(FLERR, "{} {}: wiggle amplitude {} must be finite and period {} positive", CALLER,
               id, arg[2], arg[3]);
}

/* A surface that slides in itself: it stays in its place. */

void FixWallGranEllipsoid::parse_shear(char **arg)
{
  shears = true;
  motion_axis = axis_word("shear", arg[1]);
  shear_velocity = utils::numeric(FLERR, arg[2], false, lmp);
  if (!std::isfinite(shear_velocity))
    error->all(FLERR, "{} {}: shear velocity {} must be finite", CALLER, id, arg[2]);
  if (dimension < 0)
    error->all(FLERR, "{} {}: only a plane or a cylinder can shear: use velocity", CALLER, id);
  if (!is_cylinder && motion_axis == dimension)
    error->all(FLERR, "{} {}: a plane cannot shear along its own normal", CALLER, id);
  if (is_cylinder && motion_axis != dimension)
    error->all(FLERR, "{} {}: a cylinder can shear along its axis only: use velocity or rotate", CALLER, id);
}

/* The words of rotate, which has a period, and of omega, which has an angular velocity. */

void FixWallGranEllipsoid::parse_rotate(char **arg)
{
  rotates = true;
  const char *const word = arg[0];
  for (int k = 0; k < 3; k++) {
    rotation_point[k] = number(word, arg[1 + k]);
    rotation_axis[k] = number(word, arg[4 + k]);
  }
  const double length = std::hypot(rotation_axis[0], rotation_axis[1], rotation_axis[2]);
  if (!(length > 0.0)) error->all(FLERR, "{} {}: {} needs an axis other than 0 0 0", CALLER, id, word);
  for (double &component : rotation_axis) component /= length;
  if (std::strcmp(word, "omega") == 0) {
    rotation_rate.read(lmp, std::string(CALLER) + " " + id, "omega", arg[7]);
    return;
  }
  if (utils::strmatch(arg[7], "^v_"))
    error->all(FLERR, "{} {}: the period of rotate is a number: use omega, whose angular velocity may be {}", CALLER, id, arg[7]);
  const double rotation_period = number(word, arg[7]);
  if (rotation_period == 0.0)
    error->all(FLERR, "{} {}: rotate period {} must not be 0", CALLER, id, arg[7]);
  rotation_rate.set(TWO_PI / rotation_period);
}

/* A pair of planes would move as one, and a plane that presses away from the grains would leave for ever. */

void FixWallGranEllipsoid::check_servo() const
{
  if (plane_slots[0] >= 0 && plane_slots[1] >= 0)
    error->all(FLERR, "{} {}: servo moves one plane: give NULL in the place of the other, and another fix to that", CALLER, id);
  if (!only_plane) return;
  const double *const normal = only_plane->normal.data();
  const double towards = dot(normal, servo->direction());
  if (std::fabs(towards) <= IN_THE_PLANE * std::sqrt(dot(normal, normal)))
    error->all(FLERR, "{} {}: servo must press towards the grains, and its direction lies in the plane: give it a part along its normal, {} {} {}",
               CALLER, id, normal[0], normal[1], normal[2]);
  if (only_plane->side * towards < 0.0)
    error->all(FLERR, "{} {}: servo must press towards the grains, and these are on the other side of the plane: turn its direction",
               CALLER, id);
}

void FixWallGranEllipsoid::parse_triangle_file(char **arg)
{
  if (!is_mesh) error->all(FLERR, "{} {}: vtk shows triangles: it goes with a mesh", CALLER, id);
  if (triangle_file_every > 0) error->all(FLERR, "{} {}: vtk is given twice", CALLER, id);
  triangle_file_every = utils::inumeric(FLERR, arg[1], false, lmp);
  triangle_file = arg[2];
  if (triangle_file_every <= 0)
    error->all(FLERR, "{} {}: vtk {} must be a number of steps greater than 0", CALLER, id, arg[1]);
  if (triangle_file.find('*') == std::string::npos)
    error->all(FLERR, "{} {}: vtk file {} needs a '*', which becomes the step", CALLER, id, triangle_file);
}

/* A wall has no images: it must not depend on a coordinate that repeats. */

void FixWallGranEllipsoid::check_periodicity() const
{
  for (int k = 0; k < 3; k++) {
    bool across = dimension >= 0 && (is_cylinder ? k != dimension : k == dimension);
    for (const auto &normal : plane_normals) across |= normal[k] != 0.0;
    if (across && domain->periodicity[k])
      error->all(FLERR,
                 "{} {}: the wall is in a periodic dimension, {}: use 'boundary' with f, s or m in that dimension, and INF for faces of a "
                 "block that are not meant to be there",
                 CALLER, id, "xyz"[k]);
  }
}

int FixWallGranEllipsoid::setmask()
{
  return POST_INTEGRATE | POST_FORCE | MIN_POST_FORCE;
}

void FixWallGranEllipsoid::init()
{
  require_host_kokkos(lmp, CALLER);
  atoms.require_atom_style();
  if (utils::strmatch(update->integrate_style, "^respa"))
    error->all(FLERR, "{} does not support rRESPA: use 'run_style verlet'", CALLER);
  check_periodicity();
  require_region_as_it_was();
  atoms.require_shapes(groupbit);
  // Contacts of grains that are not in the group any more are over.
  for (int i = 0; i < atom->nlocal; i++)
    if (!(atom->mask[i] & groupbit)) FixWallGranEllipsoid::set_arrays(i);
  refuse_styles(lmp, CALLER, histories_length > 0);
  for (const NumberOrVariable &component : velocity) component.require_variable(lmp);
  rotation_rate.require_variable(lmp);
  if (servo) servo->require_variables();
  if (input->command && std::strcmp(input->command, "rerun") == 0) {
    if (wiggles || moves || rotates || servo)
      error->all(FLERR, "{} {}: 'rerun' cannot be used with a moving wall, whose position is not in a dump", CALLER, id);
    if (histories_length > 0)
      error->all(FLERR,
                 "{} {}: 'rerun' cannot be used with a wall whose law remembers contacts, as friction does: their histories are not in a dump: write "
                 "restart files ('restart N frame.*'), and 'read_restart' and 'run 0' each",
                 CALLER, id);
  }
  place_step_velocity_fix();
  sums_energies = energies_wanted();
  check(ellgran_wall_keep_inelastic_loads(wall, sums_energies ? 1 : 0));
  contacts_wanted = !modify->get_compute_by_style("^contact/ellipsoid/atom$").empty();
  scene_may_change = atoms.shapes_may_change() || group->dynamic[igroup];
  EllgranContactSources sources;
  sources.find(lmp);
  pair = sources.pairs.size() == 1 ? sources.pairs.front() : nullptr;

  fix_rigid = nullptr;
  for (auto *fix : modify->get_fix_list())
    if (fix->rigid_flag) {
      if (fix_rigid) error->all(FLERR, "{}: only one fix rigid is allowed", CALLER);
      fix_rigid = fix;
    }
}

/* The surfaces were taken from the region when the fix was made. */

void FixWallGranEllipsoid::require_region_as_it_was() const
{
  if (region_id.empty() || measures_of_region(present_region()) == region_measures) return;
  error->all(FLERR, "{} {}: region {} was defined anew, with another shape or place, since the fix was made: give the fix anew, too", CALLER, id,
             region_id);
}

void FixWallGranEllipsoid::setup(int vflag)
{
  post_force(vflag);
  warn_of_missing_images();
}

void FixWallGranEllipsoid::min_setup(int vflag)
{
  post_force(vflag);
  warn_of_missing_images();
}

/* Once, of a mesh as it is when a run begins: grains across a periodic boundary touch what is in the file alone. */

void FixWallGranEllipsoid::warn_of_missing_images()
{
  if (!is_mesh || said_missing_image || domain->triclinic) return;
  double here = 0.0, reach = 0.0;
  for (const double axis : atoms.largest_semi_axes()) here = std::max(here, axis);
  MPI_Allreduce(&here, &reach, 1, MPI_DOUBLE, MPI_MAX, world);
  const int32_t is_periodic[3] = {domain->periodicity[0], domain->periodicity[1], domain->periodicity[2]};
  int32_t axis = -1;
  std::size_t triangle = 0;
  double place[3] = {};
  check(ellgran_wall_missing_image(wall, &motion_of_forces, domain->boxlo, domain->boxhi, is_periodic, reach, &axis, &triangle, place));
  if (axis < 0) return;
  said_missing_image = true;
  if (comm->me == 0)
    error->warning(FLERR,
                   "{} {}: the mesh ends at the periodic boundary in {}, and a wall has no periodic images: that of triangle {} is missing at "
                   "{:.6g} {:.6g} {:.6g}, where grains whose centres are in the box may reach. Let the mesh go on beyond the box by their largest "
                   "semi-axis, {:.6g}, on both sides",
                   CALLER, id, "xyz"[axis], triangle + 1, place[0], place[1], place[2], reach);
}

void FixWallGranEllipsoid::min_post_force(int vflag)
{
  post_force(vflag);
}

void FixWallGranEllipsoid::place_step_velocity_fix()
{
  velocities_of_step = FixNVEEllipsoid::keeper_of(modify);
  sees_velocities_of_step = velocities_of_step != nullptr;
  fix_step_velocity = place_step_velocity(modify, fix_step_velocity, std::string("ELLGRAN_STEP_VELOCITY_") + id, id_step_velocity);
}

/* Called in every step and when forces are computed without a step: a step may have got another length or number. */

void FixWallGranEllipsoid::follow_time(bool passes)
{
  const bigint before = passes ? update->ntimestep - 1 : update->ntimestep;
  if (update->dt != time_step || before != last_step) {
    time_then += static_cast<double>(last_step - step_then) * time_step;
    time_step = update->dt;
    step_then = before;
  }
  last_step = update->ntimestep;
}

double FixWallGranEllipsoid::time_passed() const
{
  return time_then + static_cast<double>(last_step - step_then) * time_step;
}

bool FixWallGranEllipsoid::varies() const
{
  return velocity[0].is_variable() || velocity[1].is_variable() || velocity[2].is_variable() || rotation_rate.is_variable();
}

/* Over a step the wall has the mean of the velocities at its two ends, the later of which is that of the step. With velocities of the step the
   start of a run computes the forces of the last step once more. */

void FixWallGranEllipsoid::follow_variables(bool time_passes)
{
  if (!varies()) return;
  const bool repeats = !time_passes && sees_velocities_of_step && means_are_known;
  modify->clearstep_compute();
  const auto follow = [&](const NumberOrVariable &given, double &now, double &mean, double &way) {
    const double before = now;
    now = given.value(lmp);
    if (!repeats) mean = time_passes ? 0.5 * (before + now) : now;
    if (time_passes) way += mean * time_step;
    return now - before;
  };
  double growth[WallVelocityAtStep::COUNT];
  for (int k = 0; k < 3; k++) growth[k] = follow(velocity[k], velocity_now[k], mean_velocity[k], varied_displacement[k]);
  growth[3] = follow(rotation_rate, rate_now, mean_rate, varied_angle);
  if (time_passes)
    at_step.grow(growth);
  else if (!repeats)
    at_step.stand();
  means_are_known = means_are_known || time_passes;
  modify->addstep_compute(update->ntimestep + 1);
}

EllgranWallMotion FixWallGranEllipsoid::motion_now(bool time_passes)
{
  EllgranWallMotion motion = ELLGRAN_INIT(EllgranWallMotion);
  const double time = time_passed();
  if (wiggles) {
    const double rate = TWO_PI / period;
    const double phase = rate * time;
    motion.displacement[motion_axis] = amplitude * (1.0 - std::cos(phase));
    // As the grains' velocities, that of the wall is the one that brought it here in this step.
    const bool by_step = time_passes || (sees_velocities_of_step && time > 0.0);
    motion.velocity[motion_axis] = (by_step && time_step > 0.0)
        ? 2.0 * amplitude * std::sin(phase - 0.5 * rate * time_step) *
            std::sin(0.5 * rate * time_step) / time_step
        : amplitude * rate * std::sin(phase);
    if (sees_velocities_of_step)
      motion.velocity_change[motion_axis] = amplitude * rate * std::sin(phase) - motion.velocity[motion_axis];
  }
  if (shears) motion.velocity[motion_axis] = shear_velocity;
  follow_variables(time_passes);
  const bool by_variables = varies();
  if (moves)
    for (int k = 0; k < 3; k++) {
      motion.displacement[k] = by_variables ? varied_displacement[k] : velocity[k].constant() * time;
      motion.velocity[k] = by_variables ? mean_velocity[k] : velocity[k].constant();
    }
  if (servo) {
    if (time_passes) servo->advance(update->dt);
    for (int k = 0; k < 3; k++) {
      motion.displacement[k] += servo->displacement() * servo->direction()[k];
      motion.velocity[k] += servo->velocity() * servo->direction()[k];
    }
  }
  if (rotates) {
    const double rate = by_variables ? mean_rate : rotation_rate.constant();
    const double angle = by_variables ? varied_angle : rate * time;
    // whole turns are none
    quaternion_of(rotation_axis, std::remainder(angle, TWO_PI), motion.quaternion);
    for (int k = 0; k < 3; k++) {
      motion.origin[k] = rotation_point[k];
      motion.angular_velocity[k] = rate * rotation_axis[k];
    }
  }
  if (by_variables) add_change_at_step(motion, rotation_axis);
  if (!region_id.empty()) add_region_motion(motion, time_passes);
  return motion;
}

Region *FixWallGranEllipsoid::present_region() const
{
  Region *const region = domain->get_region_by_id(region_id);
  if (!region) error->all(FLERR, "{} {}: region {} does not exist any more", CALLER, id, region_id);
  return region;
}

/* The velocities are those over the step; where no step was made since the fix is there, none. */

void FixWallGranEllipsoid::add_region_motion(EllgranWallMotion &motion, bool time_passes)
{
  Region *const region = present_region();
  if (!region->dynamic) return;
  const RegionPose now = region_pose(lmp, region);
  if (time_passes && pose_is_known && update->dt > 0.0) {
    const double dt = update->dt;
    // From the middle of the last step to that of this one, as if to its end from its begin.
    const double to_end = (region_step > 0.0) ? 2.0 * dt / (dt + region_step) : 0.0;
    double growth[WallVelocityAtStep::COUNT];
    const auto follow = [&](double way, double &mean) {
      const double before = mean;
      mean = way / dt;
      return to_end * (mean - before);
    };
    for (int k = 0; k < 3; k++) growth[k] = follow(now.displacement[k] - pose.displacement[k], region_velocity[k]);
    growth[3] = follow(now.angle - pose.angle, region_rate);
    at_step.grow(growth);
    region_step = dt;
  }
  pose = now;
  pose_is_known = true;
  quaternion_of(now.axis, std::remainder(now.angle, TWO_PI), motion.quaternion);
  for (int k = 0; k < 3; k++) {
    motion.origin[k] = now.point[k];
    motion.displacement[k] = now.displacement[k];
    motion.velocity[k] = region_velocity[k];
    motion.angular_velocity[k] = region_rate * now.axis[k];
  }
  add_change_at_step(motion, now.axis);
}

void FixWallGranEllipsoid::add_change_at_step(EllgranWallMotion &motion, const double *axis) const
{
  if (!sees_velocities_of_step) return;
  const double *const change = at_step.change();
  for (int k = 0; k < 3; k++) {
    motion.velocity_change[k] += change[k];
    motion.angular_velocity_change[k] += change[3] * axis[k];
  }
}

void FixWallGranEllipsoid::post_integrate()
{
  if (!touches_here || !sums_energies) return;
  EllgranStep step = ELLGRAN_INIT(EllgranStep);
  step.time_step = update->dt;
  step.advance_history = 1;
  EllgranParticles particles = atoms.view();
  if (velocities_of_step) velocities_of_step->lend_changes(particles, false);
  // The wall's part follows when its velocity is known.
  if (sees_velocities_of_step) tallies.wall_powers[0] = tallies.wall_powers[1] = 0.0;
  if (ellgran_wall_tally_following_half_step(wall, &particles, &step, &tallies) != ELLGRAN_SUCCESS)
    error->one(FLERR, "{} {}: {}", CALLER, id, ellgran_last_error());
  atoms.require_finite(tallies.viscous_dissipation, tallies.tangential_work);
}

/* Half of the work of a force is done with the velocity to which it has led. */

void FixWallGranEllipsoid::add_work_since_last_forces(const EllgranWallMotion &motion)
{
  const auto work = [&](const double *force, const double *torque) {
    return 0.5 * update->dt * (dot(force, motion.velocity) + dot(torque, motion.angular_velocity));
  };
  work_of_walls -= work(last_load.force, last_load.torque);
  if (!sees_velocities_of_step || !sums_energies) return;
  tallies.viscous_dissipation -= work(last_load.viscous_force, last_load.viscous_torque);
  tallies.tangential_work -= work(last_load.tangential_force, last_load.tangential_torque);
}

void FixWallGranEllipsoid::post_force(int vflag)
{
  v_init(vflag);
  find_contact_masses();

  // Time does not pass when LAMMPS computes forces anew at the start of a run or minimises.
  const bool time_passes = update->setupflag == 0 && update->whichflag != 2;
  follow_time(time_passes);
  const EllgranWallMotion motion = motion_now(time_passes);
  motion_of_forces = motion;
  has_forces = true;
  std::copy_n(motion.displacement, 3, displacement);
  std::copy_n(motion.velocity, 3, wall_velocity);
  if (time_passes) add_work_since_last_forces(motion);
  EllgranWallLoad load = ELLGRAN_INIT(EllgranWallLoad);
  const bool writes_triangles = triangle_file_every > 0 && update->ntimestep % triangle_file_every == 0;
  check(ellgran_wall_record_triangles(wall, writes_triangles ? 1 : 0));
  const bool records = tells_contacts || (contacts_wanted && computes_ask_for_contacts(modify, update->ntimestep));
  check(ellgran_wall_record_contacts(wall, records ? 1 : 0));
  step_of_contacts = records ? update->ntimestep : -1;
  tallies.normal_elastic_energy = tallies.tangential_elastic_energy = tallies.touching_count = 0.0;

  EllgranStep step = ELLGRAN_INIT(EllgranStep);
  step.time_step = update->dt;
  step.advance_history = time_passes ? 1 : 0;

  if (atom->nlocal > 0) {
    EllgranParticles particles = atoms.view();
    if (velocities_of_step) velocities_of_step->lend_changes(particles, false);
    if (fix_step_velocity) fix_step_velocity->replace_velocities(particles, false);
    if (!contact_masses.empty()) particles.contact_masses = contact_masses.data();
    // LAMMPS brings atoms, moves and sorts them when it builds neighbour lists; commands may change them, their shapes and their groups before a
    // run, which begins with an evaluation in which no time passes, or with its first step ('run ... pre no', 'run ... every').
    const bool follows_last_step =
        step_of_forces + 1 == update->ntimestep && neighbor->ago > 0 && update->ntimestep != update->firststep + 1;
    particles.unchanged = (time_passes && follows_last_step && !scene_may_change) ? 1 : 0;
    if (time_passes && pair) particles.prepared_by = pair->prepared_in(update->ntimestep);
    // Energies that nobody asked for stand still.
    EllgranTallies virial_alone = ELLGRAN_INIT(EllgranTallies);
    EllgranTallies *const asked = sums_energies ? &tallies : evflag ? &virial_alone : nullptr;
    if (asked) asked->particle_virials = vflag_atom ? vatom[0] : nullptr;
    check(ellgran_compute_wall(laws, workspace, wall, &particles, atom->mask, groupbit, wall_type, &motion,
                               contact_histories ? contact_histories[0] : nullptr, &step, &load, asked));
    if (vflag_global)
      for (int k = 0; k < 6; k++) virial[k] += asked->virial[k];
    // LAMMPS may move the array.
    tallies.particle_virials = nullptr;
  }
  touches_here = load.contact_count > 0;
  step_of_forces = update->ntimestep;
  if (tells_contacts) tell_contacts();
  if (writes_triangles) write_triangle_file(motion);
  if (servo) servo->follow(load, update->dt, time_passes);

  // Friction has dissipated the work of the tangential forces less what the contacts hold of it.
  if (step.advance_history)
    friction = tallies.tangential_work - tallies.tangential_elastic_energy;
  else
    tallies.tangential_work = friction + tallies.tangential_elastic_energy;

  if (step.advance_history) work_of_walls -= 0.5 * step.time_step * load.power;
  last_load = load;

  // Until here a variable of this wall that reads what it puts out has had that of the step before.
  std::fill_n(output_here, static_cast<int>(NUMBER_OF_SUMS), 0.0);
  summed = false;
  for (int k = 0; k < 2; k++)
    if (plane_slots[k] >= 0 && atom->nlocal > 0)
      check(ellgran_wall_part_force(wall, plane_slots[k], output_here + (k == 0 ? FORCE_LO : FORCE_HI)));
  std::copy_n(load.force, 3, output_here + FORCE);
  std::copy_n(load.torque, 3, output_here + TORQUE);
  output_here[POWER] = -load.power;
  output_here[NORMAL_ELASTIC] = tallies.normal_elastic_energy;
  output_here[TANGENTIAL_ELASTIC] = tallies.tangential_elastic_energy;
  output_here[VISCOUS_DISSIPATION] = tallies.viscous_dissipation;
  output_here[FRICTIONAL_DISSIPATION] = friction;
  output_here[DISSIPATED] = output_here[VISCOUS_DISSIPATION] + output_here[FRICTIONAL_DISSIPATION];
  output_here[TOUCHING] = static_cast<double>(load.contact_count);
  output_here[WORK_OF_WALLS] = work_of_walls;
}

/* The wall is where forces were computed last. Before the first ones it is where its motion has it, if no variable has to be asked,
   which may not be ready then. */

void FixWallGranEllipsoid::add_to_step_sums(const EllgranParticles &particles, double *sums, EllgranContactExtremes *extremes)
{
  if (!has_forces) {
    if (varies() || (!region_id.empty() && present_region()->dynamic)) return;
    follow_time(false);
    motion_of_forces = motion_now(false);
  }
  if (atom->nlocal == 0) return;
  check(ellgran_find_wall_contacts(workspace, wall, &particles, atom->mask, groupbit, &motion_of_forces, 0, nullptr));
  const std::vector<int32_t> types(ellgran_wall_found_count(wall), wall_type);
  check(ellgran_add_wall_to_step_sums(laws, workspace, wall, &particles, types.data(), sums, extremes));
}

void FixWallGranEllipsoid::add_to_grain_sums(double *sums) const
{
  check(ellgran_add_wall_recorded_to_grain_sums(wall, atom->nlocal, sums));
}

/* One row for each contact of this rank. */

void FixWallGranEllipsoid::tell_contacts()
{
  const std::size_t rows = (atom->nlocal > 0) ? ellgran_wall_recorded_count(wall) : 0;
  contact_values.resize(rows * CONTACT_COLUMNS);
  contact_rows.resize(rows);
  for (std::size_t row = 0; row < rows; row++) {
    EllgranRecordedWallContact contact = ELLGRAN_INIT(EllgranRecordedWallContact);
    check(ellgran_wall_recorded(wall, row, &contact));
    double *next = contact_rows[row] = &contact_values[row * CONTACT_COLUMNS];
    *next++ = static_cast<double>(atom->tag[contact.particle]);
    *next++ = static_cast<double>(contact.part + 1);
    next = std::copy_n(contact.point, 3, next);
    next = std::copy_n(contact.normal, 3, next);
    *next++ = contact.penetration;
    *next++ = contact.normal_force;
    next = std::copy_n(contact.tangential_force, 3, next);
    next = std::copy_n(contact.force, 3, next);
    next = std::copy_n(contact.torque, 3, next);
    std::copy_n(contact.elastic_energy, 2, next);
  }
  size_local_rows = static_cast<int>(rows);
  array_local = contact_rows.data();
}

/* The loads of all ranks, written by the first. */

void FixWallGranEllipsoid::write_triangle_file(const EllgranWallMotion &motion)
{
  const std::size_t count = 4 * ellgran_wall_triangle_count(wall);
  std::vector<double> loads(count, 0.0), sums(count, 0.0);
  if (atom->nlocal > 0) check(ellgran_wall_triangle_loads(wall, loads.data()));
  MPI_Reduce(loads.data(), sums.data(), static_cast<int>(count), MPI_DOUBLE, MPI_SUM, 0, world);
  if (comm->me != 0) return;
  std::string file = triangle_file;
  file.replace(file.find('*'), 1, std::to_string(update->ntimestep));
  check(ellgran_wall_write_triangle_loads(wall, &motion, sums.data(), file.c_str()));
}

void FixWallGranEllipsoid::find_contact_masses()
{
  if (!fix_rigid || ellgran_laws_uses_mass(laws) == 0) {
    contact_masses.clear();
    return;
  }
  // Atoms move between ranks only when neighbour lists are built.
  if (neighbor->ago != 0 && !contact_masses.empty()) return;
  int rank;
  const auto *body = static_cast<int *>(fix_rigid->extract("body", rank));
  const auto *body_masses = static_cast<double *>(fix_rigid->extract("masstotal", rank));
  contact_masses.assign(atom->rmass, atom->rmass + atom->nlocal + atom->nghost);
  if (body && body_masses)
    for (int i = 0; i < atom->nlocal; i++)
      if (body[i] >= 0) contact_masses[i] = body_masses[body[i]];
}

void FixWallGranEllipsoid::sum_output()
{
  if (summed) return;
  MPI_Allreduce(output_here, output_all, NUMBER_OF_SUMS, MPI_DOUBLE, MPI_SUM, world);
  summed = true;
}

bool FixWallGranEllipsoid::energies_wanted() const
{
  if (leaves_energies_out) return false;
  return keeps_energies || thermo_energy || computes_ask_for_energies(modify);
}

/* Whoever asks for energies that are not summed up gets a message and no zero. */

void FixWallGranEllipsoid::require_energies(const std::string &value) const
{
  if (sums_energies || !has_forces) return;
  const char *const reason = leaves_energies_out ? "with 'energies no'" : "where no compute pair or energy/ellipsoid exists as a run starts";
  error->all(FLERR, "{} {}: f_{}{} is an energy, which the fix does not sum up {}: use 'energies yes'", CALLER, id, id, value, reason);
}

double FixWallGranEllipsoid::compute_scalar()
{
  require_energies("");
  sum_output();
  return output_all[NORMAL_ELASTIC] + output_all[TANGENTIAL_ELASTIC];
}

double FixWallGranEllipsoid::compute_vector(int k)
{
  if (k >= SERVO_FORCE) {
    if (!servo) return 0.0;
    return (k == SERVO_FORCE) ? servo->force() : servo->target();
  }
  if (k >= VELOCITY) return wall_velocity[k - VELOCITY];
  if (k >= DISPLACEMENT) return displacement[k - DISPLACEMENT];
  const bool is_dissipation = k == DISSIPATED || k == VISCOUS_DISSIPATION || k == FRICTIONAL_DISSIPATION;
  if (is_dissipation || k == NORMAL_ELASTIC || k == TANGENTIAL_ELASTIC) require_energies(fmt::format("[{}]", k + 1));
  sum_output();
  return output_all[k];
}

/* This rank's share. */

void *FixWallGranEllipsoid::extract(const char *name, int &dimension_of)
{
  dimension_of = 0;
  if (std::strcmp(name, "leaves_energies_out") == 0) return &leaves_energies_out;
  if (std::strcmp(name, "normal_elastic_energy") == 0) return &tallies.normal_elastic_energy;
  if (std::strcmp(name, "tangential_elastic_energy") == 0) return &tallies.tangential_elastic_energy;
  if (std::strcmp(name, "viscous_dissipation") == 0) return &tallies.viscous_dissipation;
  if (std::strcmp(name, "frictional_dissipation") == 0) return &friction;
  if (std::strcmp(name, "work_of_walls") == 0) return &work_of_walls;
  return nullptr;
}

double FixWallGranEllipsoid::memory_usage()
{
  double bytes = static_cast<double>(ellgran_workspace_bytes(workspace));
  bytes += static_cast<double>(contact_masses.capacity()) * sizeof(double);
  bytes += static_cast<double>(contact_values.capacity()) * sizeof(double);
  return bytes + static_cast<double>(atom->nmax) * histories_length * sizeof(double);
}

void FixWallGranEllipsoid::grow_arrays(int nmax)
{
  if (histories_length > 0) memory->grow(contact_histories, nmax, histories_length, "wall/gran/ellipsoid:contact_histories");
}

void FixWallGranEllipsoid::copy_arrays(int i, int j, int)
{
  if (histories_length > 0) std::copy_n(contact_histories[i], histories_length, contact_histories[j]);
}

void FixWallGranEllipsoid::set_arrays(int i)
{
  if (histories_length > 0) std::fill_n(contact_histories[i], histories_length, 0.0);
}

/* What of an atom's histories is in use, and its length before it. */

int FixWallGranEllipsoid::pack_exchange(int i, double *buffer)
{
  if (histories_length == 0) return 0;
  const int used = static_cast<int>(ellgran_wall_histories_used(wall, laws, contact_histories[i]));
  buffer[0] = used;
  std::copy_n(contact_histories[i], used, buffer + 1);
  return 1 + used;
}

int FixWallGranEllipsoid::unpack_exchange(int nlocal, double *buffer)
{
  if (histories_length == 0) return 0;
  const int used = static_cast<int>(buffer[0]);
  double *const end = std::copy_n(buffer + 1, used, contact_histories[nlocal]);
  std::fill(end, contact_histories[nlocal] + histories_length, 0.0);
  return 1 + used;
}

int FixWallGranEllipsoid::size_restart(int i)
{
  if (histories_length == 0) return 0;
  return 3 + static_cast<int>(ellgran_wall_histories_used(wall, laws, contact_histories[i]));
}

int FixWallGranEllipsoid::maxsize_restart()
{
  return (histories_length == 0) ? 0 : 3 + histories_length;
}

int FixWallGranEllipsoid::pack_restart(int i, double *buffer)
{
  if (histories_length == 0) return 0;
  const int packed = pack_exchange(i, buffer + 1);
  buffer[1 + packed] = ubuf(atom->tag[i]).d;
  buffer[0] = 2 + packed;
  return 2 + packed;
}

void FixWallGranEllipsoid::unpack_restart(int nlocal, int nth)
{
  if (histories_length == 0) return;
  double *extra = atom->extra[nlocal];
  for (int k = 0; k < nth; k++) extra += static_cast<int>(*extra);
  const int length = static_cast<int>(extra[0]) - (has_ids_of_file ? 1 : 0);
  if (has_ids_of_file && length > 0)
    require_atom_of_file(lmp, std::string(CALLER) + " " + id, nlocal, static_cast<tagint>(ubuf(extra[length]).i));
  if (histories_are_of_other_law || wall_turns_back) {
    FixWallGranEllipsoid::set_arrays(nlocal);
    return;
  }
  const int used = length - 2;
  if (used < 0 || used > histories_length || extra[1] != used)
    error->one(FLERR,
               "{} {}: the restart file keeps other values per contact: give the fix the law and the wall that it had, or "
               "another ID; if atoms were added since read_restart, give it before them",
               CALLER, id);
  unpack_exchange(nlocal, extra + 1);
}

/* What says where the wall is after some time; of a motion by variables its way is summed up, whatever they are. */

FixWallGranEllipsoid::MotionWords FixWallGranEllipsoid::motion_words() const
{
  MotionWords words = {};
  words[MOVES_BY_WORDS] = (wiggles ? 1.0 : 0.0) + (moves ? 2.0 : 0.0) + (rotates ? 4.0 : 0.0);
  words[TURNS] = rotates ? 1.0 : 0.0;
  words[VARIES] = varies() ? 1.0 : 0.0;
  if (wiggles) {
    words[WIGGLE] = motion_axis;
    words[WIGGLE + 1] = amplitude;
    words[WIGGLE + 2] = period;
  }
  if (moves && !varies())
    for (int k = 0; k < 3; k++) words[CONSTANT_VELOCITY + k] = velocity[k].constant();
  if (rotates) {
    std::copy_n(rotation_point, 3, words.data() + ROTATION_POINT);
    std::copy_n(rotation_axis, 3, words.data() + ROTATION_AXIS);
    if (!varies()) words[CONSTANT_RATE] = rotation_rate.constant();
  }
  if (servo) {
    words[HAS_SERVO] = 1.0;
    std::copy_n(servo->direction(), 3, words.data() + SERVO_DIRECTION);
  }
  return words;
}

bool FixWallGranEllipsoid::has_motion_of(const MotionWords &words) const
{
  return has_words(words, 0, HAS_SERVO);
}

bool FixWallGranEllipsoid::has_servo_of(const MotionWords &words) const
{
  return has_words(words, HAS_SERVO, NUMBER_OF_WORDS);
}

bool FixWallGranEllipsoid::has_words(const MotionWords &words, int first, int last) const
{
  const MotionWords mine = motion_words();
  for (int k = first; k < last; k++)
    if (!(std::fabs(mine[k] - words[k]) <= SAME_WORDS * std::max(std::fabs(mine[k]), std::fabs(words[k])))) return false;
  return true;
}

void FixWallGranEllipsoid::write_restart(FILE *fp)
{
  double mine[3] = {tallies.viscous_dissipation, friction, work_of_walls};
  double sums[3] = {0.0, 0.0, 0.0};
  MPI_Allreduce(mine, sums, 3, MPI_DOUBLE, MPI_SUM, world);
  if (comm->me == 0) {
    double values[NUMBER_OF_STATES] = {-EllgranRestart::WALL_FORMAT, sums[0], time_passed(),
                                       sums[1],            sums[2],           region_velocity[0],
                                       region_velocity[1], region_velocity[2], region_rate};
    double *const of_motion = std::copy_n(varied_displacement, 3, values + NUMBER_WITH_REGION);
    of_motion[0] = varied_angle;
    if (servo) servo->pack(of_motion + 1);
    double law[1 + 2 * VALUES_OF_LAW] = {sizeof(law_words)};
    std::memcpy(law + 1, &law_words, sizeof(law_words));
    std::memcpy(law + 1 + VALUES_OF_LAW, &wall_words, sizeof(wall_words));
    const double means[NUMBER_OF_MEANS] = {means_are_known ? 1.0 : 0.0, mean_velocity[0], mean_velocity[1], mean_velocity[2], mean_rate};
    double of_step[NUMBER_AT_STEP];
    at_step.pack(of_step);
    of_step[WallVelocityAtStep::NUMBER_OF_STATES] = region_step;
    const MotionWords words = motion_words();
    const int size = sizeof(values) + sizeof(means) + sizeof(of_step) + sizeof(words) + sizeof(law);
    fwrite(&size, sizeof(int), 1, fp);
    fwrite(values, sizeof(double), NUMBER_OF_STATES, fp);
    fwrite(means, sizeof(double), NUMBER_OF_MEANS, fp);
    fwrite(of_step, sizeof(double), NUMBER_AT_STEP, fp);
    fwrite(words.data(), sizeof(double), words.size(), fp);
    fwrite(law, sizeof(double), 1 + 2 * VALUES_OF_LAW, fp);
  }
}

void FixWallGranEllipsoid::restart(char *buffer)
{
  double mark, values[NUMBER_OF_STATES - 1];
  std::memcpy(&mark, buffer, sizeof(mark));
  const int format = (mark < 0.0) ? static_cast<int>(-mark) : 1;
  if (format > EllgranRestart::WALL_FORMAT)
    error->all(FLERR,
               "{} {}: the restart file has format version {} of this fix. This is ellgran {}, which reads versions 1 to {}: use "
               "the ellgran that wrote the file, or give the fix another ID and lose what its contacts remember",
               CALLER, id, format, ellgran_version(), EllgranRestart::WALL_FORMAT);
  const bool has_region = format >= 2;
  const bool has_motion = format >= 3;
  if (has_region)
    std::memcpy(values, buffer + sizeof(mark), ((has_motion ? NUMBER_OF_STATES : NUMBER_WITH_REGION) - 1) * sizeof(double));
  else
    std::memcpy(values, buffer, 4 * sizeof(double));
  step_then = last_step = update->ntimestep;
  if (has_region) {
    std::copy_n(values + 4, 3, region_velocity);
    region_rate = values[7];
  }
  const char *further = buffer + NUMBER_OF_STATES * sizeof(double);
  double means[NUMBER_OF_MEANS] = {}, of_step[NUMBER_AT_STEP] = {};
  if (format >= 5) {
    std::memcpy(means, further, sizeof(means));
    further += sizeof(means);
  }
  if (format >= 6) {
    std::memcpy(of_step, further, sizeof(of_step));
    further += sizeof(of_step);
    region_step = of_step[WallVelocityAtStep::NUMBER_OF_STATES];
  }
  has_ids_of_file = format >= 8;
  MotionWords words = motion_words();    // files of older versions are taken to have the present ones
  if (format >= 8) {
    std::memcpy(words.data(), further, sizeof(words));
    further += sizeof(words);
  }
  const bool goes_on = has_motion_of(words), servo_goes_on = has_servo_of(words);
  if (goes_on) {
    time_then = values[1];
    if (has_motion) {
      const double *const of_motion = values + NUMBER_WITH_REGION - 1;
      std::copy_n(of_motion, 3, varied_displacement);
      varied_angle = of_motion[3];
    }
    means_are_known = means[0] != 0.0;
    std::copy_n(means + 1, 3, mean_velocity);
    mean_rate = means[4];
    if (format >= 6) at_step.unpack(of_step);
  }
  if (servo && servo_goes_on && has_motion) servo->unpack(values + NUMBER_WITH_REGION - 1 + 4);
  const bool was_moved = !goes_on && (words[MOVES_BY_WORDS] != 0.0 && values[1] > 0.0);
  // What contacts remember is in the frame of the wall, which turns back.
  wall_turns_back = was_moved && words[TURNS] != 0.0;
  if ((was_moved || (!servo_goes_on && words[HAS_SERVO] != 0.0)) && comm->me == 0)
    error->warning(FLERR,
                   "{} {}: the wall of the restart file had another motion, of which nothing goes on: the wall begins where the words of this fix "
                   "place it{}",
                   CALLER, id, wall_turns_back ? ", and contacts that exist start with no tangential displacement" : "");
  if (format >= 4) compare_with_law_of_file(further, format >= 7);
  if (comm->me != 0) return;
  tallies.viscous_dissipation = values[0];
  friction = values[2];
  work_of_walls = values[3];
}

/* What contacts remember in the file is read under the law with which it was written, or one under which it means the same. Called before the
   histories are read. */

void FixWallGranEllipsoid::compare_with_law_of_file(const char *buffer, bool has_law_of_wall)
{
  double size = 0.0;
  std::memcpy(&size, buffer, sizeof(size));
  EllgranLawParameters of_file = ELLGRAN_INIT(EllgranLawParameters);
  const std::size_t own_size = of_file.size;
  if (!(size > sizeof(std::size_t) && size <= own_size))
    error->all(FLERR, "{} {}: the restart file is damaged: a law of {} bytes", CALLER, id, size);
  // An older and shorter struct: the fields that it lacks are zero, as everywhere in the interface.
  const auto bytes = static_cast<std::size_t>(size);
  std::memcpy(&of_file, buffer + sizeof(size), bytes);
  of_file.size = own_size;
  // Between two materials a contact may remember more than within one. Older files do not have that of the wall: it is the one that the fix has now.
  EllgranLawParameters of_wall = has_material ? wall_words : of_file;
  if (has_law_of_wall) {
    const std::size_t values = (bytes + sizeof(double) - 1) / sizeof(double);
    of_wall = ELLGRAN_INIT(EllgranLawParameters);
    std::memcpy(&of_wall, buffer + (1 + values) * sizeof(double), bytes);
    of_wall.size = own_size;
  }
  EllgranLaws *before = nullptr;
  const int32_t status = make_laws(of_file, of_wall, &before);
  // The wall's present material need not go with the law of an older file.
  if (status != ELLGRAN_SUCCESS && (has_law_of_wall || make_laws(of_file, of_file, &before) != ELLGRAN_SUCCESS))
    error->all(FLERR, "{} {}: the restart file is damaged: {}", CALLER, id, ellgran_last_error());
  histories_are_of_other_law = histories_length > 0 && ellgran_laws_history_length(before) > 0 && ellgran_laws_read_histories_of(laws, before) == 0;
  ellgran_laws_free(before);
  if (histories_are_of_other_law && comm->me == 0)
    error->warning(FLERR,
                   "{} {}: the restart file is of a law under which contacts remember something else: contacts that exist start with no "
                   "tangential displacement",
                   CALLER, id);
}

void FixWallGranEllipsoid::set_molecule(int, tagint, int, double *, double *, double *)
{
  error->all(FLERR, "Molecule update not implemented for fix {}", style);
}
