// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// How does the pair style make a fix of a class of its own, without a style that users see?

#ifndef ELLGRAN_SUBSTITUTE_H
#define ELLGRAN_SUBSTITUTE_H

#include "modify.h"

#include <string>

namespace LAMMPS_NS {

/// While it lives, LAMMPS makes our class when it is asked for its own style. So the fix keeps the
/// name that LAMMPS knows, and there is no style of ours that could be unloaded before the pair style.
class SubstituteFix {
 public:
  SubstituteFix(Modify *modify, const std::string &style, Modify::FixCreator ours) :
      entry((*modify->fix_map)[style]), original(entry)
  {
    entry = ours;
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
