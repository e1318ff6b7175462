// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_wall_velocity.h"

#include <algorithm>

using namespace LAMMPS_NS;

void WallVelocityAtStep::grow(const double (&growth)[COUNT])
{
  double along = 0.0;
  for (int k = 0; k < 3; k++) along += growth[k] * last_growth[k];
  const bool turns_back[2] = {along < 0.0, growth[3] * last_growth[3] < 0.0};
  for (int k = 0; k < COUNT; k++) changes[k] = turns_back[k / 3] ? 0.0 : 0.5 * growth[k];
  std::copy_n(growth, COUNT, last_growth);
}

void WallVelocityAtStep::stand()
{
  std::fill_n(changes, COUNT, 0.0);
}

void WallVelocityAtStep::pack(double *values) const
{
  std::copy_n(last_growth, COUNT, std::copy_n(changes, COUNT, values));
}

void WallVelocityAtStep::unpack(const double *values)
{
  std::copy_n(values, COUNT, changes);
  std::copy_n(values + COUNT, COUNT, last_growth);
}
