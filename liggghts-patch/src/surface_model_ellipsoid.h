/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * surface ellipsoid: the geometry of a contact of ellipsoids, by the library. Atom style superquadric, blockiness 2 2.
 */

#ifdef SURFACE_MODEL
SURFACE_MODEL(SURFACE_ELLIPSOID,ellipsoid,41)
#else
#ifndef SURFACE_MODEL_ELLIPSOID_H_
#define SURFACE_MODEL_ELLIPSOID_H_

#include "surface_model_base.h"

#ifdef SUPERQUADRIC_ACTIVE_FLAG

#include <cstring>
#include "atom.h"
#include "comm.h"
#include "contact_models.h"
#include "ellgran_commands.h"
#include "ellgran_contact.h"
#include "error.h"
#include "fix_contact_history_ellgran.h"
#include "fix_wall_gran.h"
#include "math_extra_liggghts_nonspherical.h"
#include "neighbor.h"

namespace LIGGGHTS {
namespace ContactModels {

template<>
class SurfaceModel<SURFACE_ELLIPSOID> : public SurfaceModelBase
{
public:
  SurfaceModel(LAMMPS *lmp, IContactHistorySetup *hsetup, class ContactModelBase *cmb) :
      SurfaceModelBase(lmp, hsetup, cmb),
      model(cmb),
      contact(EllgranContact::take(lmp, cmb)),
      normal_offset(-1)
  {
    contact->owner = hsetup;
    if (!atom->superquadric_flag)
      error->all(FLERR, "surface ellipsoid needs atom_style superquadric (with blockiness 2 2)");
    if (cmb->is_wall()) {
      // fix wall/gran pushes once per triangle, misses contacts in a cylinder, and passes over particles of a plane
      const FixWallGran *wall = dynamic_cast<FixWallGran *>(hsetup);
      if (!wall || strcmp(wall->style, "wall/gran/ellipsoid") != 0)
        error->all(FLERR, "surface ellipsoid needs fix wall/gran/ellipsoid, which takes the same words as fix wall/gran");
    } else {
      normal_offset = hsetup->add_history_value("ellgran_normal_x", "1");
      hsetup->add_history_value("ellgran_normal_y", "1");
      hsetup->add_history_value("ellgran_normal_z", "1");
      FixContactHistoryEllgran::add(lmp);
    }
    contact->surface_is_ellipsoid = true;
  }

  ~SurfaceModel() { EllgranContact::release(model); }

  inline void registerSettings(Settings &) {}
  inline void postSettings(IContactHistorySetup *, ContactModelBase *) {}

  inline void connectToProperties(PropertyRegistry &registry)
  {
    contact->connect_moduli(registry, "surface ellipsoid");
    contact->check_models();
    ellgran_check_commands(lmp);
    contact->check_particles();
    contact->connect_local_output();
    // so that surfacesClose follows the end of every contact, also where bounding spheres touch as the bodies do
    neighbor->register_contact_dist_factor(1.01);
  }

  // of pairs: fix wall/gran/ellipsoid stages the contacts with walls itself
  inline bool checkSurfaceIntersect(SurfacesIntersectData &sidata)
  {
    sidata.is_non_spherical = true;
    double *const normal = &sidata.contact_history[normal_offset];
    vectorCopy3D(normal, contact->history.normal);
    contact->history.touched = *sidata.contact_flags & CONTACT_NORMAL_MODEL;
    contact->check(ellgran_staged_neighbours(contact->staged, sidata.i, sidata.j,
                                             contact->share(sidata.itype, sidata.jtype), normal, &contact->geometry));
    if (!contact->geometry.touching) {
      *sidata.contact_flags &= ~(CONTACT_SURFACE_MODEL | CONTACT_NORMAL_MODEL | CONTACT_TANGENTIAL_MODEL);
      return false;
    }
    *sidata.contact_flags |= CONTACT_SURFACE_MODEL;
    return true;
  }

  inline void surfacesIntersect(SurfacesIntersectData &sidata, ForceData &, ForceData &)
  {
    const EllgranStagedGeometry &g = contact->geometry;
    // LIGGGHTS' normal points to i
    for (int k = 0; k < 3; k++) {
      sidata.en[k] = -g.normal[k];
      sidata.contact_point[k] = g.contact_point[k];
    }
    sidata.deltan = g.penetration;
    if (contact->needs_equivalent_radius)
      contact->check(ellgran_staged_equivalent_radius(contact->staged, &sidata.reff));
    sidata.P_diss = 0.0;
    MathExtraLiggghtsNonspherical::surfacesIntersectNonSpherical(sidata, atom->x);
  }

  inline void surfacesClose(SurfacesCloseData &scdata, ForceData &, ForceData &)
  {
    if (scdata.contact_flags) *scdata.contact_flags &= ~CONTACT_SURFACE_MODEL;
  }

  inline void endSurfacesIntersect(SurfacesIntersectData &sidata, TriMesh *mesh, double *const force_i)
  {
    // the force is the first of ForceData, which LIGGGHTS hands over no other way
    const ForceData &forces_i = *reinterpret_cast<const ForceData *>(force_i);
    if (!sidata.is_wall && !sidata.computeflag) contact->report(sidata, forces_i);
    if (mesh && sidata.computeflag) contact->balance_torque_of_mesh(sidata, forces_i);
  }
  void beginPass(SurfacesIntersectData &, ForceData &, ForceData &)
  {
    contact->prepare_particles();
    contact->begin_reports();
  }
  void endPass(SurfacesIntersectData &sidata, ForceData &, ForceData &)
  {
    if (!sidata.computeflag) contact->write_reports();
  }
  inline void tally_pp(double, int, int, int) {}
  inline void tally_pw(double, int, int, int) {}

private:
  ContactModelBase *model;
  EllgranContact *contact;
  int normal_offset;
};

}
}

#else

SURFACE_MODEL_DUMMY(SURFACE_ELLIPSOID, "surface ellipsoid needs a build with superquadrics (SUPERQUADRIC_ACTIVE_FLAG)")

#endif

#endif
#endif
