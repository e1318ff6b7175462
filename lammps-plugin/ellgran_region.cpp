// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_region.h"
#include "ellgran_region_measures.h"

#include "domain.h"
#include "error.h"
#include "math_const.h"
#include "modify.h"
#include "update.h"
#include "utils.h"

#include <cmath>
#include <cstring>
#include <initializer_list>
#include <vector>

using namespace LAMMPS_NS;

namespace {

// What a region gives for INF is beyond any coordinate.
constexpr double INFINITE = 1e20;

class Surfaces {
 public:
  Surfaces(LAMMPS *lmp, const std::string &caller, EllgranWall *wall) : lmp(lmp), caller(caller), wall(wall) {}

  // `flipped`: the particles are where the region is not
  void add(Region *region, bool flipped)
  {
    const std::string style = region->style;
    const std::string name = "region " + std::string(region->id) + " of style " + style;
    if (region->varshape) fail(name + " has a shape that varies; only its place may, by move and rotate");
    if (style == "union" || style == "intersect") {
      // Together the grains' space is that of an intersection: behind any of the surfaces is wall.
      const bool inside = (region->interior != 0) != flipped;
      if ((style == "intersect") != inside)
        fail(name + (inside ? " with side in" : " with side out") +
             " has edges that stick out where its parts meet; use fixes of their own for the parts, or a mesh");
      for (int k = 0; k < region->nregion; k++) {
        if (region->reglist[k]->dynamic)
          fail("region " + std::string(region->reglist[k]->id) + " moves within " + name + "; only single regions may");
        add(region->reglist[k], !inside);
      }
      return;
    }
    side = ((region->interior != 0) != flipped) ? ELLGRAN_SIDE_INSIDE : ELLGRAN_SIDE_OUTSIDE;
    open = region->open_faces;
    if (region->openflag) side = ELLGRAN_SIDE_OF_CENTRE;
    if (style == "block")
      block(*static_cast<RegBlock *>(region));
    else if (style == "plane")
      plane(*static_cast<RegPlane *>(region));
    else if (style == "sphere")
      sphere(*static_cast<RegSphere *>(region));
    else if (style == "cylinder")
      cylinder(name, *static_cast<RegCylinder *>(region));
    else if (style == "cone")
      cone(name, *static_cast<RegCone *>(region));
    else
      fail(name + " cannot be a wall; block, plane, sphere, cylinder, cone, and intersect and union of them can");
  }

 private:
  LAMMPS *lmp;
  std::string caller;
  EllgranWall *wall;
  int side = 0;
  const int *open = nullptr;

  [[noreturn]] void fail(const std::string &what) const
  {
    lmp->error->all(FLERR, "{}: {}", caller, what);
  }

  void check(int32_t status) const
  {
    if (status != ELLGRAN_SUCCESS) fail(ellgran_last_error());
  }

  void plane(RegPlane &r)
  {
    EllgranWallShape shape = ELLGRAN_INIT(EllgranWallShape);
    shape.name = "plane";
    shape.point[0] = r.*member_of(PlaneX());
    shape.point[1] = r.*member_of(PlaneY());
    shape.point[2] = r.*member_of(PlaneZ());
    std::memcpy(shape.axis, r.*member_of(PlaneNormal()), sizeof shape.axis);
    shape.side = side;
    check(ellgran_wall_add_shape(wall, &shape));
  }

  void sphere(RegSphere &r)
  {
    EllgranWallShape shape = ELLGRAN_INIT(EllgranWallShape);
    shape.name = "sphere";
    shape.point[0] = r.*member_of(SphereX());
    shape.point[1] = r.*member_of(SphereY());
    shape.point[2] = r.*member_of(SphereZ());
    shape.radii[0] = r.*member_of(SphereRadius());
    shape.side = side;
    check(ellgran_wall_add_shape(wall, &shape));
  }

  void block(RegBlock &r)
  {
    const double low[3] = {r.*member_of(BlockXlo()), r.*member_of(BlockYlo()), r.*member_of(BlockZlo())};
    const double high[3] = {r.*member_of(BlockXhi()), r.*member_of(BlockYhi()), r.*member_of(BlockZhi())};
    if (side != ELLGRAN_SIDE_INSIDE) {
      box(r, low, high);
      return;
    }
    for (int k = 0; k < 6; k++) {
      const double position = (k % 2 == 0) ? low[k / 2] : high[k / 2];
      if (std::fabs(position) >= INFINITE) continue;
      EllgranWallShape shape = ELLGRAN_INIT(EllgranWallShape);
      shape.name = "plane";
      shape.point[k / 2] = position;
      shape.axis[k / 2] = (k % 2 == 0) ? 1.0 : -1.0;
      shape.side = ELLGRAN_SIDE_INSIDE;
      check(ellgran_wall_add_shape(wall, &shape));
    }
  }

  // Edges and corners that stick out. With open faces it is a shell: two triangles for each face that is there.
  void box(RegBlock &r, const double *low, const double *high)
  {
    for (int k = 0; k < 3; k++)
      if (std::fabs(low[k]) >= INFINITE || std::fabs(high[k]) >= INFINITE)
        fail("region " + std::string(r.id) +
             " of style block with side out or open faces must end in all dimensions: it has INF or EDGE beyond the largest "
             "coordinate");
    if (side == ELLGRAN_SIDE_OUTSIDE) {
      check(ellgran_wall_add_block(wall, low, high));
      return;
    }
    std::vector<double> corners;
    for (int k = 0; k < 6; k++) {
      if (open[k]) continue;
      const int a = k / 2, b = (a + 1) % 3, c = (a + 2) % 3;
      double square[4][3];
      for (int m = 0; m < 4; m++) {
        square[m][a] = (k % 2 == 0) ? low[a] : high[a];
        square[m][b] = (m == 1 || m == 2) ? high[b] : low[b];
        square[m][c] = (m >= 2) ? high[c] : low[c];
      }
      for (const int m : {0, 1, 2, 0, 2, 3}) corners.insert(corners.end(), square[m], square[m] + 3);
    }
    check(ellgran_wall_add_triangles(wall, corners.size() / 9, corners.data()));
  }

  static int axis_of(char axis) { return axis - 'x'; }

  // The two coordinates across the axis are in the order of x, y, z.
  void place(EllgranWallShape &shape, char axis, double first, double second) const
  {
    const int along = axis_of(axis);
    shape.point[along == 0 ? 1 : 0] = first;
    shape.point[along == 2 ? 1 : 2] = second;
    shape.axis[along] = 1.0;
    shape.side = side;
  }

  void ends(const std::string &name, EllgranWallShape &shape, double low, double high) const
  {
    if (open[2]) fail(name + " with open 3 has no side: only its ends, 1 and 2, may be open");
    const double bounds[2] = {low, high};
    for (int k = 0; k < 2; k++) {
      const bool infinite = std::fabs(bounds[k]) >= INFINITE;
      shape.bounds[k] = infinite ? std::copysign(HUGE_VAL, bounds[k]) : bounds[k];
      shape.ends[k] = infinite ? ELLGRAN_END_NONE : open[k] ? ELLGRAN_END_OPEN : ELLGRAN_END_CLOSED;
    }
  }

  void cylinder(const std::string &name, RegCylinder &r)
  {
    EllgranWallShape shape = ELLGRAN_INIT(EllgranWallShape);
    shape.name = "cylinder";
    place(shape, r.*member_of(CylinderAxis()), r.*member_of(CylinderFirst()), r.*member_of(CylinderSecond()));
    shape.radii[0] = r.*member_of(CylinderRadius());
    ends(name, shape, r.*member_of(CylinderLow()), r.*member_of(CylinderHigh()));
    check(ellgran_wall_add_shape(wall, &shape));
  }

  void cone(const std::string &name, RegCone &r)
  {
    EllgranWallShape shape = ELLGRAN_INIT(EllgranWallShape);
    shape.name = "cone";
    place(shape, r.*member_of(ConeAxis()), r.*member_of(ConeFirst()), r.*member_of(ConeSecond()));
    shape.radii[0] = r.*member_of(ConeRadiusLow());
    shape.radii[1] = r.*member_of(ConeRadiusHigh());
    ends(name, shape, r.*member_of(ConeLow()), r.*member_of(ConeHigh()));
    check(ellgran_wall_add_shape(wall, &shape));
  }
};

}    // namespace

void LAMMPS_NS::add_region(LAMMPS *lmp, const std::string &caller, Region *region, EllgranWall *wall)
{
  Surfaces(lmp, caller, wall).add(region, false);
}

std::string LAMMPS_NS::measures_of_region(Region *region)
{
  const std::string style = region->style;
  std::string text = fmt::format("{} {} {} {}", style, region->interior, region->dynamic, region->varshape);
  for (int k = 0; k < 6; k++) text += region->open_faces[k] ? " open" : " closed";
  const auto add = [&text](std::initializer_list<double> numbers) {
    for (const double number : numbers) text += fmt::format(" {}", number);
  };
  if (style == "union" || style == "intersect") {
    for (int k = 0; k < region->nregion; k++) text += " (" + measures_of_region(region->reglist[k]) + ")";
  } else if (style == "block") {
    auto &r = *static_cast<RegBlock *>(region);
    add({r.*member_of(BlockXlo()), r.*member_of(BlockXhi()), r.*member_of(BlockYlo()), r.*member_of(BlockYhi()),
         r.*member_of(BlockZlo()), r.*member_of(BlockZhi())});
  } else if (style == "plane") {
    auto &r = *static_cast<RegPlane *>(region);
    const double *const normal = r.*member_of(PlaneNormal());
    add({r.*member_of(PlaneX()), r.*member_of(PlaneY()), r.*member_of(PlaneZ()), normal[0], normal[1], normal[2]});
  } else if (style == "sphere") {
    auto &r = *static_cast<RegSphere *>(region);
    add({r.*member_of(SphereX()), r.*member_of(SphereY()), r.*member_of(SphereZ()), r.*member_of(SphereRadius())});
  } else if (style == "cylinder") {
    auto &r = *static_cast<RegCylinder *>(region);
    text += r.*member_of(CylinderAxis());
    add({r.*member_of(CylinderFirst()), r.*member_of(CylinderSecond()), r.*member_of(CylinderRadius()), r.*member_of(CylinderLow()),
         r.*member_of(CylinderHigh())});
  } else if (style == "cone") {
    auto &r = *static_cast<RegCone *>(region);
    text += r.*member_of(ConeAxis());
    add({r.*member_of(ConeFirst()), r.*member_of(ConeSecond()), r.*member_of(ConeRadiusLow()), r.*member_of(ConeRadiusHigh()),
         r.*member_of(ConeLow()), r.*member_of(ConeHigh())});
  }
  return text;
}

std::vector<std::array<double, 3>> LAMMPS_NS::planes_of_region(Region *region, const double *low, const double *high)
{
  const std::string style = region->style;
  std::vector<std::array<double, 3>> found;
  if (style == "union" || style == "intersect") {
    for (int k = 0; k < region->nregion; k++)
      for (const auto &normal : planes_of_region(region->reglist[k], low, high)) found.push_back(normal);
  } else if (style == "plane") {
    const double *const normal = static_cast<RegPlane *>(region)->*member_of(PlaneNormal());
    found.push_back({normal[0], normal[1], normal[2]});
  } else if (style == "block" && !region->openflag) {
    auto &r = *static_cast<RegBlock *>(region);
    const double lower[3] = {r.*member_of(BlockXlo()), r.*member_of(BlockYlo()), r.*member_of(BlockZlo())};
    const double upper[3] = {r.*member_of(BlockXhi()), r.*member_of(BlockYhi()), r.*member_of(BlockZhi())};
    for (int k = 0; k < 3; k++) {
      const bool beyond = (lower[k] <= low[k] && lower[k] > -INFINITE) || (upper[k] >= high[k] && upper[k] < INFINITE);
      if (!beyond) continue;
      found.push_back({0.0, 0.0, 0.0});
      found.back()[k] = 1.0;
    }
  }
  return found;
}

namespace {

// As the surfaces of a region are added.
void add_blocks(Region *region, bool flipped, std::vector<std::array<double, 6>> &found)
{
  const std::string style = region->style;
  const bool inside = (region->interior != 0) != flipped;
  if (style == "union" || style == "intersect") {
    for (int k = 0; k < region->nregion; k++) add_blocks(region->reglist[k], !inside, found);
  } else if (style == "block" && !inside) {
    auto &r = *static_cast<RegBlock *>(region);
    found.push_back({r.*member_of(BlockXlo()), r.*member_of(BlockYlo()), r.*member_of(BlockZlo()), r.*member_of(BlockXhi()),
                     r.*member_of(BlockYhi()), r.*member_of(BlockZhi())});
  }
}

}    // namespace

std::vector<std::array<double, 6>> LAMMPS_NS::blocks_within(Region *region)
{
  std::vector<std::array<double, 6>> found;
  add_blocks(region, false, found);
  return found;
}

double LAMMPS_NS::volume_of_region(Region *region, const double *low, const double *high)
{
  const std::string style = region->style;
  if (!region->interior || !region->bboxflag) return -1.0;
  // Where a round region is cut off by the box, the formulas do not hold.
  const double extent[2][3] = {{region->extent_xlo, region->extent_ylo, region->extent_zlo},
                               {region->extent_xhi, region->extent_yhi, region->extent_zhi}};
  bool cut[3];
  for (int k = 0; k < 3; k++) cut[k] = extent[0][k] < low[k] || extent[1][k] > high[k];
  const auto is_cut_across = [&cut](int along) { return cut[(along + 1) % 3] || cut[(along + 2) % 3]; };

  if (style == "block") return (high[0] - low[0]) * (high[1] - low[1]) * (high[2] - low[2]);
  if (style == "sphere") {
    const double radius = static_cast<RegSphere *>(region)->*member_of(SphereRadius());
    return (cut[0] || is_cut_across(0)) ? -1.0 : 4.0 / 3.0 * MathConst::MY_PI * radius * radius * radius;
  }
  if (style == "cylinder") {
    const auto *r = static_cast<RegCylinder *>(region);
    const int along = r->*member_of(CylinderAxis()) - 'x';
    const double radius = r->*member_of(CylinderRadius());
    return is_cut_across(along) ? -1.0 : MathConst::MY_PI * radius * radius * (high[along] - low[along]);
  }
  if (style == "cone") {
    const auto *r = static_cast<RegCone *>(region);
    const int along = r->*member_of(ConeAxis()) - 'x';
    const double a = r->*member_of(ConeRadiusLow()), b = r->*member_of(ConeRadiusHigh());
    if (cut[along] || is_cut_across(along)) return -1.0;
    return MathConst::MY_PI / 3.0 * (a * a + a * b + b * b) * (high[along] - low[along]);
  }
  return -1.0;
}

RegionPose LAMMPS_NS::region_pose(LAMMPS *lmp, Region *region)
{
  RegionPose pose{};
  if (!region->dynamic) return pose;
  lmp->modify->clearstep_compute();
  region->prematch();
  lmp->modify->addstep_compute(lmp->update->ntimestep + 1);
  if (region->rotateflag) {
    std::memcpy(pose.point, region->*member_of(RegionPoint()), sizeof pose.point);
    std::memcpy(pose.axis, region->*member_of(RegionAxis()), sizeof pose.axis);
    pose.angle = region->theta;
  }
  if (region->moveflag) {
    pose.displacement[0] = region->dx;
    pose.displacement[1] = region->dy;
    pose.displacement[2] = region->dz;
  }
  return pose;
}
