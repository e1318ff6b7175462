/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_check_timestep_ellipsoid.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "atom.h"
#include "comm.h"
#include "ellgran_contact.h"
#include "error.h"
#include "fix_wall_gran_ellipsoid.h"
#include "force.h"
#include "modify.h"
#include "neigh_list.h"
#include "pair_gran.h"
#include "update.h"

using namespace LAMMPS_NS;
using namespace FixConst;
using LIGGGHTS::ContactModels::EllgranContact;

namespace {

const char SYNTAX[] =
    "fix ID all check/timestep/ellipsoid nevery fraction [energy_error e] [warn yes|no] [error yes|no]";

struct ValueOfRank {
  double value;
  int rank;
};

// the extreme of all ranks, and a rank that has it
ValueOfRank of_all_ranks(double value, MPI_Op operation, int me, MPI_Comm world)
{
  ValueOfRank mine = {value, me}, found = {value, me};
  MPI_Allreduce(&mine, &found, 1, MPI_DOUBLE_INT, operation, world);
  return found;
}

}

FixCheckTimestepEllipsoid::FixCheckTimestepEllipsoid(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg),
    fraction_(1.0),
    energy_error_(1e-3),
    warns_(true),
    stops_(false),
    warned_(false),
    workspace_(NULL),
    pair_(NULL)
{
  std::fill_n(values_, static_cast<int>(NUMBER_OF_VALUES), 0.0);
  char message[400];
  if (narg < 5) {
    snprintf(message, sizeof(message), "needs a number of steps and a fraction: %s", SYNTAX);
    error->fix_error(FLERR, this, message);
  }
  if (igroup != 0) {
    snprintf(message, sizeof(message), "group must be all, a step is that of all grains: %s", SYNTAX);
    error->fix_error(FLERR, this, message);
  }
  nevery = static_cast<int>(number("nevery", arg[3], 1, 2e9));
  fraction_ = number("fraction", arg[4], 1e-6, 100);
  for (int iarg = 5; iarg < narg; iarg += 2) {
    const bool known = !strcmp(arg[iarg], "energy_error") || !strcmp(arg[iarg], "warn") || !strcmp(arg[iarg], "error");
    if (!known || iarg + 1 == narg) {
      snprintf(message, sizeof(message), "%s '%s': %s", known ? "a word is missing after" : "unknown word", arg[iarg], SYNTAX);
      error->fix_error(FLERR, this, message);
    }
    if (!strcmp(arg[iarg], "energy_error"))
      energy_error_ = number("energy_error", arg[iarg + 1], 1e-6, 0.5);
    else if (!strcmp(arg[iarg], "warn"))
      warns_ = yes_or_no("warn", arg[iarg + 1]);
    else
      stops_ = yes_or_no("error", arg[iarg + 1]);
  }
  if (!atom->superquadric_flag) error->fix_error(FLERR, this, "needs atom_style superquadric");

  vector_flag = 1;
  size_vector = NUMBER_OF_VALUES;
  global_freq = nevery;
  extvector = 0;
  check(ellgran_workspace_new(&workspace_));
}

FixCheckTimestepEllipsoid::~FixCheckTimestepEllipsoid()
{
  ellgran_workspace_free(workspace_);
}

void FixCheckTimestepEllipsoid::check(int32_t status) const
{
  if (status == ELLGRAN_SUCCESS) return;
  char message[1200];
  snprintf(message, sizeof(message), "fix %s %s: %s", id, style, ellgran_last_error());
  error->one(FLERR, message);
}

bool FixCheckTimestepEllipsoid::yes_or_no(const char *keyword, const char *word)
{
  if (!strcmp(word, "yes")) return true;
  if (!strcmp(word, "no")) return false;
  char message[300];
  snprintf(message, sizeof(message), "%s '%s' must be yes or no", keyword, word);
  error->fix_error(FLERR, this, message);
  return false;
}

double FixCheckTimestepEllipsoid::number(const char *keyword, const char *word, double least, double most)
{
  char *end = NULL;
  const double value = strtod(word, &end);
  if (end != word && *end == '\0' && value >= least && value <= most) return value;
  char message[300];
  snprintf(message, sizeof(message), "%s '%s' must be a number from %g to %g", keyword, word, least, most);
  error->fix_error(FLERR, this, message);
  return least;
}

int FixCheckTimestepEllipsoid::setmask()
{
  return END_OF_STEP;
}

EllgranContact *FixCheckTimestepEllipsoid::model_of_pairs() const
{
  return EllgranContact::of(pair_);
}

void FixCheckTimestepEllipsoid::init()
{
  pair_ = static_cast<PairGran *>(force->pair_match("gran", 1));
  const EllgranContact *const model = pair_ ? model_of_pairs() : NULL;
  if (!model || !model->surface_is_ellipsoid || !model->laws)
    error->fix_error(FLERR, this,
                     "needs 'pair_style gran model nfd ... surface ellipsoid', whose contacts it looks at; fix check/timestep/gran "
                     "is for other models, and takes grains for spheres");
  if (!model->tangential_is_tfd && !model->matches("tangential", "off"))
    error->fix_error(FLERR, this, "needs 'tangential tfd' or 'tangential off': the springs of other tangential models are not known");
  walls_.clear();
  for (int k = 0; k < modify->nfix; k++)
    if (FixWallGranEllipsoid *const wall = dynamic_cast<FixWallGranEllipsoid *>(modify->fix[k])) {
      if (!wall->has_laws())
        error->fix_error(FLERR, this, "needs 'model nfd' in every fix wall/gran/ellipsoid, to know the stiffness of its contacts");
      walls_.push_back(wall);
    }
}

// With a step that is far too long there is nothing left to look at after the first one.
void FixCheckTimestepEllipsoid::setup(int)
{
  end_of_step();
}

void FixCheckTimestepEllipsoid::end_of_step()
{
  find();
  const double allowed = fraction_ * values_[STABLE_STEP];
  if (update->dt <= allowed || (!stops_ && (!warns_ || warned_))) return;
  warned_ = true;
  char message[500];
  snprintf(message, sizeof(message),
           "the time step %g is longer than %g, %g times the largest with which the contacts that exist now are stable (particle %d "
           "limits it): reduce the time step to that or less",
           update->dt, allowed, fraction_, static_cast<int>(values_[LIMITING_PARTICLE]));
  if (stops_) error->fix_error(FLERR, this, message);
  char whole[700];
  snprintf(whole, sizeof(whole), "Fix %s (%s): %s. This is said once.", id, style, message);
  if (comm->me == 0) error->warning(FLERR, whole);
}

// All ranks. Newton's third law is off for pairs with a history, so that each rank sees all contacts of its own particles.
void FixCheckTimestepEllipsoid::find()
{
  EllgranContact *const model = model_of_pairs();
  const int nlocal = atom->nlocal, count = nlocal + atom->nghost;
  EllgranParticles particles = model->particles();
  sums_.assign(static_cast<size_t>(std::max(count, 1)) * ELLGRAN_STEP_SUMS_LENGTH, 0.0);
  contact_masses_.resize(std::max(count, 1));
  for (int i = 0; i < count; i++)
    contact_masses_[i] = (atom->mask[i] & pair_->freeze_group_bit()) ? HUGE_VAL : atom->rmass[i];
  particles.masses = atom->rmass;
  particles.contact_masses = &contact_masses_[0];

  EllgranContactExtremes extremes = ELLGRAN_INIT(EllgranContactExtremes);
  const EllgranLaws *laws = model->laws_with_friction();
  if (count > 0) {
    const NeighList *const list = pair_->list;
    EllgranNeighbourList neighbours = ELLGRAN_INIT(EllgranNeighbourList);
    neighbours.count = list->inum;
    neighbours.central = list->ilist;
    neighbours.neighbour_counts = list->numneigh;
    neighbours.neighbours = list->firstneigh;
    neighbours.index_mask = NEIGHMASK;
    check(ellgran_add_pairs_to_step_sums(laws, workspace_, &particles, &neighbours, &sums_[0], &extremes));
  }
  for (size_t k = 0; k < walls_.size(); k++) {
    EllgranContactExtremes of_wall = ELLGRAN_INIT(EllgranContactExtremes);
    if (count > 0) walls_[k]->add_to_step_sums(particles, &sums_[0], &of_wall);
    const double deepest = std::max(extremes.deepest_overlap, of_wall.deepest_overlap);
    if (of_wall.shortest_collision > 0.0 &&
        (extremes.shortest_collision == 0.0 || of_wall.shortest_collision < extremes.shortest_collision)) {
      extremes = of_wall;
      laws = walls_[k]->laws_with_friction();
    }
    extremes.deepest_overlap = deepest;
  }

  double step = HUGE_VAL;
  int64_t index = -1;
  check(ellgran_stable_step(&sums_[0], nlocal, &step, &index));
  const ValueOfRank least = of_all_ranks(step, MPI_MINLOC, comm->me, world);
  int limiting = (index >= 0) ? atom->tag[index] : 0;
  MPI_Bcast(&limiting, 1, MPI_INT, least.rank, world);
  values_[STABLE_STEP] = least.value;
  values_[LIMITING_PARTICLE] = limiting;

  const double time = (extremes.shortest_collision > 0.0) ? extremes.shortest_collision : HUGE_VAL;
  const ValueOfRank shortest = of_all_ranks(time, MPI_MINLOC, comm->me, world);
  values_[SHORTEST_COLLISION] = shortest.value;
  double for_error = least.value;
  if (shortest.rank == comm->me) {
    double found = HUGE_VAL;
    check(ellgran_step_for_error(laws, &extremes, energy_error_, &found));
    for_error = std::min(for_error, found);
  }
  values_[STEP_FOR_ERROR] = of_all_ranks(for_error, MPI_MINLOC, comm->me, world).value;
  values_[DEEPEST_OVERLAP] = of_all_ranks(extremes.deepest_overlap, MPI_MAXLOC, comm->me, world).value;
}

double FixCheckTimestepEllipsoid::compute_vector(int n)
{
  return values_[n];
}

double FixCheckTimestepEllipsoid::memory_usage()
{
  return static_cast<double>(sums_.capacity() + contact_masses_.capacity()) * sizeof(double) + ellgran_workspace_bytes(workspace_);
}
