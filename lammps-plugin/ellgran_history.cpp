// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_history.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "memory.h"
#include "my_page.h"
#include "neigh_list.h"
#include "pair.h"

#include <algorithm>
#include <unordered_map>
#include <unordered_set>
#include <vector>

using namespace LAMMPS_NS;

void LAMMPS_NS::require_atom_of_file(LAMMPS *lmp, const std::string &caller, int i, tagint of_file)
{
  if (lmp->atom->tag[i] == of_file) return;
  lmp->error->one(FLERR,
                  "{}: atoms were moved between processors, or deleted, since read_restart (by read_dump or delete_atoms), and LAMMPS gives particle "
                  "{} what the file remembers of the contacts of particle {}: say 'run 0' after read_restart and the fixes, before that command",
                  caller, lmp->atom->tag[i], of_file);
}

FixEllgranHistory::FixEllgranHistory(LAMMPS *lmp, int narg, char **arg) :
    FixNeighHistory(lmp, narg, arg), tells_contacts_apart(false), list_is_current(false), ids_at_end(nullptr), types_at_end(nullptr), room_for_ids(0), round(-1)
{
  // Contacts are remembered by atom ID: LAMMPS then refuses `reset_atoms id`.
  stores_ids = 1;
  // The base class has done its part of it.
  FixEllgranHistory::grow_arrays(atom->nmax);
}

FixEllgranHistory::~FixEllgranHistory()
{
  memory->destroy(ids_at_end);
  memory->destroy(types_at_end);
}

void FixEllgranHistory::init()
{
  FixNeighHistory::init();
  follow_new_ids();
  follow_new_types();
  if (newton_pair && comm->style == Comm::TILED) comm_reverse = 2 + dnum;
}

/* A contact is with the atom that had its ID when the last run ended, if that is still there. */

void FixEllgranHistory::follow_new_ids()
{
  std::vector<tagint> changed;    // old and new ID, and those of new atoms, which may be the IDs of others that are gone
  for (int i = 0; i < atom->nlocal; i++)
    if (ids_at_end[i] != 0 && ids_at_end[i] != atom->tag[i]) {
      changed.push_back(ids_at_end[i]);
      changed.push_back(atom->tag[i]);
    }
  int here = static_cast<int>(changed.size());
  std::vector<int> counts(comm->nprocs), places(comm->nprocs, 0);
  MPI_Allgather(&here, 1, MPI_INT, counts.data(), 1, MPI_INT, world);
  for (int k = 1; k < comm->nprocs; k++) places[k] = places[k - 1] + counts[k - 1];
  std::vector<tagint> all(places.back() + counts.back());
  if (all.empty()) return;
  MPI_Allgatherv(changed.data(), here, MPI_LMP_TAGINT, all.data(), counts.data(), places.data(), MPI_LMP_TAGINT, world);

  std::unordered_map<tagint, tagint> renumbered;
  std::unordered_set<tagint> given;
  for (std::size_t k = 0; k < all.size(); k += 2) {
    if (all[k] != NEW_ATOM) renumbered[all[k]] = all[k + 1];
    given.insert(all[k + 1]);
  }
  for (int i = 0; i < atom->nlocal; i++) {
    int kept = 0;
    for (int k = 0; k < npartner[i]; k++) {
      const auto found = renumbered.find(partner[i][k]);
      // An ID that another atom has now, and that none has given up, is that of an atom that is gone.
      if (found == renumbered.end() && given.count(partner[i][k])) continue;
      partner[i][kept] = (found == renumbered.end()) ? partner[i][k] : found->second;
      if (kept != k) std::copy_n(&valuepartner[i][dnum * k], dnum, &valuepartner[i][dnum * kept]);
      kept++;
    }
    npartner[i] = kept;
    ids_at_end[i] = atom->tag[i];
  }
}

/* Whether any type has changed so that what contacts of its atoms remember means something else. All ranks find the same. */

bool FixEllgranHistory::types_have_changed() const
{
  int here = 0, anywhere = 0;
  if (means_something_else)
    for (int i = 0; i < atom->nlocal && here == 0; i++) here = is_of_other_type(i) ? 1 : 0;
  MPI_Allreduce(&here, &anywhere, 1, MPI_INT, MPI_MAX, world);
  return anywhere != 0;
}

bool FixEllgranHistory::is_of_other_type(int i) const
{
  // Most have the type that they had.
  const int before = types_at_end[i], now = atom->type[i];
  return before != 0 && before != now && means_something_else(before, now);
}

/* Both atoms of a contact remember it: it is over for both, whatever the type of the other. */

void FixEllgranHistory::follow_new_types()
{
  if (types_have_changed()) {
    std::vector<tagint> changed;
    for (int i = 0; i < atom->nlocal; i++)
      if (is_of_other_type(i)) changed.push_back(atom->tag[i]);
    int here = static_cast<int>(changed.size());
    std::vector<int> counts(comm->nprocs), places(comm->nprocs, 0);
    MPI_Allgather(&here, 1, MPI_INT, counts.data(), 1, MPI_INT, world);
    for (int k = 1; k < comm->nprocs; k++) places[k] = places[k - 1] + counts[k - 1];
    std::vector<tagint> all(places.back() + counts.back());
    MPI_Allgatherv(changed.data(), here, MPI_LMP_TAGINT, all.data(), counts.data(), places.data(), MPI_LMP_TAGINT, world);

    const std::unordered_set<tagint> others(all.begin(), all.end());
    int over = 0, over_anywhere = 0;
    for (int i = 0; i < atom->nlocal; i++) {
      const bool all_over = others.count(atom->tag[i]) > 0;
      int kept = 0;
      for (int k = 0; k < npartner[i]; k++) {
        if (all_over || others.count(partner[i][k])) continue;
        partner[i][kept] = partner[i][k];
        if (kept != k) std::copy_n(&valuepartner[i][dnum * k], dnum, &valuepartner[i][dnum * kept]);
        kept++;
      }
      if (kept < npartner[i]) over = 1;
      npartner[i] = kept;
    }
    MPI_Allreduce(&over, &over_anywhere, 1, MPI_INT, MPI_MAX, world);
    if (over_anywhere && comm->me == 0)
      error->warning(FLERR,
                     "Pair gran/ellipsoid: {} atoms have got another type, under whose law contacts remember something else: "
                     "their contacts start with no tangential displacement",
                     all.size());
  }
  std::copy_n(atom->type, atom->nlocal, types_at_end);
}

void FixEllgranHistory::forget()
{
  std::fill_n(npartner, atom->nlocal, 0);
}

void FixEllgranHistory::grow_arrays(int nmax)
{
  FixNeighHistory::grow_arrays(nmax);
  memory->grow(ids_at_end, nmax, "ellgran:ids_at_end");
  memory->grow(types_at_end, nmax, "ellgran:types_at_end");
  if (nmax > room_for_ids) {
    std::fill_n(ids_at_end + room_for_ids, nmax - room_for_ids, 0);
    std::fill_n(types_at_end + room_for_ids, nmax - room_for_ids, 0);
  }
  room_for_ids = nmax;
}

void FixEllgranHistory::copy_arrays(int i, int j, int delflag)
{
  FixNeighHistory::copy_arrays(i, j, delflag);
  ids_at_end[j] = ids_at_end[i];
  types_at_end[j] = types_at_end[i];
}

void FixEllgranHistory::set_arrays(int i)
{
  FixNeighHistory::set_arrays(i);
  ids_at_end[i] = NEW_ATOM;
  types_at_end[i] = 0;
}

int FixEllgranHistory::pack_exchange(int i, double *buffer)
{
  const int n = FixNeighHistory::pack_exchange(i, buffer);
  buffer[n] = ubuf(ids_at_end[i]).d;
  buffer[n + 1] = types_at_end[i];
  return n + 2;
}

int FixEllgranHistory::unpack_exchange(int i, double *buffer)
{
  const int n = FixNeighHistory::unpack_exchange(i, buffer);
  ids_at_end[i] = static_cast<tagint>(ubuf(buffer[n]).i);
  types_at_end[i] = static_cast<int>(buffer[n + 1]);
  return n + 2;
}

/* Type and ID stand behind what the base class reads, which takes no notice of them: earlier releases read these files. */

int FixEllgranHistory::pack_restart(int i, double *buffer)
{
  const int n = FixNeighHistory::pack_restart(i, buffer);
  buffer[n] = (types_at_end[i] != 0) ? types_at_end[i] : atom->type[i];
  buffer[n + 1] = ubuf(atom->tag[i]).d;
  buffer[0] = n + 2;
  return n + 2;
}

void FixEllgranHistory::unpack_restart(int i, int nth)
{
  FixNeighHistory::unpack_restart(i, nth);
  const double *extra = atom->extra[i];
  for (int k = 0; k < nth; k++) extra += static_cast<int>(*extra);
  const int without_type = FixNeighHistory::size_restart(i);
  const bool has_type = static_cast<int>(*extra) > without_type;
  if (static_cast<int>(*extra) > without_type + 1)
    require_atom_of_file(lmp, "Pair gran/ellipsoid", i, static_cast<tagint>(ubuf(extra[without_type + 1]).i));
  // The partners in the file have the IDs that atoms have now: 'reset_atoms id' may follow before the first run.
  ids_at_end[i] = atom->tag[i];
  types_at_end[i] = has_type ? static_cast<int>(extra[without_type]) : 0;
}

int FixEllgranHistory::size_restart(int i)
{
  return FixNeighHistory::size_restart(i) + 2;
}

int FixEllgranHistory::maxsize_restart()
{
  return FixNeighHistory::maxsize_restart() + 2;
}

void FixEllgranHistory::pre_exchange()
{
  if (before_reading) before_reading();
  FixNeighHistory::pre_exchange();
  // ID and type of the last run go with an atom.
  maxexchange += 2;
  if (tells_contacts_apart) refuse_second_contacts();
}

/* A fix may have changed types since the last list was built. */

void FixEllgranHistory::post_neighbor()
{
  follow_new_types();
  FixNeighHistory::post_neighbor();
}

/* LAMMPS finds what a contact remembers by the ID of the other atom: two contacts of the same two would both get that of the first. */

void FixEllgranHistory::refuse_second_contacts() const
{
  // Two images of an atom that one other atom reaches are no farther from each other than twice the cutoff.
  bool possible = false;
  for (int k = 0; k < 3; k++) possible |= domain->periodicity[k] && domain->prd[k] <= 2.0 * force->pair->cutforce;
  if (!possible) return;
  for (int i = 0; i < std::min(nlocal_neigh, atom->nlocal); i++) {
    std::vector<tagint> others(partner[i], partner[i] + npartner[i]);
    std::sort(others.begin(), others.end());
    const auto twice = std::adjacent_find(others.begin(), others.end());
    if (twice != others.end())
      error->one(FLERR,
                 "Pair gran/ellipsoid: particle {} touches {}, across a periodic boundary: contacts are remembered by atom ID, and one would take "
                 "what the other remembers: the periodic box must be longer than twice the largest grain",
                 atom->tag[i], (*twice == atom->tag[i]) ? "itself" : fmt::format("particle {} in two places", *twice));
  }
}

void FixEllgranHistory::pre_exchange_newton()
{
  if (comm->style != Comm::TILED) {
    FixNeighHistory::pre_exchange_newton();
    return;
  }

  const NeighList *neighbours = pair->list;
  const auto each_contact = [&](auto &&visit) {
    for (int ii = 0; ii < neighbours->inum; ii++) {
      const int i = neighbours->ilist[ii];
      for (int k = 0; k < neighbours->numneigh[i]; k++)
        if (firstflag[i][k])
          visit(i, neighbours->firstneigh[i][k] & NEIGHMASK, &firstvalue[i][dnum * k]);
    }
  };

  // How many contacts each atom has, those that a neighbouring processor lists with its ghost included.
  const int here = std::max(nall_neigh, atom->nlocal + atom->nghost);
  std::fill_n(npartner, here, 0);
  each_contact([this](int i, int j, const double *) {
    npartner[i]++;
    npartner[j]++;
  });
  commflag = NPARTNER;
  comm->reverse_comm(this, 1);

  ipage_atom->reset();
  dpage_atom->reset();
  int most_of_ghosts = 0, rounds = 0;
  for (int i = 0; i < nall_neigh; i++) {
    partner[i] = ipage_atom->get(npartner[i]);
    valuepartner[i] = dpage_atom->get(dnum * npartner[i]);
    if (!partner[i] || !valuepartner[i])
      error->one(FLERR, "Neighbor history overflow: raise 'neigh_modify one', now {}", oneatom);
    if (i >= nlocal_neigh) most_of_ghosts = std::max(most_of_ghosts, npartner[i]);
  }
  MPI_Allreduce(&most_of_ghosts, &rounds, 1, MPI_INT, MPI_MAX, world);

  std::fill_n(npartner, here, 0);
  each_contact([this](int i, int j, double *values) {
    std::copy_n(values, dnum, add_partner(i, atom->tag[j]));
    pair->transfer_history(values, add_partner(j, atom->tag[i]), atom->type[i], atom->type[j]);
  });

  // Each ghost sends one contact a round. A ghost that itself collects from ghosts has its contact of a round by
  // then: processors are asked in the order in which what they collect must be there.
  for (round = 0; round < rounds; round++) comm->reverse_comm(this, 2 + dnum);
  round = -1;

  maxpartner = (nlocal_neigh > 0) ? *std::max_element(npartner, npartner + nlocal_neigh) : 0;
  maxexchange = (dnum + 1) * maxpartner + 1;
  for (int i = nlocal_neigh; i < atom->nlocal; i++) npartner[i] = 0;
}

double *FixEllgranHistory::add_partner(int i, tagint partner_id)
{
  const int place = npartner[i]++;
  partner[i][place] = partner_id;
  return &valuepartner[i][dnum * place];
}

int FixEllgranHistory::pack_reverse_comm(int n, int first, double *buffer)
{
  if (round < 0) return FixNeighHistory::pack_reverse_comm(n, first, buffer);
  double *next = buffer;
  for (int i = first; i < first + n; i++, next += 2 + dnum) {
    std::fill_n(next, 2 + dnum, 0.0);
    if (round >= npartner[i]) continue;
    next[0] = 1.0;
    next[1] = ubuf(partner[i][round]).d;
    std::copy_n(&valuepartner[i][dnum * round], dnum, next + 2);
  }
  return static_cast<int>(next - buffer);
}

void FixEllgranHistory::unpack_reverse_comm(int n, int *indices, double *buffer)
{
  if (round < 0) {
    FixNeighHistory::unpack_reverse_comm(n, indices, buffer);
    return;
  }
  const double *next = buffer;
  for (int k = 0; k < n; k++, next += 2 + dnum)
    if (next[0] != 0.0)
      std::copy_n(next + 2, dnum,
                  add_partner(indices[k], static_cast<tagint>(ubuf(next[1]).i)));
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
  remember_atoms();
  list_is_current = false;
}

void FixEllgranHistory::remember_atoms()
{
  std::copy_n(atom->tag, atom->nlocal, ids_at_end);
  std::copy_n(atom->type, atom->nlocal, types_at_end);
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
