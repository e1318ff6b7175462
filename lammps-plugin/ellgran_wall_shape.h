// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// Which shape of the library do the words `shape NAME ...` of a wall describe?

#ifndef ELLGRAN_WALL_SHAPE_H
#define ELLGRAN_WALL_SHAPE_H

#include "ellgran.h"

#include <string>

namespace LAMMPS_NS {

class LAMMPS;

/// Adds the shape that the words describe to the wall. The words are the library's (`ellgran_wall_add_shape_words`): this file knows none.
///
/// \param narg, words  what follows the word `shape`
/// \return             number of words read
///
/// Stops with a message that begins with `caller` and names the word: one that is missing or not a number, an unknown name, or
/// values that make no such shape.
int add_wall_shape(LAMMPS *lmp, const std::string &caller, EllgranWall *wall, int narg, char **words);

}    // namespace LAMMPS_NS

#endif
