// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_kokkos.h"

#include "error.h"
#include "lammps.h"
#include "library.h"

using namespace LAMMPS_NS;

bool LAMMPS_NS::has_kokkos()
{
  return lammps_config_has_package("KOKKOS") != 0;
}

void LAMMPS_NS::require_host_kokkos(LAMMPS *lmp, const char *caller)
{
  if (!lmp->kokkos) return;
  for (const char *backend : {"cuda", "hip", "sycl"})
    if (lammps_config_accelerator("KOKKOS", "api", backend))
      lmp->error->all(FLERR,
                      "{}: this LAMMPS has KOKKOS for GPUs ({}), on which this style does not run: start it without "
                      "'-k on', or use a LAMMPS with KOKKOS for OpenMP or Serial; docs/kokkos.md says what runs on a GPU",
                      caller, backend);
  if (!lammps_config_accelerator("KOKKOS", "precision", "double"))
    lmp->error->all(FLERR,
                    "{}: this LAMMPS has KOKKOS in single or mixed precision, in which overlaps of grains are lost: start it "
                    "without '-k on', or build it with KOKKOS_PREC=double",
                    caller);
}

void LAMMPS_NS::require_kokkos_in_use(LAMMPS *lmp, const char *caller, const char *style)
{
  if (!lmp->kokkos)
    lmp->error->all(FLERR, "{}: style {}/kk needs LAMMPS to run with KOKKOS: start it with '-k on', or use {}", caller, style,
                    style);
}
