/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "ellgran_pair_history.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "ellgran_contact.h"
#include "error.h"
#include "fix_ellgran_restart_format.h"
#include "memory.h"
#include "modify.h"
#include "neighbor.h"
#include "pair_gran.h"
#include "update.h"
#include "vector_liggghts.h"

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
  refuse_ids_twice();
  // 'write_restart' has no list built.
  follow_new_ids();
}

// 'replicate' puts copies where the list of the last run has images.
void EllgranPairHistory::post_run()
{
  EllgranContact::write_kept_histories(lmp);
  pre_exchange();
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
  int copied = 0;  // whether several particles are remembered under one ID
  for (size_t k = 0; k < all.size(); k += 2) {
    if (all[k] != 0 && !renumbered.insert(std::make_pair(all[k], all[k + 1])).second) copied = 1;
    given.insert(all[k + 1]);
  }
  for (int i = 0; i < atom->nlocal; i++)
    if (ids_[i] == tag[i] && renumbered.count(tag[i])) copied = 1;
  int any_copied = 0;
  MPI_Allreduce(&copied, &any_copied, 1, MPI_INT, MPI_MAX, world);
  Candidates candidates;
  if (any_copied) {
    find_candidates(renumbered, candidates);
    own_histories();
  }
  for (int i = 0; i < atom->nlocal; i++) {
    int kept = 0;
    for (int k = 0; k < npartner_[i]; k++) {
      const int partner = partner_[i][k];
      const std::map<int, int>::const_iterator found = renumbered.find(partner);
      // An ID that another particle has now, and that none has given up, is that of a particle that is gone.
      if (found == renumbered.end() && given.count(partner)) continue;
      const Candidates::const_iterator several = candidates.find(partner);
      if (several != candidates.end())
        partner_[i][kept] = nearest(several->second, atom->x[i]);
      else
        partner_[i][kept] = (found == renumbered.end()) ? partner : found->second;
      if (kept != k) vectorCopyN(contacthistory(i, k), contacthistory(i, kept), dnum_);
      kept++;
    }
    npartner_[i] = kept;
  }
  std::copy(tag, tag + atom->nlocal, ids_);
}

// The particles that are remembered under each of the IDs that 'renumbered' begins with, of all processors.
void EllgranPairHistory::find_candidates(const std::map<int, int> &renumbered, Candidates &candidates)
{
  std::vector<double> own;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!renumbered.count(ids_[i])) continue;
    own.push_back(ids_[i]);
    own.push_back(atom->tag[i]);
    own.insert(own.end(), atom->x[i], atom->x[i] + 3);
  }
  int here = own.size();
  std::vector<int> counts(comm->nprocs), places(comm->nprocs, 0);
  MPI_Allgather(&here, 1, MPI_INT, &counts[0], 1, MPI_INT, world);
  for (int k = 1; k < comm->nprocs; k++) places[k] = places[k - 1] + counts[k - 1];
  std::vector<double> all(places.back() + counts.back());
  MPI_Allgatherv(own.empty() ? NULL : &own[0], here, MPI_DOUBLE, &all[0], &counts[0], &places[0], MPI_DOUBLE, world);
  for (size_t k = 0; k < all.size(); k += 5) {
    Candidate candidate;
    candidate.id = static_cast<int>(all[k + 1]);
    std::copy(&all[k + 2], &all[k + 2] + 3, candidate.position);
    candidates[static_cast<int>(all[k])].push_back(candidate);
  }
}

// The contact goes on with the one that it is with: the other ones are a box, or what 'replicate' calls offset, away.
int EllgranPairHistory::nearest(const std::vector<Candidate> &candidates, const double *position)
{
  int id = 0;
  double least = 0.0;
  for (size_t k = 0; k < candidates.size(); k++) {
    double apart[3];
    vectorSubtract3D(candidates[k].position, position, apart);
    domain->minimum_image(apart);
    const double distance = vectorMag3DSquared(apart);
    if (id != 0 && distance >= least) continue;
    id = candidates[k].id;
    least = distance;
  }
  return id;
}

// Copies share the memory of their originals, which are to remember other partners.
void EllgranPairHistory::own_histories()
{
  for (int i = 0; i < atom->nlocal; i++) {
    const int count = npartner_[i];
    if (ids_[i] == atom->tag[i] || count == 0) continue;
    const int *const partners = partner_[i];
    const double *const histories = contacthistory_[i];
    partner_[i] = ipage_->get(count);
    contacthistory_[i] = dpage_->get(count * dnum_);
    if (!partner_[i] || !contacthistory_[i]) error->one(FLERR, "Contact history overflow, boost neigh_modify one");
    std::copy(partners, partners + count, partner_[i]);
    std::copy(histories, histories + count * dnum_, contacthistory_[i]);
  }
}

// Two particles of one ID would mix up their friction.
void EllgranPairHistory::refuse_ids_twice()
{
  // Each processor looks at the IDs of one remainder.
  const int processors = comm->nprocs;
  std::vector<int> to(processors, 0), from(processors), places(processors, 0), places_from(processors, 0);
  for (int i = 0; i < atom->nlocal; i++) to[std::abs(atom->tag[i]) % processors]++;
  MPI_Alltoall(&to[0], 1, MPI_INT, &from[0], 1, MPI_INT, world);
  for (int k = 1; k < processors; k++) {
    places[k] = places[k - 1] + to[k - 1];
    places_from[k] = places_from[k - 1] + from[k - 1];
  }
  std::vector<int> sent(atom->nlocal + 1), ids(places_from.back() + from.back() + 1), next(places);
  for (int i = 0; i < atom->nlocal; i++) sent[next[std::abs(atom->tag[i]) % processors]++] = atom->tag[i];
  MPI_Alltoallv(&sent[0], &to[0], &places[0], MPI_INT, &ids[0], &from[0], &places_from[0], MPI_INT, world);
  ids.pop_back();
  std::sort(ids.begin(), ids.end());
  const std::vector<int>::const_iterator found = std::adjacent_find(ids.begin(), ids.end());
  int twice = found == ids.end() ? 0 : *found, particle = 0;
  MPI_Allreduce(&twice, &particle, 1, MPI_INT, MPI_MAX, world);
  if (particle == 0) return;
  char message[300];
  snprintf(message, sizeof(message),
           "pair_style gran: two particles have the ID %d, by which contacts are remembered. (LIGGGHTS' replicate gives copies IDs of other particles on "
           "more than one processor, and where IDs have gaps.)",
           particle);
  error->all(FLERR, message);
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
