/* SPDX-License-Identifier: GPL-2.0-or-later */
/// The versions of what this plugin writes into LAMMPS' restart files. They have nothing to do with the version of the binary
/// interface of the library. Raise a version, and keep the code that reads the older ones, when
///
/// - a value is added, removed or moved, in the global data, in the histories or in those of a wall;
/// - a value changes its meaning, for example the unit or the frame of a number of a history.
///
/// tests/restart_files has a file of each version, and tests/lammps/restart_files.rs reads them all.

#ifndef ELLGRAN_RESTART_FORMAT_H
#define ELLGRAN_RESTART_FORMAT_H

namespace EllgranRestart {

/// Pair style: the settings in the file, and the histories of the contacts (fix NEIGH_HISTORY).
///
/// | version | settings |
/// |---|---|
/// | 1 | int: PAIR_MARK_1, 1, size of EllgranLawParameters, number of types; double: cutoff, energies dissipated by viscosity and by friction; of each pair of types I <= J an int, 1 if it has coefficients, and then an EllgranLawParameters |
/// | 2 | int: PAIR_MARK, 2; 32 characters: the version of ellgran that wrote it; int: size of EllgranLawParameters, number of types; then as version 1 |
///
/// The first two parts of version 2 stay what they are in all later versions.
///
/// Of an atom: as LAMMPS' fix NEIGH_HISTORY has it, and behind it the type under whose law its contacts remember what they do, and its ID.
/// Files of earlier builds end before the type or before the ID, and these read those that have them.
constexpr int PAIR_MARK_1 = 0x324c4547;
constexpr int PAIR_MARK = 0x524c4547;
constexpr int PAIR_FORMAT = 2;
constexpr int WRITER_LENGTH = 32;

/// fix wall/gran/ellipsoid: its global values, and the histories of its contacts per atom.
///
/// | version | global values, all of type double |
/// |---|---|
/// | 1 | energy dissipated by viscosity, time since the fix was made, energy dissipated by friction, work of the wall |
/// | 2 | -2; the four of version 1; velocity of the region (3), rate of its rotation |
/// | 3 | -3; as version 2; displacement (3) and angle of a motion by variables, state of the servo |
/// | 4 | -4; as version 3; size of EllgranLawParameters, and one, the law of the grains, in as many values as have room for it |
/// | 5 | -5; as version 3; 1 if a step was made, mean velocity (3) and rate of a motion by variables over it; the law as in version 4 |
/// | 6 | -6; as version 5 before the law; of a motion by variables or of a region what velocity (3) and rate have more at the step, and by how much they grew over it (3, 1); length of the step that the velocity of the region is of, 0 if none is known; the law as in version 4 |
/// | 7 | -7; as version 6; the law of the wall's material, in as many values as that of the grains |
/// | 8 | -8; as version 7 before the laws; the words of the motion: kinds (wiggle 1, velocity 2, rotation 4, added), whether it turns, whether it is by variables, of *wiggle* dimension, amplitude, period, of a constant *velocity* (3), of a rotation point (3), axis (3) and constant rate, whether there is a servo, its direction (3); the laws as in version 7. Of an atom its ID behind what its contacts remember |
///
/// The first value of every later version is minus that version.
constexpr int WALL_FORMAT = 8;

/// The fix behind compute energy/ellipsoid: its global values, all of type double.
///
/// | version | global values |
/// |---|---|
/// | 1 | 1; for each column of the compute its change in all runs so far, for the last the sum left over |
constexpr int ENERGY_BALANCE_FORMAT = 1;

/// fix nve/ellipsoid with velocities of the step: its global values, all of type double, and the values of an atom.
///
/// | version | global values | of an atom |
/// |---|---|---|
/// | 1 | 1; time step of the last step, 0 if there was none | what the velocity (3) and the angular momentum (3) that the last forces saw have more than those in the file; force (3) and torque (3) when the last step began, the first of them infinite if they are not known |
constexpr int MOTION_FORMAT = 1;

}

#endif
