// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// Where has the energy of the grains come from, and where has it gone? The fix behind `compute energy/ellipsoid`.

#ifndef ELLGRAN_ENERGY_BALANCE_H
#define ELLGRAN_ENERGY_BALANCE_H

#include "fix.h"

#include "ellgran_atoms.h"

#include <array>
#include <string>
#include <vector>

namespace LAMMPS_NS {

/// Whether a compute exists that asks what contacts dissipate, so that pair style and walls sum it up from the next run on.
[[nodiscard]] bool computes_ask_for_energies(const class Modify *modify);

/// Gathers the energies that the pair style and the walls tally. What happens between two runs (`delete_atoms`, `velocity`,
/// `unfix` of a wall, another law) is no part of the balance: it compares the beginning of each run with its end.
///
/// The work of a deforming box with its velocity u = h' lambda + lo', where a particle has v = u(x) + c: since u changes
/// along the path of a particle by (h' h^-1) c, the balance of sum(m c^2/2) has the power -(h' h^-1):(sum d (x) F + sum m c (x) c),
/// without the second time derivative of h. It does not depend on which image of a particle is in the box.
class FixEllgranEnergyBalance : public Fix {
 public:
  /// Columns of the output, in its order. Keep README.md in step.
  enum {
    TRANSLATION,
    ROTATION,
    NORMAL_ELASTIC,
    TANGENTIAL_ELASTIC,
    GRAVITY,
    NUMBER_OF_STATES,
    VISCOUS_DISSIPATION = NUMBER_OF_STATES,
    FRICTIONAL_DISSIPATION,
    WORK_OF_WALLS,
    WORK_OF_BOX,
    BROUGHT,
    NUMBER_OF_TERMS,
    LEFT_OVER = NUMBER_OF_TERMS,
    NUMBER_OF_COLUMNS
  };
  using Terms = std::array<double, NUMBER_OF_TERMS>;

  FixEllgranEnergyBalance(class LAMMPS *, int, char **);

  int setmask() override;
  void init() override;
  void setup(int) override;
  void initial_integrate(int) override;
  void post_integrate() override;
  void pre_exchange() override;
  void pre_neighbor() override;
  void post_force(int) override;
  void end_of_step() override;
  void post_run() override;
  void write_restart(FILE *) override;
  void restart(char *) override;
  double memory_usage() override;

  /// The columns, summed over ranks, all of which call it.
  void sum_columns(double *columns);

  // Does what the base class does, whose symbol has the width of atom IDs in its name: not to need it
  // lets a LAMMPS with other integer sizes load the plugin, which then says what is wrong.
  void set_molecule(int, tagint, int, double *, double *, double *) override;

 private:
  EllgranAtoms atoms;
  std::string caller;
  std::vector<class Pair *> pairs;
  std::vector<Fix *> walls, gravities;

  // What a run began with, and what has come together in the runs before: this rank's share, of which the sums over ranks
  // alone have a meaning, since grains change ranks
  Terms start;
  std::array<double, NUMBER_OF_COLUMNS> before;
  bool runs;               // between the beginning of a run and its end
  bool walls_are_ready;    // they compute their forces in the same set-up, perhaps after this fix

  // Work of a deforming box, and what was known of it in the last step
  bool box_deforms;
  double lower_corner[3], inverse_edges[6], edge_rates[6], corner_rate[3];
  double gradient[6];    // of the velocity: xx yy zz yz xz xy, as the edges
  double contact_power, power;
  double spin[3];
  double work_of_box;

  // Grains that come and go
  double brought, energy_then;
  bool noted;

  void find_sources();
  void refuse_what_cannot_work() const;
  [[nodiscard]] double sum_over_sources(const char *name) const;
  void add_motion(Terms &terms) const;
  [[nodiscard]] Terms terms_now() const;
  [[nodiscard]] std::array<double, NUMBER_OF_COLUMNS> changes() const;
  void complete_start();
  void note_energy();
  double energy_of_half_step() const;
  void record_box();
  void velocity_of_box(const double *position, double *velocity) const;
  [[nodiscard]] double power_of_motion(double *spin_now) const;
};

/// Adds the fix with this ID; its owner deletes it.
FixEllgranEnergyBalance *add_energy_balance(class Modify *modify, const std::string &id);

}    // namespace LAMMPS_NS

#endif
