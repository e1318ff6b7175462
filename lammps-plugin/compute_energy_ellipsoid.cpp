// SPDX-License-Identifier: GPL-2.0-or-later

#include "compute_energy_ellipsoid.h"

#include "ellgran_atoms.h"
#include "ellgran_energy_balance.h"

#include "error.h"
#include "modify.h"
#include "update.h"

#include <algorithm>

using namespace LAMMPS_NS;

namespace {

const char CALLER[] = "Compute energy/ellipsoid";
const char SYNTAX[] = "compute ID all energy/ellipsoid";

}    // namespace

ComputeEnergyEllipsoid::ComputeEnergyEllipsoid(LAMMPS *lmp, int narg, char **arg) : Compute(lmp, narg, arg), balance(nullptr)
{
  if (narg > 3) error->all(FLERR, "{} {}: unexpected word '{}': the syntax is '{}'", CALLER, id, arg[3], SYNTAX);
  if (igroup != 0)
    error->all(FLERR, "{} {}: group {} must be all: the work of other grains on those of a group is not known: {}", CALLER, id, arg[1],
               SYNTAX);
  EllgranAtoms(lmp, std::string(CALLER) + " " + id).require_atom_style();

  vector_flag = 1;
  extvector = 1;
  size_vector = FixEllgranEnergyBalance::NUMBER_OF_COLUMNS;
  vector = new double[size_vector];
  std::fill_n(vector, size_vector, 0.0);

  id_balance = std::string(id) + "_ENERGY_BALANCE";
  balance = add_energy_balance(modify, id_balance);
}

ComputeEnergyEllipsoid::~ComputeEnergyEllipsoid()
{
  delete[] vector;
  if (modify->nfix > 0 && modify->get_fix_by_id(id_balance)) modify->delete_fix(id_balance);
}

void ComputeEnergyEllipsoid::init()
{
  if (!modify->get_fix_by_id(id_balance))
    error->all(FLERR, "{} {}: fix {}, which follows its energies, was deleted: define the compute again", CALLER, id, id_balance);
}

void ComputeEnergyEllipsoid::compute_vector()
{
  invoked_vector = update->ntimestep;
  if (!modify->get_fix_by_id(id_balance)) return init();
  balance->sum_columns(vector);
}
