// SPDX-License-Identifier: GPL-2.0-or-later

#include "compute_timestep_ellipsoid.h"

#include "ellgran_atoms.h"

#include "error.h"
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <cstring>

using namespace LAMMPS_NS;

namespace {

const char SYNTAX[] = "compute ID all timestep/ellipsoid [energy_error e]";

constexpr double DEFAULT_ENERGY_ERROR = 1e-3;
constexpr double LEAST_ENERGY_ERROR = 1e-6, LARGEST_ENERGY_ERROR = 0.5;

}    // namespace

ComputeTimestepEllipsoid::ComputeTimestepEllipsoid(LAMMPS *lmp, int narg, char **arg) :
    Compute(lmp, narg, arg), caller(std::string("Compute timestep/ellipsoid ") + id), energy_error(DEFAULT_ENERGY_ERROR),
    scene(lmp, caller)
{
  if (igroup != 0)
    error->all(FLERR, "{}: group {} must be all: a step is that of all grains: {}", caller, arg[1], SYNTAX);
  for (int iarg = 3; iarg < narg; iarg += 2) {
    if (std::strcmp(arg[iarg], "energy_error") != 0)
      error->all(FLERR, "{}: unexpected word '{}': the syntax is '{}'", caller, arg[iarg], SYNTAX);
    if (iarg + 1 == narg) error->all(FLERR, "{}: energy_error needs a number: {}", caller, SYNTAX);
    energy_error = utils::numeric(FLERR, arg[iarg + 1], false, lmp);
    if (!(energy_error >= LEAST_ENERGY_ERROR && energy_error <= LARGEST_ENERGY_ERROR))
      error->all(FLERR, "{}: energy_error {} must be a part of the energy of a collision, from {} to {}", caller, arg[iarg + 1],
                 LEAST_ENERGY_ERROR, LARGEST_ENERGY_ERROR);
  }
  EllgranAtoms(lmp, caller).require_atom_style();

  vector_flag = 1;
  extvector = 0;
  size_vector = NUMBER_OF_VALUES;
  vector = new double[size_vector];
  std::fill_n(vector, size_vector, 0.0);
}

ComputeTimestepEllipsoid::~ComputeTimestepEllipsoid()
{
  delete[] vector;
}

void ComputeTimestepEllipsoid::init()
{
  scene.find_sources();
  if (!scene.has_sources())
    error->all(FLERR, "{}: there is neither a 'pair_style gran/ellipsoid' nor a 'fix wall/gran/ellipsoid' whose contacts it could look at",
               caller);
}

void ComputeTimestepEllipsoid::compute_vector()
{
  invoked_vector = update->ntimestep;
  // commands between runs may have taken some away
  scene.find_sources();
  scene.find();
  vector[STABLE_STEP] = scene.stable_step();
  vector[SHORTEST_COLLISION] = scene.shortest_collision();
  vector[STEP_FOR_ERROR] = scene.step_for_error(energy_error);
  vector[DEEPEST_OVERLAP] = scene.deepest_overlap();
  vector[LIMITING_ATOM] = static_cast<double>(scene.limiting_particle());
}
