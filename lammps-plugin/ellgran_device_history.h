// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// What contacts on a GPU remember, as LAMMPS keeps it for each atom: in restart files, where atoms go to other ranks, and where commands
/// between two runs delete some or give them other IDs. Compiled with the headers of KOKKOS.

#ifndef ELLGRAN_DEVICE_HISTORY_H
#define ELLGRAN_DEVICE_HISTORY_H

#include "ellgran_history.h"

#include "ellgran_device_grains.h"

#include "kokkos_base.h"

namespace LAMMPS_NS {

/// In a run of one rank contacts are remembered on the GPU alone. They come to the atoms when somebody asks for them: a restart file, a
/// run that finds other atoms than the last one ended with, an exchange of atoms between ranks. The next list takes them back.
class FixEllgranDeviceHistory : public FixEllgranHistory, public KokkosBase {
 public:
  FixEllgranDeviceHistory(class LAMMPS *, int, char **);

  // Of the pair style.
  EllgranDeviceGrains *grains;

  void forget() override;
  void pre_exchange() override;
  void post_neighbor() override;
  void post_run() override;
  void write_restart(FILE *) override;
  void unpack_restart(int, int) override;
  int unpack_exchange(int, double *) override;

  /// Whether atoms are others, have other IDs or types, or have been put into another order than when the last run ended.
  [[nodiscard]] bool atoms_have_changed() const;

  /// Whether the atoms have what contacts remember, and no longer the GPU.
  [[nodiscard]] bool is_held() const { return held; }
  /// From the GPU to the atoms, and back, with a new list.
  void take_from_device();
  void give_to_device();
  /// The GPU has gone on with it.
  void let_go();

 private:
  bool held;
};

}    // namespace LAMMPS_NS

#endif
