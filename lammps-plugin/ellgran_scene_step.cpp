// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_scene_step.h"

#include "fix_wall_gran_ellipsoid.h"
#include "pair_gran_ellipsoid.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "force.h"

#include <mpi.h>

#include <algorithm>
#include <limits>

using namespace LAMMPS_NS;

namespace {

constexpr double NONE = std::numeric_limits<double>::infinity();

struct ValueOfRank {
  double value;
  int rank;
};

// The extreme of all ranks, and a rank that has it.
ValueOfRank of_all_ranks(double value, MPI_Op operation, int me, MPI_Comm world)
{
  ValueOfRank mine{value, me}, found{value, me};
  MPI_Allreduce(&mine, &found, 1, MPI_DOUBLE_INT, operation, world);
  return found;
}

}    // namespace

EllgranSceneStep::EllgranSceneStep(LAMMPS *lmp, const std::string &caller_name) :
    Pointers(lmp), atoms(lmp, caller_name), caller(caller_name), workspace(nullptr), step(NONE), limiting(0),
    extremes(ELLGRAN_INIT(EllgranContactExtremes)), laws(nullptr)
{
  check(ellgran_workspace_new(&workspace));
}

EllgranSceneStep::~EllgranSceneStep()
{
  ellgran_workspace_free(workspace);
}

void EllgranSceneStep::check(int32_t status) const
{
  if (status != ELLGRAN_SUCCESS) error->one(FLERR, "{}: {}", caller, ellgran_last_error());
}

void EllgranSceneStep::find()
{
  const std::size_t count = static_cast<std::size_t>(atom->nlocal) + atom->nghost;
  sums.assign(count * ELLGRAN_STEP_SUMS_LENGTH, 0.0);
  EllgranParticles particles = atoms.view();
  if (sources.pairs.empty())
    contact_masses.assign(atom->rmass, atom->rmass + count);
  else
    sources.pairs.front()->tell_contact_masses(contact_masses);
  if (count > 0) particles.contact_masses = contact_masses.data();

  extremes = ELLGRAN_INIT(EllgranContactExtremes);
  laws = nullptr;
  // Each source has a table of laws of its own.
  const auto take = [this](const EllgranContactExtremes &of_source, const EllgranLaws *laws_of_source) {
    const double deepest = std::max(extremes.deepest_overlap, of_source.deepest_overlap);
    if (of_source.shortest_collision > 0.0 &&
        (extremes.shortest_collision == 0.0 || of_source.shortest_collision < extremes.shortest_collision)) {
      extremes = of_source;
      laws = laws_of_source;
    }
    extremes.deepest_overlap = deepest;
  };
  for (auto *pair : sources.pairs) {
    EllgranContactExtremes of_pair = ELLGRAN_INIT(EllgranContactExtremes);
    pair->add_to_step_sums(workspace, particles, sums.data(), &of_pair);
    take(of_pair, pair->contact_laws());
  }
  if (force->newton_pair && !sources.pairs.empty()) sources.pairs.front()->add_step_sums_of_images(sums.data());
  for (auto *wall : sources.walls) {
    EllgranContactExtremes of_wall = ELLGRAN_INIT(EllgranContactExtremes);
    wall->add_to_step_sums(particles, sums.data(), &of_wall);
    take(of_wall, wall->contact_laws());
  }

  int64_t index = -1;
  double of_rank = NONE;
  check(ellgran_stable_step(sums.data(), atom->nlocal, &of_rank, &index));
  const ValueOfRank least = of_all_ranks(of_rank, MPI_MINLOC, comm->me, world);
  step = least.value;
  limiting = (index >= 0) ? atom->tag[index] : 0;
  MPI_Bcast(&limiting, 1, MPI_LMP_TAGINT, least.rank, world);

  const ValueOfRank deepest = of_all_ranks(extremes.deepest_overlap, MPI_MAXLOC, comm->me, world);
  const double time = (extremes.shortest_collision > 0.0) ? extremes.shortest_collision : NONE;
  const ValueOfRank shortest = of_all_ranks(time, MPI_MINLOC, comm->me, world);
  if (shortest.rank != comm->me) laws = nullptr;
  MPI_Bcast(&extremes, sizeof extremes, MPI_BYTE, shortest.rank, world);
  extremes.deepest_overlap = deepest.value;
}

double EllgranSceneStep::shortest_collision() const
{
  return (extremes.shortest_collision > 0.0) ? extremes.shortest_collision : NONE;
}

double EllgranSceneStep::step_for_error(double error_asked) const
{
  double found = NONE;
  if (laws) check(ellgran_step_for_error(laws, &extremes, error_asked, &found));
  found = std::min(found, step);
  return of_all_ranks(found, MPI_MINLOC, comm->me, world).value;
}
