/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_nve_ellipsoid.h"

#include <cstdio>

#include "atom.h"
#include "ellgran_shape.h"
#include "error.h"
#include "force.h"
#include "modify.h"
#include "update.h"

using namespace LAMMPS_NS;
using namespace FixConst;

FixNVEEllipsoid::FixNVEEllipsoid(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg), workspace_(NULL)
{
  if (narg > 3) {
    char message[300];
    snprintf(message, sizeof(message), "unknown word '%s': it takes none after the group", arg[3]);
    error->fix_error(FLERR, this, message);
  }
  if (!atom->superquadric_flag) error->fix_error(FLERR, this, "needs atom_style superquadric");
  time_integrate = 1;
  check(ellgran_workspace_new(&workspace_));
}

FixNVEEllipsoid::~FixNVEEllipsoid()
{
  ellgran_workspace_free(workspace_);
}

int FixNVEEllipsoid::setmask()
{
  return INITIAL_INTEGRATE | FINAL_INTEGRATE;
}

void FixNVEEllipsoid::init()
{
  if (force->ftm2v != 1.0)
    error->fix_error(FLERR, this, "in these units force is not mass times acceleration: use units si, cgs, micro or lj");
  // its implicit drag is a part of LIGGGHTS' own integrators
  if (modify->n_fixes_style("couple/cfd/force/implicit") > 0)
    error->fix_error(FLERR, this, "does not go with fix couple/cfd/force/implicit: use nve/superquadric");
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->mask[i] & groupbit) ellgran_check_blockiness(lmp, style, i);
}

EllgranMotion FixNVEEllipsoid::motion() const
{
  EllgranMotion motion = ELLGRAN_INIT(EllgranMotion);
  motion.count = igroup == atom->firstgroup ? atom->nfirst : atom->nlocal;
  if (motion.count == 0) return motion;
  motion.positions = atom->x[0];
  motion.velocities = atom->v[0];
  motion.angular_momenta = atom->angmom[0];
  motion.forces = atom->f[0];
  motion.torques = atom->torque[0];
  motion.masses = atom->rmass;
  motion.semi_axes = atom->shape[0];
  motion.semi_axes_stride = 3 * sizeof(double);
  motion.quaternions = atom->quaternion[0];
  motion.quaternions_stride = 4 * sizeof(double);
  motion.masks = atom->mask;
  motion.group_mask = groupbit;
  motion.identifiers = atom->tag;
  motion.identifier_bytes = sizeof(atom->tag[0]);
  return motion;
}

void FixNVEEllipsoid::check(int status) const
{
  if (status == ELLGRAN_SUCCESS) return;
  char message[600];
  snprintf(message, sizeof(message), "fix %s nve/ellipsoid: %s", id, ellgran_last_error());
  error->one(FLERR, message);
}

// LIGGGHTS keeps angular velocities beside angular momenta: contact models and outputs read them.
void FixNVEEllipsoid::initial_integrate(int)
{
  const EllgranMotion grains = motion();
  if (grains.count == 0) return;
  check(ellgran_start_step(workspace_, &grains, update->dt));
  check(ellgran_angular_velocities(&grains, atom->omega[0]));
}

void FixNVEEllipsoid::final_integrate()
{
  const EllgranMotion grains = motion();
  if (grains.count == 0) return;
  check(ellgran_finish_step(&grains, update->dt));
  check(ellgran_angular_velocities(&grains, atom->omega[0]));
}
