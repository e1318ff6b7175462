/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * The triangles of a file that LIGGGHTS reads, all of them before its mesh has the first: corners of flat pieces, which the few digits of a file have left
 * uneven, go back to their planes. LIGGGHTS' own reader of mesh files calls these, on all ranks.
 */

#ifndef ELLGRAN_MESH_FILE_H
#define ELLGRAN_MESH_FILE_H

#include "lammps.h"

// A file begins.
void ellgran_mesh_file_begins();

// Keeps a triangle of the file; false once the file has ended, or without one.
bool ellgran_mesh_file_keeps(const double *a, const double *b, const double *c, int line);

// The file has ended: makes its flat pieces flat. Stops LIGGGHTS where a corner is out of range.
void ellgran_mesh_file_ends(LAMMPS_NS::LAMMPS *lmp);

// The next triangle that was kept: its corners one after the other and its line; NULL behind the last.
double *ellgran_mesh_file_next(int &line);

#endif
