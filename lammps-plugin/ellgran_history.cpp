// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_history.h"

#include "ellgran_substitute.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "my_page.h"
#include "neigh_list.h"
#include "pair.h"

#include <algorithm>
#include <vector>

using namespace LAMMPS_NS;

FixEllgranHistory::FixEllgranHistory(LAMMPS *lmp, int narg, char **arg) :
    FixNeighHistory(lmp, narg, arg), tells_contacts_apart(false), list_is_current(false), round(-1)
{
  // Contacts are remembered by atom ID: LAMMPS then refuses to give atoms other IDs.
  stores_ids = 1;
}

void FixEllgranHistory::init()
{
  FixNeighHistory::init();
  if (newton_pair && comm->style == Comm::TILED) comm_reverse = 2 + dnum;
}

void FixEllgranHistory::pre_exchange()
{
  if (before_reading) before_reading();
  FixNeighHistory::pre_exchange();
  if (tells_contacts_apart) refuse_second_contacts();
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

FixEllgranHistory *LAMMPS_NS::replace_by_history(Modify *modify, const std::string &old_id,
                                                 const std::string &id, int length)
{
  const SubstituteFix<FixEllgranHistory> substitute(modify, "NEIGH_HISTORY");
  const std::string command = id + " all NEIGH_HISTORY " + std::to_string(length);
  return static_cast<FixEllgranHistory *>(modify->replace_fix(old_id, command, 0));
}
