/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "ellgran_local_output.h"

#include "compute_pair_gran_local.h"
#include "vector_liggghts.h"

using namespace LAMMPS_NS;

namespace {

// the part of a vector along the normal at `along`, the rest at `across`; a negative place is not asked for
void split(double *row, const double *vector, const double *normal, int along, int across)
{
  const double size = vectorDot3D(vector, normal);
  for (int k = 0; k < 3; k++) {
    if (along >= 0) row[along + k] = size * normal[k];
    if (across >= 0) row[across + k] = vector[k] - size * normal[k];
  }
}

}

void ellgran_write_geometry(ComputePairGranLocal *compute, int row, const EllgranContactReport &report)
{
  double *const values = compute->get_data()[row];
  if (compute->offset_area() >= 0) values[compute->offset_area()] = report.area;
  if (compute->offset_delta() >= 0) values[compute->offset_delta()] = report.penetration;
  if (compute->offset_contact_point() >= 0)
    for (int k = 0; k < 3; k++) values[compute->offset_contact_point() + k] = report.point[k];
}

void ellgran_write_report(ComputePairGranLocal *compute, int row, const EllgranContactReport &report)
{
  double *const values = compute->get_data()[row];
  split(values, report.force, report.normal, compute->offset_fn(), compute->offset_ft());
  split(values, report.torque, report.normal, compute->offset_torquen(), compute->offset_torquet());
  ellgran_write_geometry(compute, row, report);
}
