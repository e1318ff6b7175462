// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// How does LAMMPS make a fix of ours without a style of ours?

#ifndef ELLGRAN_SUBSTITUTE_H
#define ELLGRAN_SUBSTITUTE_H

#include "modify.h"

#include <string>

namespace LAMMPS_NS {

/// While it lives, LAMMPS makes a `FixClass` when it is asked for its own `style`. So the fix keeps a name that LAMMPS
/// knows, and there is no style of ours that could be unloaded before its owner.
template <class FixClass> class SubstituteFix {
 public:
  SubstituteFix(Modify *modify, const std::string &style) :
      entry((*modify->fix_map)[style]), original(entry)
  {
    entry = [](LAMMPS *lmp, int narg, char **arg) -> Fix * { return new FixClass(lmp, narg, arg); };
  }
  ~SubstituteFix() { entry = original; }
  SubstituteFix(const SubstituteFix &) = delete;
  SubstituteFix &operator=(const SubstituteFix &) = delete;

 private:
  Modify::FixCreator &entry;
  const Modify::FixCreator original;
};

}    // namespace LAMMPS_NS

#endif
