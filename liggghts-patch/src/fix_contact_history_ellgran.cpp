/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_contact_history_ellgran.h"

#include <algorithm>
#include <cstring>

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "ellgran_contact.h"
#include "error.h"
#include "fix_ellgran_restart_format.h"
#include "math_extra_liggghts_nonspherical.h"
#include "modify.h"
#include "neighbor.h"
#include "update.h"
#include "vector_liggghts.h"

using namespace LAMMPS_NS;
using LIGGGHTS::ContactModels::EllgranContact;

namespace {

const char ID[] = "ellgran_contact_history";

// type, groups, mass, bounding radius, semi-axes
const int VALUES_OF_IMAGE = 7;

// What reads the histories of pairs in the middle of a run. (Of the computes contact/atom/gran does, which refuses ellipsoids.)
const char *const FIXES[] = {"heat/gran", "heat/gran/conduction", "multicontact/halfspace", "deform/check"};

}

FixContactHistoryEllgran::FixContactHistoryEllgran(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), has_run_(false), changed_("fixes")
{
  comm_forward = VALUES_OF_IMAGE;
}

int FixContactHistoryEllgran::setmask()
{
  return FixConst::PRE_EXCHANGE | FixConst::PRE_FORCE;
}

void FixContactHistoryEllgran::init()
{
  // Later, and after a restart, momenta are those that particles had: velocities alone may be out of date.
  if (update->whichflag != 1 || has_run_ || FixEllgranRestartFormat::has_read(lmp)) return;
  int torn = 0;
  for (int i = 0; i < atom->nlocal; i++) {
    const double *const omega = atom->omega[i];
    double *const momentum = atom->angmom[i];
    if (vectorMag3DSquared(omega) == 0.0) continue;
    double expected[3], apart[3];
    MathExtraLiggghtsNonspherical::omega_to_angmom(atom->quaternion[i], omega, atom->inertia[i], expected);
    vectorSubtract3D(expected, momentum, apart);
    if (vectorMag3DSquared(momentum) == 0.0)
      vectorCopy3D(expected, momentum);
    else if (vectorMag3D(apart) > 1e-6 * vectorMag3D(momentum))
      torn = std::max(torn, atom->tag[i]);
  }
  int particle = 0;
  MPI_Allreduce(&torn, &particle, 1, MPI_INT, MPI_MAX, world);
  if (particle == 0 || comm->me != 0) return;
  char message[300];
  snprintf(message, sizeof(message),
           "surface ellipsoid: particle %d: its angular velocity does not belong to its angular momentum, with which it begins: set omegax, "
           "omegay and omegaz after shape, density and orientation",
           particle);
  error->warning(FLERR, message);
}

void FixContactHistoryEllgran::post_run()
{
  has_run_ = true;
  write();
}

void FixContactHistoryEllgran::pre_force(int)
{
  if (update->ntimestep == update->firststep + 1 && neighbor->ago > 0) comm->forward_comm_fix(this);
}

int FixContactHistoryEllgran::pack_comm(int count, int *particles, double *buffer, int, int *)
{
  for (int k = 0; k < count; k++) {
    const int i = particles[k];
    *buffer++ = atom->type[i];
    *buffer++ = atom->mask[i];
    *buffer++ = atom->rmass[i];
    *buffer++ = atom->radius[i];
    buffer = std::copy(atom->shape[i], atom->shape[i] + 3, buffer);
  }
  return VALUES_OF_IMAGE;
}

void FixContactHistoryEllgran::unpack_comm(int count, int first, double *buffer)
{
  for (int i = first; i < first + count; i++) {
    atom->type[i] = static_cast<int>(*buffer++);
    atom->mask[i] = static_cast<int>(*buffer++);
    atom->rmass[i] = *buffer++;
    atom->radius[i] = *buffer++;
    std::copy(buffer, buffer + 3, atom->shape[i]);
    buffer += 3;
  }
}

void FixContactHistoryEllgran::add(LAMMPS *lmp)
{
  if (!lmp->domain->box_exist || lmp->modify->find_fix(ID) >= 0) return;
  char id[] = "ellgran_contact_history", group[] = "all", style[] = "contacthistory/ellgran";
  char *words[] = {id, group, style};
  lmp->modify->add_fix(3, words);
}

FixContactHistoryEllgran *FixContactHistoryEllgran::find(LAMMPS *lmp)
{
  const int place = lmp->modify->find_fix(ID);
  return place >= 0 ? static_cast<FixContactHistoryEllgran *>(lmp->modify->fix[place]) : NULL;
}

bool FixContactHistoryEllgran::may_keep(LAMMPS *lmp)
{
  Modify *const modify = lmp->modify;
  const int ours = modify->find_fix(ID);
  if (ours < 0 || ours > modify->find_fix("contacthistory")) return false;
  for (int k = 0; k < modify->nfix; k++)
    for (size_t r = 0; r < sizeof(FIXES) / sizeof(FIXES[0]); r++)
      if (strcmp(modify->fix[k]->style, FIXES[r]) == 0) return false;
  return true;
}

void FixContactHistoryEllgran::write()
{
  EllgranContact::write_kept_histories(lmp);
  EllgranContact::refuse_second_contacts(lmp);
}
