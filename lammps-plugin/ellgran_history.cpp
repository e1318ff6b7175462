// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_history.h"

#include "ellgran_substitute.h"

#include "comm.h"
#include "error.h"
#include "modify.h"

using namespace LAMMPS_NS;

FixEllgranHistory::FixEllgranHistory(LAMMPS *lmp, int narg, char **arg) :
    FixNeighHistory(lmp, narg, arg), list_is_current(false)
{
}

void FixEllgranHistory::pre_exchange()
{
  if (before_reading) before_reading();
  FixNeighHistory::pre_exchange();
}

void FixEllgranHistory::setup(int)
{
  list_is_current = true;
}

void FixEllgranHistory::min_setup(int)
{
  list_is_current = true;
}

void FixEllgranHistory::post_run()
{
  FixNeighHistory::post_run();
  list_is_current = false;
}

void FixEllgranHistory::write_restart(FILE *fp)
{
  if (list_is_current) {
    FixNeighHistory::write_restart(fp);
  } else if (comm->me == 0) {
    const int size = 0;
    fwrite(&size, sizeof(int), 1, fp);
  }
}

void FixEllgranHistory::set_molecule(int, tagint, int, double *, double *, double *)
{
  error->all(FLERR, "Molecule update not implemented for fix {}", style);
}

namespace {

Fix *create_history(LAMMPS *lmp, int narg, char **arg)
{
  return new FixEllgranHistory(lmp, narg, arg);
}

}    // namespace

FixEllgranHistory *LAMMPS_NS::replace_by_history(Modify *modify, const std::string &old_id,
                                                 const std::string &id, int length)
{
  const SubstituteFix substitute(modify, "NEIGH_HISTORY", &create_history);
  const std::string command = id + " all NEIGH_HISTORY " + std::to_string(length);
  return static_cast<FixEllgranHistory *>(modify->replace_fix(old_id, command, 0));
}
