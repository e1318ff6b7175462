// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// `compute contact/ellipsoid/atom`: coordination, fabric and stress of each grain.

#ifdef COMPUTE_CLASS
// clang-format off
ComputeStyle(contact/ellipsoid/atom,ComputeContactEllipsoidAtom);
// clang-format on
#else

#ifndef LMP_COMPUTE_CONTACT_ELLIPSOID_ATOM_H
#define LMP_COMPUTE_CONTACT_ELLIPSOID_ATOM_H

#include "compute.h"

#include "ellgran_atoms.h"
#include "ellgran_contact_sources.h"

#include <string>

namespace LAMMPS_NS {

class ComputeContactEllipsoidAtom : public Compute {
 public:
  ComputeContactEllipsoidAtom(class LAMMPS *, int, char **);
  ~ComputeContactEllipsoidAtom() override;

  void init() override;
  void compute_peratom() override;
  int pack_reverse_comm(int, int, double *) override;
  void unpack_reverse_comm(int, int *, double *) override;
  double memory_usage() override;

 private:
  std::string caller;
  EllgranAtoms atoms;
  EllgranContactSources sources;
  int nmax;
  double **sums;    // of each atom, ghosts included
};

}    // namespace LAMMPS_NS

#endif
#endif
