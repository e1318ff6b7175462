// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// What are the measures of a region of LAMMPS?
///
/// To be included by one file of a program alone: it names each member once.

#ifndef ELLGRAN_REGION_MEASURES_H
#define ELLGRAN_REGION_MEASURES_H

#include "region.h"
#include "region_block.h"
#include "region_cone.h"
#include "region_cylinder.h"
#include "region_plane.h"
#include "region_sphere.h"

namespace {

using namespace LAMMPS_NS;

// LAMMPS keeps the measures of a region to itself. C++ lets an explicit instantiation name a private member; the friend
// function that it defines hands out the pointer to it. A release without that member does not compile.
template <typename Key, typename Key::Pointer member> struct Expose {
  friend typename Key::Pointer member_of(Key) { return member; }
};

#define EXPOSE(Key, Class, Type, member)                                       \
  struct Key {                                                                 \
    using Pointer = Type Class::*;                                             \
    friend Pointer member_of(Key);                                             \
  };                                                                           \
  template struct Expose<Key, &Class::member>

using Triple = double[3];

EXPOSE(RegionPoint, Region, Triple, point);
EXPOSE(RegionAxis, Region, Triple, runit);
EXPOSE(BlockXlo, RegBlock, double, xlo);
EXPOSE(BlockXhi, RegBlock, double, xhi);
EXPOSE(BlockYlo, RegBlock, double, ylo);
EXPOSE(BlockYhi, RegBlock, double, yhi);
EXPOSE(BlockZlo, RegBlock, double, zlo);
EXPOSE(BlockZhi, RegBlock, double, zhi);
EXPOSE(PlaneX, RegPlane, double, xp);
EXPOSE(PlaneY, RegPlane, double, yp);
EXPOSE(PlaneZ, RegPlane, double, zp);
EXPOSE(PlaneNormal, RegPlane, Triple, normal);
EXPOSE(SphereX, RegSphere, double, xc);
EXPOSE(SphereY, RegSphere, double, yc);
EXPOSE(SphereZ, RegSphere, double, zc);
EXPOSE(SphereRadius, RegSphere, double, radius);
EXPOSE(CylinderAxis, RegCylinder, char, axis);
EXPOSE(CylinderFirst, RegCylinder, double, c1);
EXPOSE(CylinderSecond, RegCylinder, double, c2);
EXPOSE(CylinderRadius, RegCylinder, double, radius);
EXPOSE(CylinderLow, RegCylinder, double, lo);
EXPOSE(CylinderHigh, RegCylinder, double, hi);
EXPOSE(ConeAxis, RegCone, char, axis);
EXPOSE(ConeFirst, RegCone, double, c1);
EXPOSE(ConeSecond, RegCone, double, c2);
EXPOSE(ConeRadiusLow, RegCone, double, radiuslo);
EXPOSE(ConeRadiusHigh, RegCone, double, radiushi);
EXPOSE(ConeLow, RegCone, double, lo);
EXPOSE(ConeHigh, RegCone, double, hi);

#undef EXPOSE

}    // namespace

#endif
