// SPDX-License-Identifier: GPL-2.0-or-later

#include "fix_nve_ellipsoid.h"

#include "atom.h"
#include "error.h"
#include "force.h"
#include "respa.h"
#include "update.h"
#include "utils.h"

using namespace LAMMPS_NS;
using namespace FixConst;

FixNVEEllipsoid::FixNVEEllipsoid(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), atoms(lmp, "Fix nve/ellipsoid"), workspace(nullptr)
{
  if (narg > 3)
    error->all(FLERR, "Fix nve/ellipsoid: unknown word '{}': it takes none after the group", arg[3]);
  dynamic_group_allow = 1;
  time_integrate = 1;
  atoms.require_atom_style();
  if (ellgran_workspace_new(&workspace) != ELLGRAN_SUCCESS)
    error->all(FLERR, "Fix nve/ellipsoid: {}", ellgran_last_error());
}

FixNVEEllipsoid::~FixNVEEllipsoid()
{
  ellgran_workspace_free(workspace);
}

int FixNVEEllipsoid::setmask()
{
  return INITIAL_INTEGRATE | FINAL_INTEGRATE | INITIAL_INTEGRATE_RESPA | FINAL_INTEGRATE_RESPA;
}

void FixNVEEllipsoid::init()
{
  if (force->ftm2v != 1.0)
    error->all(FLERR, "Fix nve/ellipsoid: in units {} force is not mass times acceleration: use si, cgs, micro, nano or lj",
               update->unit_style);
  atoms.require_shapes(groupbit);
}

EllgranMotion FixNVEEllipsoid::motion() const
{
  const EllgranParticles particles = atoms.view();
  EllgranMotion motion = ELLGRAN_INIT(EllgranMotion);
  motion.count = (igroup == atom->firstgroup) ? atom->nfirst : atom->nlocal;
  if (motion.count == 0) return motion;
  motion.positions = atom->x[0];
  motion.velocities = atom->v[0];
  motion.angular_momenta = atom->angmom[0];
  motion.forces = atom->f[0];
  motion.torques = atom->torque[0];
  motion.masses = particles.masses;
  motion.shape_indices = particles.shape_indices;
  motion.semi_axes = particles.semi_axes;
  motion.semi_axes_stride = particles.semi_axes_stride;
  // The atoms are this fix' to move.
  motion.quaternions = const_cast<double *>(particles.quaternions);
  motion.quaternions_stride = particles.quaternions_stride;
  motion.masks = atom->mask;
  motion.group_mask = groupbit;
  motion.identifiers = particles.identifiers;
  motion.identifier_bytes = particles.identifier_bytes;
  return motion;
}

void FixNVEEllipsoid::start(double time_step)
{
  const EllgranMotion grains = motion();
  if (ellgran_start_step(workspace, &grains, time_step) != ELLGRAN_SUCCESS)
    error->one(FLERR, "Fix nve/ellipsoid: {}", ellgran_last_error());
}

void FixNVEEllipsoid::finish(double time_step)
{
  const EllgranMotion grains = motion();
  if (ellgran_finish_step(&grains, time_step) != ELLGRAN_SUCCESS)
    error->one(FLERR, "Fix nve/ellipsoid: {}", ellgran_last_error());
}

void FixNVEEllipsoid::initial_integrate(int)
{
  start(update->dt);
}

void FixNVEEllipsoid::final_integrate()
{
  finish(update->dt);
}

double FixNVEEllipsoid::step_of_level(int level) const
{
  return static_cast<Respa *>(update->integrate)->step[level];
}

void FixNVEEllipsoid::initial_integrate_respa(int, int level, int)
{
  // The innermost level moves the grains, the others kick.
  if (level == 0)
    start(step_of_level(level));
  else
    finish(step_of_level(level));
}

void FixNVEEllipsoid::final_integrate_respa(int level, int)
{
  finish(step_of_level(level));
}
