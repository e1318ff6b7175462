// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_device_history.h"

#include "atom_kokkos.h"
#include "atom_masks.h"
#include "comm.h"
#include "error.h"
#include "my_page.h"
#include "neighbor.h"
#include "pair.h"

#include <algorithm>
#include <unordered_map>
#include <vector>

using namespace LAMMPS_NS;

FixEllgranDeviceHistory::FixEllgranDeviceHistory(LAMMPS *lmp, int narg, char **arg) :
    FixEllgranHistory(lmp, narg, arg), grains(nullptr), held(false)
{
  // Nothing of an atom has to be sent or sorted on the GPU: with one rank no atom leaves it, with several LAMMPS sends them from the host.
  sort_device = 1;
  exchange_comm_device = (comm->nprocs == 1) ? 1 : 0;
  // What is read here is asked for where it is read: LAMMPS would copy all atoms to the host with each new list.
  kokkosable = 1;
  execution_space = Device;
  datamask_read = datamask_modify = EMPTY_MASK;
}

void FixEllgranDeviceHistory::forget()
{
  // The GPU takes from the atoms what they remember, which is nothing.
  FixEllgranHistory::forget();
  held = true;
}

void FixEllgranDeviceHistory::post_neighbor()
{
  nlocal_neigh = atom->nlocal;
  nall_neigh = atom->nlocal + atom->nghost;
}

void FixEllgranDeviceHistory::pre_exchange()
{
  if (comm->nprocs > 1) take_from_device();
}

void FixEllgranDeviceHistory::post_run()
{
  // With one rank no command between two runs takes an atom away from what the GPU knows of it: it can be asked later.
  if (comm->nprocs > 1) take_from_device();
  static_cast<AtomKokkos *>(atom)->sync(Host, TAG_MASK | TYPE_MASK);
  remember_atoms();
  list_is_current = false;
}

void FixEllgranDeviceHistory::write_restart(FILE *fp)
{
  if (list_is_current || !held) take_from_device();
  if (comm->me == 0) {
    const int size = 0;
    fwrite(&size, sizeof(int), 1, fp);
  }
}

void FixEllgranDeviceHistory::unpack_restart(int i, int nth)
{
  FixEllgranHistory::unpack_restart(i, nth);
  held = true;
}

/* A rank to which no atom of a restart file belonged may get some before the first step. */

int FixEllgranDeviceHistory::unpack_exchange(int i, double *buffer)
{
  held = true;
  return FixEllgranHistory::unpack_exchange(i, buffer);
}

bool FixEllgranDeviceHistory::atoms_have_changed() const
{
  static_cast<AtomKokkos *>(atom)->sync(Host, TAG_MASK | TYPE_MASK);
  return atom->nlocal != grains->owned_in_list() || !std::equal(ids_at_end, ids_at_end + atom->nlocal, atom->tag) ||
      !std::equal(types_at_end, types_at_end + atom->nlocal, atom->type);
}

/* The row that keeps a pair of two atoms of this rank is that of the one with the lower ID. Both of them then remember it, each as of
   the pair whose first atom it is; an atom and an image, the atom alone. */

void FixEllgranDeviceHistory::take_from_device()
{
  if (!grains->has_list()) return;
  static_cast<AtomKokkos *>(atom)->sync(Host, TAG_MASK);
  const auto &rows = grains->rows();
  const auto pairs = grains->remembered();

  struct Contact {
    tagint partner;
    const double *history;
    bool turned;    // it is as of the pair whose first grain is the partner
  };
  std::vector<std::vector<Contact>> of_row(rows.owned);
  for (int k = 0; k < rows.owned; k++)
    for (uint32_t e = rows.starts[k]; e < rows.starts[k + 1]; e++) {
      if (!pairs.touching[e]) continue;
      const int other = static_cast<int>(rows.neighbours[e]);
      const double *const history = &pairs.histories[e * pairs.length];
      const bool first = rows.ids[k] < rows.ids[other];
      of_row[k].push_back({rows.ids[other], history, !first});
      if (other < rows.owned) of_row[other].push_back({rows.ids[k], history, first});
    }

  std::unordered_map<tagint, int> row_of;
  for (int k = 0; k < rows.owned; k++) row_of[rows.ids[k]] = k;
  const std::vector<Contact> none;
  ipage_atom->reset();
  dpage_atom->reset();
  maxpartner = 0;
  for (int i = 0; i < atom->nlocal; i++) {
    const auto found = row_of.find(list_is_current ? atom->tag[i] : ids_at_end[i]);
    const auto &contacts = (found == row_of.end()) ? none : of_row[found->second];
    const int n = static_cast<int>(contacts.size());
    npartner[i] = n;
    partner[i] = ipage_atom->get(n);
    valuepartner[i] = dpage_atom->get(dnum * n);
    if (!partner[i] || !valuepartner[i])
      error->one(FLERR, "Neighbor history overflow: raise 'neigh_modify one', now {}", oneatom);
    maxpartner = std::max(maxpartner, n);
    for (int k = 0; k < n; k++) {
      partner[i][k] = contacts[k].partner;
      double *const own = &valuepartner[i][dnum * k];
      // Where walls remember more than pairs the GPU has longer histories, which begin in the same way.
      std::copy_n(contacts[k].history, dnum, own);
      if (!contacts[k].turned) continue;
      std::vector<double> source(own, own + dnum);
      pair->transfer_history(source.data(), own, 0, 0);
    }
  }
  // And ID and type of the last run.
  maxexchange = (dnum + 1) * maxpartner + 3;
  held = true;
}

void FixEllgranDeviceHistory::give_to_device()
{
  const auto &rows = grains->rows();
  auto pairs = grains->nothing_remembered();
  std::vector<double> source(dnum);
  for (int k = 0; k < rows.owned; k++) {
    if (npartner[k] == 0) continue;
    for (uint32_t e = rows.starts[k]; e < rows.starts[k + 1]; e++) {
      const int other = static_cast<int>(rows.neighbours[e]);
      if (!rows.keeps(k, other)) continue;
      const tagint *const end = partner[k] + npartner[k];
      const tagint *const found = std::find(static_cast<const tagint *>(partner[k]), end, rows.ids[other]);
      if (found == end) continue;
      const double *const own = &valuepartner[k][dnum * (found - partner[k])];
      double *const history = &pairs.histories[e * pairs.length];
      pairs.touching[e] = 1;
      if (rows.ids[k] < rows.ids[other]) {
        std::copy_n(own, dnum, history);
      } else {
        std::copy_n(own, dnum, source.begin());
        pair->transfer_history(source.data(), history, 0, 0);
      }
    }
  }
  grains->remember(pairs);
  let_go();
}

void FixEllgranDeviceHistory::let_go()
{
  std::fill_n(npartner, atom->nlocal, 0);
  held = false;
}
