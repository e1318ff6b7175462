// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// `fix ID group nve/ellipsoid`: moves and turns ellipsoids, as `fix nve/asphere` does. The rotation of a free grain is exact,
/// and a step costs a fraction. Translates LAMMPS' arrays to `ellgran_start_step` and `ellgran_finish_step`; no physics.

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

namespace LAMMPS_NS {

class FixNVEEllipsoid : public Fix {
 public:
  FixNVEEllipsoid(class LAMMPS *, int, char **);
  ~FixNVEEllipsoid() override;
  FixNVEEllipsoid(const FixNVEEllipsoid &) = delete;
  FixNVEEllipsoid &operator=(const FixNVEEllipsoid &) = delete;

  int setmask() override;
  void init() override;
  void initial_integrate(int) override;
  void final_integrate() override;
  void initial_integrate_respa(int, int, int) override;
  void final_integrate_respa(int, int) override;

 private:
  EllgranAtoms atoms;
  EllgranWorkspace *workspace;

  [[nodiscard]] EllgranMotion motion() const;
  [[nodiscard]] double step_of_level(int level) const;
  void start(double time_step);
  void finish(double time_step);
};

}    // namespace LAMMPS_NS

#endif
#endif
