// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_wall_shape.h"

#include "error.h"
#include "lammps.h"

using namespace LAMMPS_NS;

int LAMMPS_NS::add_wall_shape(LAMMPS *lmp, const std::string &caller, EllgranWall *wall, int narg, char **words)
{
  std::size_t read = 0;
  if (ellgran_wall_add_shape_words(wall, narg, words, &read) != ELLGRAN_SUCCESS)
    lmp->error->all(FLERR, "{}: {}", caller, ellgran_last_error());
  return static_cast<int>(read);
}
