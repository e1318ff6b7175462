// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// With which builds of LAMMPS' KOKKOS package do the styles give the right answer? Includes no header of Kokkos: one plugin
/// serves a LAMMPS with the package and one without.

#ifndef ELLGRAN_KOKKOS_H
#define ELLGRAN_KOKKOS_H

#include "pointers.h"
#include "utils.h"

namespace LAMMPS_NS {

/// Whether this LAMMPS was built with KOKKOS.
bool has_kokkos();

/// Where LAMMPS runs with KOKKOS ('-k on'), stops unless its arrays are in the memory of the host and in double precision.
void require_host_kokkos(LAMMPS *lmp, const char *caller);

/// For a style with the suffix kk: stops unless LAMMPS runs with KOKKOS. `style` is the one without the suffix.
void require_kokkos_in_use(LAMMPS *lmp, const char *caller, const char *style);

/// The same style for a run with KOKKOS. Pair styles and fixes compute on the host from the arrays that the views of KOKKOS
/// have there: LAMMPS brings them up to date before each call, and hears afterwards that they may have changed.
template <class Style> class EllgranKokkos : public Style {
 public:
  template <class... Words>
  EllgranKokkos(const char *caller, const char *style, LAMMPS *lmp, Words... words) : Style(checked(lmp, caller, style), words...)
  {
    // What is read and what is changed stay as LAMMPS sets them, all of it. No copy follows from that: the host's arrays are
    // those of the backend.
    this->kokkosable = 1;
    this->execution_space = Host;
  }

 private:
  // Before the style is made: its own messages would say less.
  static LAMMPS *checked(LAMMPS *lmp, const char *caller, const char *style)
  {
    require_kokkos_in_use(lmp, caller, style);
    require_host_kokkos(lmp, caller);
    return lmp;
  }
};

/// A fix keeps the name without the suffix once it is made: LAMMPS compares the names of fixes when it hands out what a
/// restart file has for each atom, and a file then goes on with and without KOKKOS.
template <class Style> class EllgranKokkosFix : public EllgranKokkos<Style> {
 public:
  EllgranKokkosFix(const char *caller, const char *style, LAMMPS *lmp, int narg, char **arg) :
      EllgranKokkos<Style>(caller, style, lmp, narg, arg), name(style)
  {
  }
  void post_constructor() override
  {
    Style::post_constructor();
    delete[] this->style;
    this->style = utils::strdup(name);
  }

 private:
  const char *name;
};

}    // namespace LAMMPS_NS

#endif
