/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * What compute pair/gran/local and wall/gran/local tell of one contact of ellipsoids. LIGGGHTS fills a row as if the grains were
 * their bounding spheres; here it is filled with what the contact has.
 */

#ifndef ELLGRAN_LOCAL_OUTPUT_H
#define ELLGRAN_LOCAL_OUTPUT_H

namespace LAMMPS_NS {
class ComputePairGranLocal;
}

struct EllgranContactReport {
  double normal[3];       // unit normal of the contact, of either sign
  double point[3];        // contact point, world frame
  double penetration;
  double area;            // of the plane section of the overlap
  double force[3];        // on the first particle
  double torque[3];
};

// Writes contactArea, delta and contactPoint, those that were asked for, into that row of the compute.
void ellgran_write_geometry(LAMMPS_NS::ComputePairGranLocal *compute, int row, const EllgranContactReport &report);

// The same, and force_normal, force_tangential, torque_normal and torque_tangential.
void ellgran_write_report(LAMMPS_NS::ComputePairGranLocal *compute, int row, const EllgranContactReport &report);

#endif
