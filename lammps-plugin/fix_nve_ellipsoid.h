// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// `fix ID group nve/ellipsoid`: moves and turns ellipsoids, as `fix nve/asphere` does. The rotation of a free grain is exact,
/// forces may see velocities of the step at which they are computed, and a step costs a fraction. Translates LAMMPS' arrays
/// to `ellgran_start_step` and `ellgran_finish_step`; no physics.

#ifdef FIX_CLASS
// clang-format off
FixStyle(nve/ellipsoid,FixNVEEllipsoid);
// clang-format on
#else

#ifndef LMP_FIX_NVE_ELLIPSOID_H
#define LMP_FIX_NVE_ELLIPSOID_H

#include "fix.h"

#include "ellgran.h"
#include "ellgran_atoms.h"

#include <functional>
#include <vector>

namespace LAMMPS_NS {

class FixNVEEllipsoid : public Fix {
 public:
  FixNVEEllipsoid(class LAMMPS *, int, char **);
  ~FixNVEEllipsoid() override;
  FixNVEEllipsoid(const FixNVEEllipsoid &) = delete;
  FixNVEEllipsoid &operator=(const FixNVEEllipsoid &) = delete;

  int setmask() override;
  void init() override;
  void setup_pre_exchange() override;
  void setup_pre_force(int) override;
  void setup(int) override;
  void initial_integrate(int) override;
  void final_integrate() override;
  void initial_integrate_respa(int, int, int) override;
  void final_integrate_respa(int, int) override;

  /// The fix that keeps the velocity changes of all atoms that fixes of this style move; nullptr where all of them leave
  /// the velocities of the half step to the forces. Call it when fixes and their groups are known, in an `init`.
  static FixNVEEllipsoid *keeper_of(class Modify *modify);

  /// While forces are computed: hands out what velocities and angular momenta have more than those of the half step. With
  /// ghosts it communicates: all processors call it in the same step. When a run starts, hands out the velocities that
  /// the last forces of the run before saw, where `v` is no longer (or not yet) that.
  void lend_changes(EllgranParticles &particles, bool with_ghosts);

  /// Does something that reads the velocities of the step as integrated, while a run starts or at any other time.
  static void with_integrated_velocities(class Modify *modify, const std::function<void()> &action);

  double memory_usage() override;
  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;
  int size_restart(int) override;
  int maxsize_restart() override;
  int pack_restart(int, double *) override;
  void unpack_restart(int, int) override;
  void write_restart(FILE *) override;
  void restart(char *) override;

  // Does what the base class does, whose symbol has the width of atom IDs in its name: not to need it
  // lets a LAMMPS with other integer sizes load the plugin, which then says what is wrong.
  void set_molecule(int, tagint, int, double *, double *, double *) override;

 private:
  EllgranAtoms atoms;
  EllgranWorkspace *workspace;
  bool of_step;              // the word `velocities step`: forces see velocities of the step
  FixNVEEllipsoid *keeper;   // has the arrays for this fix too; nullptr: velocities of the half step
  int swapped_bits;          // of the keeper, while a run starts: groups whose `v` is what the last forces saw
  double time_step_before;   // 0: not known

  // With the velocity changes of the half step while forces are computed, with those to the velocities that the last
  // forces saw between steps.
  double **changes;
  double **loads_before;    // forces and torques when the last step began
  std::vector<double> velocities, angular_momenta;

  [[nodiscard]] EllgranMotion motion() const;
  [[nodiscard]] double step_of_level(int level) const;
  void start(double time_step);
  void finish(double time_step);
  void swap(double sign);
  void forget();
  [[nodiscard]] bool keeps() const { return of_step && changes; }
};

}    // namespace LAMMPS_NS

#endif
#endif
