/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "ellgran_pair_history.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "atom.h"
#include "comm.h"
#include "ellgran_contact.h"
#include "error.h"
#include "fix_ellgran_restart_format.h"
#include "memory.h"
#include "modify.h"
#include "neighbor.h"
#include "pair_gran.h"
#include "update.h"

using namespace LAMMPS_NS;
using LIGGGHTS::ContactModels::EllgranContact;

namespace {

// what the pair style keeps to itself
struct Owner : public PairGran {
  static FixContactHistory *PairGran::*history() { return &Owner::fix_history; }
};

}

void EllgranPairHistory::replace(LAMMPS *lmp, PairGran *pair)
{
  const std::string names_of_file = FixEllgranRestartFormat::take_names_of_file(lmp);
  FixContactHistory *const original = pair->*Owner::history();
  if (!original || dynamic_cast<EllgranPairHistory *>(original)) return;

  // The words with which the pair style made it.
  const int length = original->get_dnum();
  const int *const newton = original->*(&EllgranPairHistory::newtonflag_);
  char *const *const names = original->*(&EllgranPairHistory::history_id_);
  char number[16];
  snprintf(number, sizeof(number), "%d", length);
  std::vector<std::string> words;
  words.push_back(original->id);
  words.push_back("all");
  words.push_back(original->style);
  words.push_back(number);
  for (int k = 0; k < length; k++) {
    words.push_back(names[k]);
    words.push_back(newton[k] ? "1" : "0");
  }
  std::vector<char *> arg;
  for (size_t k = 0; k < words.size(); k++) arg.push_back(const_cast<char *>(words[k].c_str()));

  // An empty place among the fixes is that of the fix which is being made.
  Modify *const modify = lmp->modify;
  const int place = modify->find_fix(original->id);
  modify->fix[place] = NULL;
  EllgranPairHistory *const history = new EllgranPairHistory(lmp, arg.size(), &arg[0]);
  modify->fix[place] = history;
  modify->fmask[place] = history->setmask();
  history->take(original);
  pair->*Owner::history() = history;
  delete original;
  if (!names_of_file.empty() && names_of_file != names_of_values(modify)) {
    std::fill_n(history->npartner_, lmp->atom->nlocal, 0);
    if (lmp->comm->me == 0)
      lmp->error->warning(FLERR,
                          "pair_style: the restart file is of models under which contacts of grains remember something else: contacts that exist start "
                          "with no tangential displacement");
  }
  // Normals, from which the search for contacts starts, are no loss.
  const bool remembers = !pair->contact_match("tangential", "off") || !pair->contact_match("rolling_friction", "off");
  if (FixEllgranRestartFormat::take_lost_histories(lmp) && remembers && lmp->comm->me == 0)
    lmp->error->warning(FLERR,
                        "pair_style was given again, and with the one before LIGGGHTS has deleted what contacts of grains remembered: contacts that "
                        "exist start with no tangential displacement");
}

std::string EllgranPairHistory::names_of_values(Modify *modify)
{
  std::string names;
  for (int f = 0; f < modify->nfix; f++)
    if (const EllgranPairHistory *const history = dynamic_cast<EllgranPairHistory *>(modify->fix[f]))
      for (int k = 0; k < history->dnum_; k++) names += std::string(" ") + history->history_id_[k];
  return names;
}

EllgranPairHistory::EllgranPairHistory(LAMMPS *lmp, int narg, char **arg) : FixContactHistory(lmp, narg, arg), has_run_(false), ids_(NULL)
{
  // The base class has done its part of it.
  grow_arrays(atom->nmax);
}

// With the pair style, where another one takes its place.
EllgranPairHistory::~EllgranPairHistory()
{
  if (has_run_) FixEllgranRestartFormat::note_lost_histories(modify);
  memory->destroy(ids_);
}

void EllgranPairHistory::take(FixContactHistory *other)
{
  std::swap(npartner_, other->*(&EllgranPairHistory::npartner_));
  std::swap(partner_, other->*(&EllgranPairHistory::partner_));
  std::swap(contacthistory_, other->*(&EllgranPairHistory::contacthistory_));
  std::swap(maxtouch_, other->*(&EllgranPairHistory::maxtouch_));
  std::swap(pgsize_, other->*(&EllgranPairHistory::pgsize_));
  std::swap(oneatom_, other->*(&EllgranPairHistory::oneatom_));
  std::swap(ipage_, other->*(&EllgranPairHistory::ipage_));
  std::swap(dpage_, other->*(&EllgranPairHistory::dpage_));
  recent_restart = other->recent_restart;
  restart_reset = other->restart_reset;
  just_created = 0;  // or LIGGGHTS sets up all particles as new ones
  std::copy(atom->tag, atom->tag + atom->nlocal, ids_);
}

// When a run begins, before the neighbour lists, which have pages of the same size, are made anew.
void EllgranPairHistory::allocate_pages()
{
  if (!ipage_ || (pgsize_ == neighbor->pgsize && oneatom_ == neighbor->oneatom)) {
    FixContactHistory::allocate_pages();
    return;
  }
  if (computeflag_ && *computeflag_) FixContactHistory::pre_exchange();
  std::vector<int> partners;
  std::vector<double> histories;
  for (int i = 0; i < atom->nlocal; i++) {
    if (npartner_[i] == 0) continue;
    partners.insert(partners.end(), partner_[i], partner_[i] + npartner_[i]);
    histories.insert(histories.end(), contacthistory_[i], contacthistory_[i] + npartner_[i] * dnum_);
  }
  FixContactHistory::allocate_pages();
  size_t from = 0;
  for (int i = 0; i < atom->nlocal; i++) {
    const int count = npartner_[i];
    if (count == 0) continue;
    partner_[i] = ipage_->get(count);
    contacthistory_[i] = dpage_->get(count * dnum_);
    if (!partner_[i] || !contacthistory_[i]) error->one(FLERR, "Contact history overflow, boost neigh_modify one");
    std::copy(&partners[from], &partners[from] + count, partner_[i]);
    std::copy(&histories[from * dnum_], &histories[from * dnum_] + count * dnum_, contacthistory_[i]);
    from += count;
  }
}

int EllgranPairHistory::setmask()
{
  return FixContactHistory::setmask() | FixConst::PRE_NEIGHBOR;
}

void EllgranPairHistory::setup_pre_exchange()
{
  FixContactHistory::setup_pre_exchange();
  has_run_ = true;
  // 'write_restart' has no list built.
  follow_new_ids();
}

void EllgranPairHistory::setup_pre_neighbor()
{
  follow_new_ids();
}

void EllgranPairHistory::pre_neighbor()
{
  follow_new_ids();
}

void EllgranPairHistory::pre_exchange()
{
  // Since it was read, the list has not been used, and particles may have gone to other places.
  if (!*computeflag_) return;
  FixContactHistory::pre_exchange();
  // the ID goes with a particle
  comm->maxexchange_fix = std::max(comm->maxexchange_fix, (dnum_ + 1) * maxtouch_ + 2);
}

void EllgranPairHistory::follow_new_ids()
{
  const int *const tag = atom->tag;
  std::vector<int> changed;  // ID under which a particle is remembered, and its ID now
  for (int i = 0; i < atom->nlocal; i++)
    if (ids_[i] != tag[i]) {
      changed.push_back(ids_[i]);
      changed.push_back(tag[i]);
    }
  int here = changed.size();
  std::vector<int> counts(comm->nprocs), places(comm->nprocs, 0);
  MPI_Allgather(&here, 1, MPI_INT, &counts[0], 1, MPI_INT, world);
  for (int k = 1; k < comm->nprocs; k++) places[k] = places[k - 1] + counts[k - 1];
  std::vector<int> all(places.back() + counts.back());
  if (all.empty()) return;
  MPI_Allgatherv(changed.empty() ? NULL : &changed[0], here, MPI_INT, &all[0], &counts[0], &places[0], MPI_INT, world);

  std::map<int, int> renumbered;
  std::set<int> given;
  for (size_t k = 0; k < all.size(); k += 2) {
    if (all[k] != 0) renumbered[all[k]] = all[k + 1];
    given.insert(all[k + 1]);
  }
  for (int i = 0; i < atom->nlocal; i++) {
    int kept = 0;
    for (int k = 0; k < npartner_[i]; k++) {
      const std::map<int, int>::const_iterator found = renumbered.find(partner_[i][k]);
      // An ID that another particle has now, and that none has given up, is that of a particle that is gone.
      if (found == renumbered.end() && given.count(partner_[i][k])) continue;
      partner_[i][kept] = (found == renumbered.end()) ? partner_[i][k] : found->second;
      if (kept != k) vectorCopyN(contacthistory(i, k), contacthistory(i, kept), dnum_);
      kept++;
    }
    npartner_[i] = kept;
    ids_[i] = tag[i];
  }
}

double EllgranPairHistory::memory_usage()
{
  return FixContactHistory::memory_usage() + static_cast<double>(atom->nmax) * sizeof(int);
}

void EllgranPairHistory::grow_arrays(int count)
{
  FixContactHistory::grow_arrays(count);
  memory->grow(ids_, count, "ellgran:ids");
}

void EllgranPairHistory::copy_arrays(int from, int to, int deleted)
{
  FixContactHistory::copy_arrays(from, to, deleted);
  ids_[to] = ids_[from];
}

void EllgranPairHistory::set_arrays(int particle)
{
  FixContactHistory::set_arrays(particle);
  ids_[particle] = 0;
}

int EllgranPairHistory::pack_exchange(int particle, double *buffer)
{
  const int count = FixContactHistory::pack_exchange(particle, buffer);
  buffer[count] = ids_[particle];
  return count + 1;
}

int EllgranPairHistory::unpack_exchange(int particle, double *buffer)
{
  const int count = FixContactHistory::unpack_exchange(particle, buffer);
  ids_[particle] = static_cast<int>(buffer[count]);
  return count + 1;
}

// LIGGGHTS packs the particles later.
void EllgranPairHistory::write_restart(FILE *fp)
{
  // 1: of a run, as class Update has it
  if (update->whichflag == 1) {
    EllgranContact::write_kept_histories(lmp);
    pre_exchange();
  }
  FixContactHistory::write_restart(fp);
}

void EllgranPairHistory::unpack_restart(int particle, int place)
{
  FixContactHistory::unpack_restart(particle, place);
  ids_[particle] = atom->tag[particle];
}
