// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// `pair_style gran/ellipsoid`: hands LAMMPS' arrays and neighbour list to ellgran, once a step.

#ifdef PAIR_CLASS
// clang-format off
PairStyle(gran/ellipsoid,PairGranEllipsoid);
// clang-format on
#else

#ifndef LMP_PAIR_GRAN_ELLIPSOID_H
#define LMP_PAIR_GRAN_ELLIPSOID_H

#include "pair.h"

#include "ellgran_atoms.h"
#include "ellgran_step_limits.h"

#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace LAMMPS_NS {

class PairGranEllipsoid : public Pair {
 public:
  PairGranEllipsoid(class LAMMPS *);
  ~PairGranEllipsoid() override;

  void compute(int, int) override;
  void settings(int, char **) override;
  void coeff(int, char **) override;
  void init_style() override;
  double init_one(int, int) override;
  void setup() override;
  void finish() override;

  void write_restart(FILE *) override;
  void read_restart(FILE *) override;
  void write_restart_settings(FILE *) override;
  void read_restart_settings(FILE *) override;

  double single(int, int, int, int, double, double, double, double &) override;
  void *extract(const char *, int &) override;

  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;
  int pack_reverse_comm(int, int, double *) override;
  void unpack_reverse_comm(int, int *, double *) override;
  void transfer_history(double *, double *, int, int) override;
  double memory_usage() override;

  /// Adds what the pairs contribute to the bound of the stable step (`ellgran_add_pairs_to_step_sums`); what images have, to
  /// their owners; masses of bodies in contact, infinite for frozen atoms.
  void add_to_step_sums(EllgranWorkspace *own, const EllgranParticles &particles, double *sums,
                        EllgranContactExtremes *extremes) const;
  void add_step_sums_of_images(double *sums);
  void tell_contact_masses(std::vector<double> &masses) const;
  [[nodiscard]] const EllgranLaws *contact_laws() const { return laws; }

  /// Whether the contacts of this step were recorded, and what they add to the sums of each atom, ghosts included
  /// (`ellgran_add_recorded_to_grain_sums`); not for a rank without atoms.
  [[nodiscard]] bool has_contacts_of(bigint step) const { return step == step_of_contacts; }
  void add_to_grain_sums(const EllgranParticles &present, double *sums) const;

  /// The workspace with what was prepared for the forces of this step, if they have been computed here (`prepared_by` of
  /// EllgranParticles); else nullptr.
  [[nodiscard]] const EllgranWorkspace *prepared_in(bigint step) const { return step == step_prepared ? workspace : nullptr; }

 protected:
  EllgranAtoms atoms;
  double cutoff_global;    // < 0: from the semi-axes

  // Laws: the words of pair_coeff, row-major over types 0 ... ntypes-1, and what ellgran made of them.
  std::vector<EllgranLawParameters> parameters;
  std::vector<EllgranLawParameters> restored;    // those of the restart file, and which of them it had
  std::vector<int> restored_flags;
  EllgranLaws *laws;
  bool histories_are_of_other_laws = false;    // what contacts remember means nothing under the laws that there are now
  uint32_t laws_options;
  std::string described;    // the laws as last written to the log
  std::string warned;       // of implausible masses, as last written to the log
  EllgranStepLimits limits;
  bigint at_rest_told = 0;                 // grains that no force moves, as last warned of
  std::string limits_told, excess_told;    // of the time step, as last written to the log
  double step_told;                        // the time step of which was said that the contacts do not allow it; 0: none
  double *step_sums;                       // what the next reverse communication carries, from `step_sums_from` on; nullptr: loads
  int step_sums_from;

  EllgranWorkspace *workspace;
  bigint step_prepared = -1;    // the last step of a run in which the forces were computed with it

  // Contact history
  int history_length;    // doubles per contact, 0: no fix
  std::string id_placeholder, id_history;
  class FixEllgranHistory *fix_history;
  std::map<std::pair<int, int>, bool> meanings;    // what was found of types that atoms had and have
  int neighbour_previous;        // single() finds its pair in constant time when called in order
  std::vector<double> scratch;    // history that single() may overwrite

  // Velocities over the last step, where a fix needs it; nullptr: `atom->v` is right
  std::string id_step_velocity;
  class FixEllgranStepVelocity *fix_step_velocity;
  class FixNVEEllipsoid *velocities_of_step;    // nullptr: forces see those of the half step

  // Something may change shapes while a run goes on: ghosts are told in every step
  bool shapes_may_change;
  bool shapes_in_message;    // what the next forward communication carries: shapes, else masses of bodies

  // With KOKKOS: the next one carries angular momenta instead, and whether those that images have are others
  bool momenta_in_message, images_differ;

  // What the forces of the last evaluation were computed from and is gone when single() shows them: positions (a box may
  // carry atoms on at the end of a step, and images not), velocities (LAMMPS has them of the half step then, and moves them
  // on), and the histories before
  struct Evaluation {
    EllgranStep step = ELLGRAN_INIT(EllgranStep);
    int count = -1;    // atoms, ghosts included; -1: nothing recorded
    std::vector<double> positions, velocities, angular_momenta;
    bool of_step = false;           // these are velocities of the step
    std::vector<double> changes;    // 6 of each atom: what they then have more than those of the half step
    std::vector<int> rows;    // of each atom: place of its first neighbour, -1 for none
    std::vector<int> touching;
    std::vector<double> history;
  };
  Evaluation evaluation;
  bool evaluation_wanted;

  // Whether a compute may ask for the contacts of a step, and the last step in which one did and they were recorded
  bool contacts_wanted;
  bigint step_of_contacts;
  std::vector<double> positions_of_contacts;    // those with which they were recorded

  bigint atoms_in_file = 0;    // of a restart file that was read; 0: none was
  int listed;    // atoms and images when the neighbour list was built

  // What was there when the last run ended, if no force has been computed since
  struct End {
    bool known = false;
    bool set_up_since = false;        // a command has had LAMMPS set up anew, and no list has been built
    std::vector<tagint> ids;          // of atoms and images
    std::vector<double> positions;    // of atoms
  };
  End end_of_run;

  // Sizes: largest semi-axis of each type when the cutoffs were made, and what a later atom may have
  std::vector<double> largest, allowed;

  // Masses in contact: rigid bodies and frozen atoms
  class Fix *fix_rigid;
  int freeze_group_bit;
  bool contact_mass_differs;
  std::vector<double> body_mass;        // of the rigid body an atom is in, 0 if none
  std::vector<double> contact_masses;

  // Energy that contacts have dissipated since the first run, this rank's share, and the loads that do so
  EllgranTallies tallies;
  double friction;
  std::vector<double> inelastic_loads;
  std::array<double, 2> image_powers;    // of these loads on images, beyond those on their owners: a deforming box alone
  class FixEllgranHalfStep *fix_half_step;
  bool work_wanted;
  bool unknown_energies_told = false;
  bigint deep_told;    // searches for deep overlaps that a warning has counted already

  void allocate();
  bool take_restored(int i, int j);
  EllgranNeighbourList view_list() const;
  void write_history();
  void add_forces();
  void find_largest_semi_axes();
  void warn_of_masses();
  void tell_step_limits();
  void warn_of_unknown_energies();
  void warn_of_grains_at_rest();
  [[nodiscard]] bool images_move() const;
  void build_laws();
  [[nodiscard]] EllgranLaws *laws_of_file() const;
  void fill_laws(int types, std::vector<EllgranLawParameters> &given, std::vector<uint8_t> &is_set) const;
  [[nodiscard]] std::string describe_laws() const;
  [[nodiscard]] bool has_law(int i, int j) const;
  void place_history_fix();
  [[nodiscard]] bool means_something_else(int before, int now);
  virtual class FixEllgranHistory *make_history_fix(const std::string &id);
  void refuse_other_atoms_after_reading() const;
  void refuse_what_cannot_work();
  void require_settings() const;
  void place_step_velocity_fix();
  void find_mass_sources();
  void refresh_body_masses();
  void refresh_contact_masses();
  [[nodiscard]] double contact_mass(int i) const;
  void require_allowed_sizes() const;
  void require_listed_atoms() const;
  void note_end_of_run();
  void require_end_of_run();
  void require_same_images();
  void gather_work();
  void follow_dissipation();
  [[nodiscard]] bool time_passes() const;
  void place_half_step_fix();
  void reserve_loads();
  void add_following_half_step();
  [[nodiscard]] std::array<double, 2> inelastic_powers(int count) const;
  void record_evaluation(const EllgranParticles &particles,
                         const EllgranNeighbourList &neighbours, const EllgranStep &step);
  void copy_history(int i, int j, int *touching);
};

}    // namespace LAMMPS_NS

#endif
#endif
