// SPDX-License-Identifier: GPL-2.0-or-later

#include "compute_contact_ellipsoid_atom.h"

#include "fix_wall_gran_ellipsoid.h"
#include "pair_gran_ellipsoid.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "force.h"
#include "memory.h"
#include "update.h"

#include <algorithm>

using namespace LAMMPS_NS;

namespace {

const char SYNTAX[] = "compute ID group-ID contact/ellipsoid/atom";
constexpr int COLUMNS = ELLGRAN_GRAIN_SUMS_LENGTH;

}    // namespace

ComputeContactEllipsoidAtom::ComputeContactEllipsoidAtom(LAMMPS *lmp, int narg, char **arg) :
    Compute(lmp, narg, arg), caller(std::string("Compute contact/ellipsoid/atom ") + id), atoms(lmp, caller), nmax(0), sums(nullptr)
{
  if (narg > 3) error->all(FLERR, "{}: unexpected word '{}': the syntax is '{}'", caller, arg[3], SYNTAX);
  atoms.require_atom_style();

  peratom_flag = 1;
  size_peratom_cols = COLUMNS;
  comm_reverse = COLUMNS;
  // LAMMPS lists the steps in which it will be asked, and in these alone contacts are recorded.
  timeflag = 1;
}

ComputeContactEllipsoidAtom::~ComputeContactEllipsoidAtom()
{
  memory->destroy(sums);
}

void ComputeContactEllipsoidAtom::init()
{
  sources.find(lmp);
  if (sources.is_empty())
    error->all(FLERR, "{}: there is neither a 'pair_style gran/ellipsoid' nor a 'fix wall/gran/ellipsoid' whose contacts it could look at",
               caller);
}

void ComputeContactEllipsoidAtom::compute_peratom()
{
  invoked_peratom = update->ntimestep;
  // commands between runs may have taken some away
  sources.find(lmp);
  const auto require_record = [this](bool is_there, const std::string &whose) {
    if (!is_there)
      error->all(FLERR,
                 "{}: {} has not recorded its contacts in step {}: a fix that asks for this compute must stand behind the walls in the input; "
                 "define the compute before the run",
                 caller, whose, update->ntimestep);
  };
  for (auto *pair : sources.pairs) require_record(pair->has_contacts_of(update->ntimestep), "pair_style gran/ellipsoid");
  for (auto *wall : sources.walls) require_record(wall->has_contacts_of(update->ntimestep), std::string("fix ") + wall->id);

  if (atom->nmax > nmax) {
    nmax = atom->nmax;
    memory->destroy(sums);
    memory->create(sums, nmax, COLUMNS, "contact/ellipsoid/atom:sums");
  }
  array_atom = sums;
  const int count = atom->nlocal + atom->nghost;
  if (count > 0) std::fill_n(sums[0], static_cast<std::size_t>(count) * COLUMNS, 0.0);

  const EllgranParticles particles = atoms.view();
  // A rank without atoms has computed nothing in this step, and may hold what it had before.
  if (count > 0)
    for (auto *pair : sources.pairs) pair->add_to_grain_sums(particles, sums[0]);
  if (force->newton_pair && !sources.pairs.empty()) comm->reverse_comm(this);
  if (atom->nlocal > 0)
    for (auto *wall : sources.walls) wall->add_to_grain_sums(sums[0]);

  for (int i = 0; i < atom->nlocal; i++)
    if (!(atom->mask[i] & groupbit)) std::fill_n(sums[i], COLUMNS, 0.0);
}

int ComputeContactEllipsoidAtom::pack_reverse_comm(int n, int first, double *buffer)
{
  if (n > 0) std::copy_n(sums[first], static_cast<std::size_t>(n) * COLUMNS, buffer);
  return n * COLUMNS;
}

void ComputeContactEllipsoidAtom::unpack_reverse_comm(int n, int *indices, double *buffer)
{
  for (int k = 0; k < n; k++)
    for (int c = 0; c < COLUMNS; c++) sums[indices[k]][c] += *buffer++;
}

double ComputeContactEllipsoidAtom::memory_usage()
{
  return static_cast<double>(nmax) * COLUMNS * sizeof(double);
}
