/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "ellgran_mesh_file.h"

#include <vector>

#include "comm.h"
#include "ellgran.h"
#include "error.h"

using namespace LAMMPS_NS;

namespace {

// LIGGGHTS reads one file at a time.
bool reads = false;
std::vector<double> corners;
std::vector<int> lines;
size_t given = 0;

void forget()
{
  std::vector<double>().swap(corners);
  std::vector<int>().swap(lines);
  given = 0;
}

}    // namespace

void ellgran_mesh_file_begins()
{
  forget();
  reads = true;
}

bool ellgran_mesh_file_keeps(const double *a, const double *b, const double *c, int line)
{
  if (!reads) return false;
  corners.insert(corners.end(), a, a + 3);
  corners.insert(corners.end(), b, b + 3);
  corners.insert(corners.end(), c, c + 3);
  lines.push_back(line);
  return true;
}

void ellgran_mesh_file_ends(LAMMPS *lmp)
{
  reads = false;
  if (lines.empty()) return;
  if (ellgran_flatten_triangles(lines.size(), &corners[0], NULL) != 0) lmp->error->all(FLERR, ellgran_last_error());
}

double *ellgran_mesh_file_next(int &line)
{
  if (given == lines.size()) {
    forget();
    return NULL;
  }
  line = lines[given];
  return &corners[9 * given++];
}
