/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_ellgran_restart_format.h"

#include <cstring>

#include "comm.h"
#include "ellgran.h"
#include "ellgran_pair_history.h"
#include "error.h"
#include "modify.h"

using namespace LAMMPS_NS;

namespace {

const char ID[] = "ellgran_restart_format";

// In the restart file, in all versions of it.
struct State {
  int version;
  char writer[28];  // version of ellgran
};

// From version 3 on the names of what contacts of pairs remember follow, a string.
const int WITHOUT_NAMES = 2;

}

FixEllgranRestartFormat::FixEllgranRestartFormat(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg), histories_lost_(0), has_read_(false)
{
  restart_global = 1;
}

void FixEllgranRestartFormat::add(LAMMPS *lmp)
{
  if (lmp->modify->find_fix(ID) >= 0) return;
  char id[] = "ellgran_restart_format", group[] = "all", style[] = "ellgran/restart_format";
  char *words[] = {id, group, style};
  lmp->modify->add_fix(3, words);
}

bool FixEllgranRestartFormat::has_read(LAMMPS *lmp)
{
  const int place = lmp->modify->find_fix(ID);
  return place >= 0 && static_cast<FixEllgranRestartFormat *>(lmp->modify->fix[place])->has_read_;
}

void FixEllgranRestartFormat::note_lost_histories(Modify *modify)
{
  const int place = modify->find_fix(ID);
  if (place >= 0) static_cast<FixEllgranRestartFormat *>(modify->fix[place])->histories_lost_ = 1;
}

bool FixEllgranRestartFormat::take_lost_histories(LAMMPS *lmp)
{
  const int place = lmp->modify->find_fix(ID);
  if (place < 0) return false;
  FixEllgranRestartFormat *const fix = static_cast<FixEllgranRestartFormat *>(lmp->modify->fix[place]);
  int lost = 0;
  MPI_Allreduce(&fix->histories_lost_, &lost, 1, MPI_INT, MPI_MAX, lmp->world);
  fix->histories_lost_ = 0;
  return lost != 0;
}

std::string FixEllgranRestartFormat::take_names_of_file(LAMMPS *lmp)
{
  std::string names;
  const int place = lmp->modify->find_fix(ID);
  if (place >= 0) names.swap(static_cast<FixEllgranRestartFormat *>(lmp->modify->fix[place])->names_of_file_);
  return names;
}

void FixEllgranRestartFormat::write_restart(FILE *fp)
{
  if (comm->me != 0) return;
  State state;
  memset(&state, 0, sizeof(state));
  state.version = VERSION;
  strncpy(state.writer, ellgran_version(), sizeof(state.writer) - 1);
  const std::string names = EllgranPairHistory::names_of_values(modify);
  const int size = sizeof(state) + names.size() + 1;
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(&state, 1, sizeof(state), fp);
  fwrite(names.c_str(), 1, names.size() + 1, fp);
}

void FixEllgranRestartFormat::restart(char *buffer)
{
  has_read_ = true;
  State state;
  memcpy(&state, buffer, sizeof(state));
  state.writer[sizeof(state.writer) - 1] = '\0';
  if (state.version >= WITHOUT_NAMES && state.version <= VERSION) {
    if (state.version > WITHOUT_NAMES) names_of_file_ = buffer + sizeof(state);
    return;
  }
  char message[400];
  snprintf(message, sizeof(message),
           "ellgran: the restart file has format version %d of contact histories, written by ellgran %s. This is ellgran %s, which "
           "reads versions 1 to %d: use the ellgran that wrote the file, or a later one",
           state.version, state.writer, ellgran_version(), static_cast<int>(VERSION));
  error->all(FLERR, message);
}
