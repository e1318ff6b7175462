// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_grain_placement.h"

#include "ellgran_region.h"

#include "atom.h"
#include "atom_vec.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "irregular.h"
#include "math_extra.h"
#include "modify.h"
#include "region.h"

#include <mpi.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;

namespace {

// What a region gives for INF is beyond any coordinate.
constexpr double INFINITE = 1e20;

// A region that reaches beyond the box by less than this part of the box does so by rounding.
constexpr double ROUNDING = 1e-10;

// Bodies that are apart by less than this part of what they reach may touch by rounding: the contact search tells.
constexpr double NEARLY = 1e-9;

// Most cells along an axis: a memory of some ten megabytes.
constexpr int MOST_CELLS = 100;

// The volume of a region without a formula: how many points tell it, and the root of x^4 = x + 1, of whose inverse powers multiples fill a
// cube evenly without lying in planes that the faces of a region could fall between (M. Roberts' sequence R3).
constexpr int VOLUME_POINTS = 1 << 21;
constexpr double EVENLY = 1.2207440846057595;

// A grain that overlaps a body deeply, across an edge or a tip, may have no place where the surfaces are nearest to each other. Smaller grains about
// the same centre do, down to one that the body only just reaches.
constexpr double SHRINKING = 0.95, LEAST_SCALE = 0.01;

double square_of_distance(const double *a, const double *b)
{
  double sum = 0.0;
  for (int k = 0; k < 3; k++) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return sum;
}

bool has_parts(const Region *region)
{
  return std::strcmp(region->style, "union") == 0 || std::strcmp(region->style, "intersect") == 0;
}

// Whether grains lie around a part of it, and not within all of them.
bool surrounds_bodies(const Region *region, bool flipped)
{
  const bool inside = (region->interior != 0) != flipped;
  if (!has_parts(region)) return !inside;
  for (int k = 0; k < region->nregion; k++)
    if (surrounds_bodies(region->reglist[k], !inside)) return true;
  return false;
}

// Whether an ellipsoid reaches into a block: x A x, less than 1 within the ellipsoid, has its least value over the block where each
// coordinate is at one of its bounds or free.
bool reaches_block(const EllgranGrain &grain, const double *position, const std::array<double, 6> &bounds)
{
  double rotation[3][3], form[3][3] = {};
  MathExtra::quat_to_mat(grain.quaternion, rotation);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      for (int m = 0; m < 3; m++) form[i][j] += rotation[i][m] * rotation[j][m] / (grain.semi_axes[m] * grain.semi_axes[m]);
  double low[3], high[3];
  for (int k = 0; k < 3; k++) {
    low[k] = bounds[k] - position[k];
    high[k] = bounds[3 + k] - position[k];
  }
  for (int state = 0; state < 27; state++) {
    const int states[3] = {state % 3, state / 3 % 3, state / 9};
    double x[3] = {}, matrix[3][3], wanted[3], inverse[3][3];
    for (int i = 0; i < 3; i++)
      if (states[i] != 2) x[i] = (states[i] == 0) ? low[i] : high[i];
    // Rows of the free ones: the slope is 0. Rows of the others: they are where they are.
    for (int i = 0; i < 3; i++) {
      const bool free = states[i] == 2;
      wanted[i] = free ? 0.0 : x[i];
      for (int j = 0; j < 3; j++) {
        matrix[i][j] = free ? form[i][j] : (i == j ? 1.0 : 0.0);
        if (free && states[j] != 2) {
          matrix[i][j] = 0.0;
          wanted[i] -= form[i][j] * x[j];
        }
      }
    }
    MathExtra::invert3(matrix, inverse);
    MathExtra::matvec(inverse, wanted, x);
    bool is_in_block = true;
    double value = 0.0;
    for (int i = 0; i < 3; i++) {
      is_in_block &= states[i] != 2 || (x[i] >= low[i] && x[i] <= high[i]);
      for (int j = 0; j < 3; j++) value += x[i] * form[i][j] * x[j];
    }
    if (is_in_block && value < 1.0) return true;
  }
  return false;
}

}    // namespace

EllgranGrainPlacement::EllgranGrainPlacement(LAMMPS *lmp, const std::string &caller_name) :
    Pointers(lmp), caller(caller_name), atoms(lmp, caller_name)
{
  if (ellgran_abi_version() != ELLGRAN_ABI_VERSION)
    error->all(FLERR, "{}: compiled for ABI version {} of ellgran, but linked with version {}", caller,
               static_cast<int>(ELLGRAN_ABI_VERSION), static_cast<int>(ellgran_abi_version()));
}

EllgranGrainPlacement::~EllgranGrainPlacement()
{
  ellgran_wall_free(wall);
  ellgran_laws_free(wall_laws);
  ellgran_workspace_free(workspace);
}

void EllgranGrainPlacement::check(int32_t status) const
{
  if (status != ELLGRAN_SUCCESS) error->all(FLERR, "{}: {}", caller, ellgran_last_error());
}

void EllgranGrainPlacement::require_scene() const
{
  if (!domain->box_exist) error->all(FLERR, "{}: there is no simulation box: give create_box or read_data first", caller);
  if (domain->dimension == 2)
    error->all(FLERR, "{}: dimension 2 is not supported, since contacts are those of ellipsoids, not of discs: use dimension 3 "
                      "with a box that is thin and periodic in one direction", caller);
  if (domain->triclinic)
    error->all(FLERR, "{}: triclinic boxes are not supported: insert before 'change_box all triclinic'", caller);
  atoms.require_atom_style();
}

void EllgranGrainPlacement::set_region(Region *given, bool whole_grains)
{
  region = given;
  whole = whole_grains;
  if (region->dynamic_check() || region->varshape)
    error->all(FLERR, "{}: region {} moves or changes: give one that does neither", caller, region->id);
  require_closed(region);
  find_bounds();
  find_volume();
  make_wall();
}

/* LAMMPS finds every point within a region that has an open face. */

void EllgranGrainPlacement::require_closed(const Region *part) const
{
  if (part->openflag)
    error->all(FLERR, "{}: region {} has open faces, and for LAMMPS every point of the box is in it: define another region for the insertion, "
                      "of the same measures without 'open'", caller, part->id);
  for (int k = 0; has_parts(part) && k < part->nregion; k++) require_closed(part->reglist[k]);
}

void EllgranGrainPlacement::find_bounds()
{
  const double extent[2][3] = {{region->extent_xlo, region->extent_ylo, region->extent_zlo},
                               {region->extent_xhi, region->extent_yhi, region->extent_zhi}};
  for (int k = 0; k < 3; k++)
    for (int side = 0; side < 2; side++) {
      const double edge = (side == 0) ? domain->boxlo[k] : domain->boxhi[k];
      double &mine = bound[side][k];
      mine = edge;
      // Without a bounding box, as outside of a body, it ends where the simulation box does.
      if (!region->bboxflag || std::fabs(extent[side][k]) >= INFINITE) continue;
      const double beyond = (side == 0) ? edge - extent[side][k] : extent[side][k] - edge;
      const bool box_grows = domain->boundary[k][side] > 1;
      if (beyond > ROUNDING * domain->prd[k] && !box_grows)
        error->all(FLERR, "{}: region {} extends outside the simulation box: {} {} is {}, the box ends at {}: make the region "
                          "smaller, or the box larger", caller, region->id, "xyz"[k], (side == 0) ? "lo" : "hi", extent[side][k],
                   edge);
      if (beyond <= 0.0 || box_grows) mine = extent[side][k];
    }
}

void EllgranGrainPlacement::find_volume()
{
  region_volume = volume_of_region(region, bound[0], bound[1]);
  if (region_volume >= 0.0) return;
  region->prematch();
  int count = 0;
  double share[3] = {0.5, 0.5, 0.5}, step[3], point[3], volume = 1.0;
  for (int k = 0; k < 3; k++) {
    step[k] = std::pow(EVENLY, -(k + 1));
    volume *= bound[1][k] - bound[0][k];
  }
  for (int n = 0; n < VOLUME_POINTS; n++) {
    for (int k = 0; k < 3; k++) {
      share[k] += step[k];
      if (share[k] >= 1.0) share[k] -= 1.0;
      point[k] = bound[0][k] + share[k] * (bound[1][k] - bound[0][k]);
    }
    count += region->match(point[0], point[1], point[2]) ? 1 : 0;
  }
  region_volume = volume * count / VOLUME_POINTS;
}

void EllgranGrainPlacement::add_plane(int axis, double position, double direction)
{
  EllgranWallShape shape = ELLGRAN_INIT(EllgranWallShape);
  shape.name = "plane";
  shape.point[axis] = position;
  shape.axis[axis] = direction;
  shape.side = ELLGRAN_SIDE_INSIDE;
  check(ellgran_wall_add_shape(wall, &shape));
}

void EllgranGrainPlacement::make_wall()
{
  ellgran_wall_free(wall);
  wall = nullptr;
  if (!whole) return;
  bodies = surrounds_bodies(region, false);
  blocks = blocks_within(region);
  check(ellgran_wall_new(&wall));
  const bool block = std::strcmp(region->style, "block") == 0 && region->interior && !region->openflag;
  if (!block) add_region(lmp, caller, region, wall);
  const double extent[2][3] = {{region->extent_xlo, region->extent_ylo, region->extent_zlo},
                               {region->extent_xhi, region->extent_yhi, region->extent_zhi}};
  for (int k = 0; k < 3; k++) {
    const bool across = bound[0][k] <= domain->boxlo[k] && bound[1][k] >= domain->boxhi[k];
    for (int side = 0; side < 2; side++) {
      const bool ends = region->bboxflag && std::fabs(extent[side][k]) < INFINITE;
      // A block has its faces; of other regions the surfaces are there already, and where they are endless the box ends.
      if ((block || !ends) && !(domain->periodicity[k] && across)) add_plane(k, bound[side][k], (side == 0) ? 1.0 : -1.0);
    }
  }
  if (ellgran_wall_part_count(wall) == 0) {
    ellgran_wall_free(wall);
    wall = nullptr;
    return;
  }
  check(ellgran_wall_record_contacts(wall, 1));
  if (!wall_laws) {
    // Any law will do: what is asked for is whether there is a contact.
    const char *const words[] = {"hertz", "1", "0.3"};
    EllgranLawParameters parameters = ELLGRAN_INIT(EllgranLawParameters);
    check(ellgran_law_parameters_parse(3, words, nullptr, &parameters));
    const uint8_t is_set = 1;
    check(ellgran_laws_new(1, &parameters, &is_set, ELLGRAN_OPTION_NO_WARM_START, &wall_laws));
    check(ellgran_workspace_new(&workspace));
  }
  wall_histories.assign(ellgran_wall_histories_length(wall, wall_laws), 0.0);
}

bool EllgranGrainPlacement::touches_wall(const EllgranGrain &grain, const double *reach)
{
  if (!wall) return false;
  // Where a grain sticks out of a periodic boundary it comes in at the other side.
  double shifts[3][2] = {};
  int images[3] = {1, 1, 1};
  for (int k = 0; k < 3; k++) {
    if (!domain->periodicity[k]) continue;
    const double position = grain.position[k];
    if (position - reach[k] < domain->boxlo[k]) shifts[k][images[k]++] = domain->prd[k];
    else if (position + reach[k] > domain->boxhi[k]) shifts[k][images[k]++] = -domain->prd[k];
  }
  for (int i = 0; i < images[0]; i++)
    for (int j = 0; j < images[1]; j++)
      for (int k = 0; k < images[2]; k++) {
        const double *const p = grain.position;
        const double position[3] = {p[0] + shifts[0][i], p[1] + shifts[1][j], p[2] + shifts[2][k] - raised};
        for (const auto &bounds : blocks)
          if (reaches_block(grain, position, bounds)) return true;
        const double least = bodies ? LEAST_SCALE : 1.0;
        for (double scale = 1.0; scale >= least; scale *= SHRINKING)
          if (touches_wall_at(grain, position, scale)) return true;
      }
  return false;
}

bool EllgranGrainPlacement::touches_wall_at(const EllgranGrain &grain, const double *position, double scale)
{
  const double none[3] = {};
  double semi_axes[3];
  for (int k = 0; k < 3; k++) semi_axes[k] = scale * grain.semi_axes[k];
  const double mass = 1.0;
  const int32_t type = 1;
  double force[3] = {}, torque[3] = {};
  EllgranParticles one = ELLGRAN_INIT(EllgranParticles);
  one.owned_count = one.count = 1;
  one.positions = position;
  one.velocities = none;
  one.angular_velocities = none;
  one.masses = &mass;
  one.types = &type;
  one.semi_axes = semi_axes;
  one.semi_axes_stride = sizeof semi_axes;
  one.quaternions = grain.quaternion;
  one.quaternions_stride = sizeof grain.quaternion;
  one.forces = force;
  one.torques = torque;
  const EllgranStep step = ELLGRAN_INIT(EllgranStep);
  std::fill(wall_histories.begin(), wall_histories.end(), 0.0);
  check(ellgran_compute_wall(wall_laws, workspace, wall, &one, nullptr, 0, 1, nullptr,
                             wall_histories.empty() ? nullptr : wall_histories.data(), &step, nullptr, nullptr));
  return ellgran_wall_recorded_count(wall) > 0;
}

/* The periodic images of a box that reach into the cells, itself first. */

template <typename Visit>
void EllgranGrainPlacement::each_image(const double *position, const double *reach, Visit visit) const
{
  int images[3];
  for (int k = 0; k < 3; k++) images[k] = domain->periodicity[k] ? 3 : 1;
  const double shifts[3] = {0.0, -1.0, 1.0};
  for (int i = 0; i < images[0]; i++)
    for (int j = 0; j < images[1]; j++)
      for (int k = 0; k < images[2]; k++) {
        const int index[3] = {i, j, k};
        double there[3];
        bool reaches = true;
        for (int a = 0; a < 3; a++) {
          there[a] = position[a] + shifts[index[a]] * domain->prd[a];
          reaches &= there[a] + reach[a] >= cell_low[a] && there[a] - reach[a] <= cell_low[a] + cell_count[a] * cell_size;
        }
        if (reaches) visit(there);
      }
}

void EllgranGrainPlacement::cells_of(const double *position, const double *reach, int range[3][2]) const
{
  for (int k = 0; k < 3; k++)
    for (int side = 0; side < 2; side++) {
      const double place = (position[k] + (side == 0 ? -reach[k] : reach[k]) - cell_low[k]) / cell_size;
      range[k][side] = static_cast<int>(std::clamp(std::floor(place), 0.0, cell_count[k] - 1.0));
    }
}

void EllgranGrainPlacement::remember(const Present &grain)
{
  each_image(grain.position, grain.reach, [&](const double *there) {
    const auto index = static_cast<int>(present.size());
    present.push_back(grain);
    std::copy_n(there, 3, present.back().position);
    asked.push_back(0);
    int range[3][2];
    cells_of(there, grain.reach, range);
    for (int i = range[0][0]; i <= range[0][1]; i++)
      for (int j = range[1][0]; j <= range[1][1]; j++)
        for (int k = range[2][0]; k <= range[2][1]; k++)
          cells[(static_cast<std::size_t>(i) * cell_count[1] + j) * cell_count[2] + k].push_back(index);
  });
}

void EllgranGrainPlacement::collect(double largest, double typical, double rise, bool ignore_others)
{
  raised = rise;
  for (int k = 0; k < 3; k++)
    if (domain->periodicity[k] && 4.0 * largest > domain->prd[k])
      error->all(FLERR, "{}: a grain of diameter {} is longer than half the periodic box in {}, {}: it could meet a grain twice: "
                        "use smaller grains or a larger box", caller, 2.0 * largest, "xyz"[k], domain->prd[k]);

  double longest = 0.0;
  for (int k = 0; k < 3; k++) {
    cell_low[k] = bound[0][k] - largest + (k == 2 ? rise : 0.0);
    longest = std::max(longest, bound[1][k] - bound[0][k] + 2.0 * largest);
  }
  cell_size = std::max(2.0 * typical, longest / MOST_CELLS);
  std::size_t total = 1;
  for (int k = 0; k < 3; k++) {
    cell_count[k] = std::max(1, static_cast<int>(std::ceil((bound[1][k] - bound[0][k] + 2.0 * largest) / cell_size)));
    total *= cell_count[k];
  }
  present.clear();
  asked.clear();
  question = 0;
  cells.resize(total);
  for (auto &cell : cells) cell.clear();

  // Those of all ranks that reach there. Images come after the exchange.
  std::vector<Present> here;
  for (int i = 0; i < atom->nlocal; i++) {
    Present grain{};
    if (atom->ellipsoid[i] < 0) {
      if (ignore_others) continue;
      error->one(FLERR, "{}: particle {} of type {} is not an ellipsoid: give it a shape, or give the word 'ignore' if grains may "
                        "be inserted where it is", caller, static_cast<long long>(atom->tag[i]), atom->type[i]);
    }
    const EllgranBody body = atoms.body(i, 1.0);
    std::copy_n(body.position, 3, grain.position);
    std::copy_n(body.quaternion, 4, grain.quaternion);
    std::copy_n(body.semi_axes, 3, grain.semi_axes);
    find_axes(grain);
    grain.tag = static_cast<double>(body.identifier);
    bool reaches = false;
    each_image(grain.position, grain.reach, [&](const double *) { reaches = true; });
    if (reaches) here.push_back(grain);
  }
  MPI_Datatype datatype;
  MPI_Type_contiguous(sizeof(Present) / sizeof(double), MPI_DOUBLE, &datatype);
  MPI_Type_commit(&datatype);
  int count = static_cast<int>(here.size());
  std::vector<int> counts(comm->nprocs), starts(comm->nprocs, 0);
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, world);
  for (int rank = 1; rank < comm->nprocs; rank++) starts[rank] = starts[rank - 1] + counts[rank - 1];
  std::vector<Present> all(static_cast<std::size_t>(starts.back()) + counts.back());
  MPI_Allgatherv(here.data(), count, datatype, all.data(), counts.data(), starts.data(), datatype, world);
  MPI_Type_free(&datatype);
  for (const Present &grain : all) remember(grain);
}

bool EllgranGrainPlacement::is_inside(const double *position) const
{
  return region->match(position[0], position[1], position[2] - raised) != 0;
}

/* What follows from semi-axes and quaternion. */

void EllgranGrainPlacement::find_axes(Present &grain)
{
  double rotation[3][3];
  MathExtra::quat_to_mat(grain.quaternion, rotation);
  int order[3] = {0, 1, 2};
  std::sort(order, order + 3, [&](int a, int b) { return grain.semi_axes[a] > grain.semi_axes[b]; });
  for (int m = 0; m < 3; m++)
    for (int k = 0; k < 3; k++) grain.axes[m][k] = grain.semi_axes[order[m]] * rotation[k][order[m]];
  for (int k = 0; k < 3; k++)
    grain.reach[k] = std::sqrt(grain.axes[0][k] * grain.axes[0][k] + grain.axes[1][k] * grain.axes[1][k] + grain.axes[2][k] * grain.axes[2][k]);
  grain.largest = grain.semi_axes[order[0]];
  grain.smallest = grain.semi_axes[order[2]];
}

EllgranGrainPlacement::Present EllgranGrainPlacement::present_of(const EllgranGrain &grain)
{
  Present there{};
  std::copy_n(grain.position, 3, there.position);
  std::copy_n(grain.quaternion, 4, there.quaternion);
  std::copy_n(grain.semi_axes, 3, there.semi_axes);
  find_axes(there);
  return there;
}

EllgranBody EllgranGrainPlacement::body_of(const Present &grain)
{
  EllgranBody body = ELLGRAN_INIT(EllgranBody);
  std::copy_n(grain.position, 3, body.position);
  std::copy_n(grain.quaternion, 4, body.quaternion);
  std::copy_n(grain.semi_axes, 3, body.semi_axes);
  body.mass = 1.0;
  body.particle_type = 1;
  body.identifier = static_cast<int64_t>(grain.tag);
  return body;
}

bool EllgranGrainPlacement::overlaps(const Present &grain, const EllgranBody &body, const Present &other) const
{
  const double distance = square_of_distance(grain.position, other.position);
  const double outer = grain.largest + other.largest, inner = grain.smallest + other.smallest;
  // Balls around them apart, balls within them that overlap, a plane between them: all for speed alone.
  if (distance > outer * outer) return false;
  if (distance < inner * inner) return true;
  double d[3], across[3];
  MathExtra::sub3(other.position, grain.position, d);
  // As far along any vector n as both reach together: not for the last digits.
  const auto apart = [&](const double *n) {
    double reaches = 0.0;
    for (const Present *one : {&grain, &other}) {
      const double a = MathExtra::dot3(one->axes[0], n), b = MathExtra::dot3(one->axes[1], n), c = MathExtra::dot3(one->axes[2], n);
      reaches += std::sqrt(a * a + b * b + c * c);
    }
    return std::fabs(MathExtra::dot3(d, n)) > (1.0 + NEARLY) * reaches;
  };
  if (apart(d)) return false;
  // Between needles: across both, and across each towards the other.
  MathExtra::cross3(grain.axes[0], other.axes[0], across);
  if (apart(across)) return false;
  for (const Present *one : {&grain, &other}) {
    const double along = MathExtra::dot3(d, one->axes[0]) / (one->largest * one->largest);
    for (int k = 0; k < 3; k++) across[k] = d[k] - along * one->axes[0][k];
    if (apart(across)) return false;
  }
  const EllgranBody there = body_of(other);
  EllgranContactGeometry geometry = ELLGRAN_INIT(EllgranContactGeometry);
  check(ellgran_contact_geometry(nullptr, &body, &there, nullptr, &geometry));
  return geometry.touching != 0;
}

bool EllgranGrainPlacement::is_free(const EllgranGrain &grain)
{
  if (!is_inside(grain.position)) return false;
  const Present asking = present_of(grain);
  const EllgranBody body = body_of(asking);
  question++;
  int range[3][2];
  cells_of(grain.position, asking.reach, range);
  for (int i = range[0][0]; i <= range[0][1]; i++)
    for (int j = range[1][0]; j <= range[1][1]; j++)
      for (int k = range[2][0]; k <= range[2][1]; k++)
        for (const int index : cells[(static_cast<std::size_t>(i) * cell_count[1] + j) * cell_count[2] + k]) {
          if (asked[index] == question) continue;
          asked[index] = question;
          if (overlaps(asking, body, present[index])) return false;
        }
  return !touches_wall(grain, asking.reach);
}

void EllgranGrainPlacement::add(const EllgranGrain &grain)
{
  remember(present_of(grain));
}

tagint EllgranGrainPlacement::greatest_tag() const
{
  tagint mine = 0, greatest = 0;
  for (int i = 0; i < atom->nlocal; i++) mine = std::max(mine, atom->tag[i]);
  MPI_Allreduce(&mine, &greatest, 1, MPI_LMP_TAGINT, MPI_MAX, world);
  return greatest;
}

void EllgranGrainPlacement::begin_creation()
{
  if (atom->map_style != Atom::MAP_NONE) atom->map_clear();
  atom->nghost = 0;
  atom->avec->clear_bonus();
  created_here = 0;
}

void EllgranGrainPlacement::create(const EllgranGrain &grain, int type, tagint tag, int mask, const double *velocity)
{
  double position[3] = {grain.position[0], grain.position[1], grain.position[2]};
  imageint image =
      (static_cast<imageint>(IMGMAX) << IMG2BITS) | (static_cast<imageint>(IMGMAX) << IMGBITS) | static_cast<imageint>(IMGMAX);
  domain->remap(position, image);
  bool here = true;
  for (int k = 0; k < 3; k++) {
    // A box that shrinks around its particles may end below the region: the last rank takes what is beyond.
    double place = std::max(position[k], domain->boxlo[k]);
    if (place >= domain->boxhi[k]) place = std::nextafter(domain->boxhi[k], domain->boxlo[k]);
    here &= place >= domain->sublo[k] && place < domain->subhi[k];
  }
  if (!here) return;
  atom->avec->create_atom(type, position);
  const int i = atom->nlocal - 1;
  created_here++;
  atom->tag[i] = tag;
  atom->mask[i] = mask;
  atom->image[i] = image;
  std::copy_n(velocity, 3, atom->v[i]);
  atoms.set_grain(i, grain.semi_axes, grain.quaternion, grain.mass());
  modify->create_attribute(i);
}

void EllgranGrainPlacement::end_creation(bigint count, bigint last_tag)
{
  bigint here = created_here, all = 0;
  MPI_Allreduce(&here, &all, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (all != count)
    error->all(FLERR, "{}: {} grains were placed, but {} found a rank: the region reaches beyond the simulation box", caller, count,
               all);
  atom->natoms += count;
  if (atom->natoms < 0 || atom->natoms >= MAXBIGINT) error->all(FLERR, "{}: too many atoms", caller);
  atoms.count_ellipsoids();
  if (last_tag >= MAXTAGINT) error->all(FLERR, "{}: new atom IDs exceed the largest possible ID", caller);
  if (atom->map_style != Atom::MAP_NONE) {
    atom->map_init();
    atom->map_set();
  }
  // A box that shrinks around its particles has other bounds with the new ones. What follows hands particles to neighbouring ranks alone, and
  // loses those that now belong to ranks farther away, the particles that were there before too. It also wraps those beyond a periodic boundary,
  // which go from the last rank to the first then.
  if (domain->nonperiodic == 2) {
    domain->reset_box();
    Irregular irregular(lmp);
    irregular.migrate_atoms(1);
  }
}
