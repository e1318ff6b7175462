// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// Which of LAMMPS' per-atom arrays hold the ellipsoids, and are they fit to be used?
/// Shared by the pair style and the wall fix. Passes pointers; computes no physics.

#ifndef ELLGRAN_ATOMS_H
#define ELLGRAN_ATOMS_H

#include "lmptype.h"
#include "pointers.h"

#include "ellgran.h"

#include <string>
#include <vector>

namespace LAMMPS_NS {

class EllgranAtoms : protected Pointers {
 public:
  /// `caller` opens every message, for example "Pair gran/ellipsoid".
  EllgranAtoms(class LAMMPS *lmp, const std::string &caller);

  /// Stops with a message that names what to type if the atom style does not carry ellipsoids.
  void require_atom_style() const;

  /// Stops with a message that names the particle if an owned atom of the group is not an
  /// ellipsoid with finite positive semi-axes and, where LAMMPS knows exponents, block 2 2.
  void require_shapes(int group_bit) const;

  /// The grain of least volume of each type, on all ranks; index 0 is not used. It stands at the origin, its semi-axes fall
  /// along x, y and z from the longest to the shortest. Mass 0: there is none.
  [[nodiscard]] std::vector<EllgranBody> smallest_grains() const;

  /// What is wrong with the masses of the grains, on all ranks; empty if nothing is. A shape or a density that was set in
  /// the wrong order, or never, leaves a mass that LAMMPS takes without a word.
  [[nodiscard]] std::string implausible_masses() const;

  /// True for `atom_style ellipsoid superellipsoid`: the only one whose `radius` encloses the shape.
  [[nodiscard]] bool has_enclosing_radius() const;

  /// Whether a fix may write shapes in a run.
  [[nodiscard]] bool shapes_may_change() const;

  /// Largest semi-axis of the owned atoms of each type; index 0 is not used.
  [[nodiscard]] std::vector<double> largest_semi_axes() const;

  /// True if the three semi-axes of every owned atom are equal.
  [[nodiscard]] bool all_spheres() const;

  /// Pointers to the arrays as they are now (they move when LAMMPS migrates atoms).
  [[nodiscard]] EllgranParticles view() const;

  /// Puts shapes and attitudes in the order of the owned atoms. LAMMPS sorts atoms by place in space, but not these, so that each
  /// access to one would go anywhere in memory. Leaves KOKKOS' copies alone.
  void sort_shapes() const;

  /// Semi-axes, mass and type of the atoms at `indices`, `SHAPE_SIZE` doubles each, into `buffer`; 0 for what has no shape.
  void pack_shapes(int n, const int *indices, double *buffer) const;

  /// What `pack_shapes` wrote, for the ghosts from `first` on.
  void unpack_shapes(int n, int first, const double *buffer);

  static constexpr int SHAPE_SIZE = 5;

  /// Makes an owned atom, new or not, an ellipsoid at rest about its centre.
  void set_grain(int i, const double *semi_axes, const double *quaternion, double mass);

  /// Sets LAMMPS' number of ellipsoids, which data and restart files state, to those that all ranks own.
  void count_ellipsoids() const;

  /// Stops with a message that says that the run has become unstable, and which owned atom shows it, if one of the sums
  /// over a step is not finite.
  void require_finite(double viscous_dissipation, double tangential_work) const;

  /// Position, attitude, shape, velocities and mass of one owned or ghost atom.
  /// `contact_mass` replaces the atom's mass in the contact (rigid body, frozen atom). Velocity and
  /// angular momentum are those given, or the atom's present ones for nullptr.
  [[nodiscard]] EllgranBody body(int i, double contact_mass, const double *velocity = nullptr,
                                 const double *angular_momentum = nullptr) const;

 private:
  struct Shapes {
    const double *semi_axes;
    const double *quaternions;
    const double *exponents;    // nullptr where LAMMPS knows ellipsoids only
    std::size_t stride;         // bytes from one entry to the next
  };

  std::string caller;

  [[nodiscard]] Shapes shapes() const;
  [[nodiscard]] const double *semi_axes(const Shapes &shapes, int i) const;
};

}    // namespace LAMMPS_NS

#endif
