/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * model nfd: viscoelastic normal force from youngsModulus, poissonsRatio, viscosityShear and viscosityBulk per type; with
 * restitutionDamping on, from coefficientRestitution per pair of types in place of the viscosities.
 * Under surface ellipsoid for the ellipse of the contact, under surface default for spheres.
 */

#ifdef NORMAL_MODEL
NORMAL_MODEL(NFD,nfd,41)
#else
#ifndef NORMAL_MODEL_NFD_H_
#define NORMAL_MODEL_NFD_H_

#include "atom.h"
#include "contact_models.h"
#include "ellgran_contact.h"
#include "ellgran_pairs.h"
#include "error.h"
#include "global_properties.h"
#include "neighbor.h"
#include "normal_model_base.h"

namespace MODEL_PARAMS {
VectorProperty *createViscosityShear(PropertyRegistry &registry, const char *caller, bool sanity_checks);
VectorProperty *createViscosityBulk(PropertyRegistry &registry, const char *caller, bool sanity_checks);
}

namespace LIGGGHTS {
namespace ContactModels {

template<>
class NormalModel<NFD> : public NormalModelBase
{
public:
  NormalModel(LAMMPS *lmp, IContactHistorySetup *hsetup, class ContactModelBase *cmb) :
      NormalModelBase(lmp, hsetup, cmb),
      model(cmb),
      contact(EllgranContact::take(lmp, cmb)),
      shear(NULL),
      bulk(NULL),
      restitution(NULL),
      rolls(false),
      conservative(true),
      ting(true),
      limit_force(true),
      damping_is_restitution(false),
      elastic_potential(false),
      dissipated_energy(false)
  {
    contact->owner = hsetup;
    contact->needs_equivalent_radius = false;
  }

  ~NormalModel() { EllgranContact::release(model); }

  void registerSettings(Settings &settings)
  {
    settings.registerOnOff("conservative", conservative, true);
    settings.registerOnOff("tingUnloading", ting, true);
    settings.registerOnOff("limitForce", limit_force, true);
    settings.registerOnOff("restitutionDamping", damping_is_restitution, false);
    settings.registerOnOff("computeElasticPotential", elastic_potential, false);
    settings.registerOnOff("computeDissipatedEnergy", dissipated_energy, false);
  }

  inline void postSettings(IContactHistorySetup *, ContactModelBase *)
  {
    if (elastic_potential) error->all(FLERR, "model nfd: computeElasticPotential is not available");
    if (dissipated_energy) error->all(FLERR, "model nfd: computeDissipatedEnergy is not available");
  }

  void connectToProperties(PropertyRegistry &registry)
  {
    contact->connect_moduli(registry, "model nfd");
    if (damping_is_restitution) {
      // the library checks the range: above 0 and at most 1
      registry.registerProperty("coeffRest", &MODEL_PARAMS::createCoeffRest, false);
      registry.connect("coeffRest", restitution, "model nfd restitutionDamping on");
    } else {
      registry.registerProperty("viscosityShear", &MODEL_PARAMS::createViscosityShear);
      registry.registerProperty("viscosityBulk", &MODEL_PARAMS::createViscosityBulk);
      registry.connect("viscosityShear", shear, "model nfd");
      registry.connect("viscosityBulk", bulk, "model nfd");
    }
    contact->check_models();
    rolls = !contact->matches("rolling_friction", "off");
    contact->needs_equivalent_radius = rolls;
    contact->build_laws(shear, bulk, restitution, conservative, ting, limit_force);
    neighbor->register_contact_dist_factor(1.01);
  }

  inline double stressStrainExponent() { return 1.5; }

  inline void surfacesIntersect(SurfacesIntersectData &sidata, ForceData &i_forces, ForceData &j_forces)
  {
    if (sidata.contact_flags) *sidata.contact_flags |= CONTACT_NORMAL_MODEL;
    if (!contact->surface_is_ellipsoid) {
      if (sidata.is_non_spherical) error->one(FLERR, "model nfd needs surface ellipsoid for these particles");
      contact->stage_spheres(sidata);
      if (!contact->geometry.touching) return;
    }
    EllgranContactForce f = ELLGRAN_INIT(EllgranContactForce);
    if (contact->tangential_is_tfd && contact->surface_is_ellipsoid) {
      // both at once: tangential tfd has nothing to add
      const EllgranStep step = contact->step(sidata.computeflag && sidata.shearupdate);
      contact->history.friction = contact->friction[sidata.itype][sidata.jtype];
      contact->check(ellgran_staged_forces(contact->staged, contact->laws, sidata.itype, sidata.jtype, sidata.meff, &step,
                                           &contact->history, &sidata.contact_history[contact->memory_offset], &f));
    } else
      contact->check(ellgran_staged_normal(contact->staged, contact->laws, sidata.itype, sidata.jtype, sidata.meff, &f));

    sidata.Fn = f.normal_force;
    sidata.kn = f.normal_force / sidata.deltan;
    sidata.kt = 0.0;
    if (rolls || !contact->tangential_is_tfd) {
      // for LIGGGHTS' own rolling and tangential models: the stiffnesses of a circular contact with the same elastic force, as
      // model hertz has them
      contact->check(ellgran_staged_circular_stiffness(contact->staged, contact->laws, sidata.itype, sidata.jtype,
                                                       &sidata.kn, &sidata.kt));
    }
    sidata.gamman = 0.0;
    sidata.gammat = 0.0;

    for (int k = 0; k < 3; k++) {
      i_forces.delta_F[k] -= f.force[k];
      i_forces.delta_torque[k] += f.torque_i[k];
    }
    if (!sidata.is_wall) {
      for (int k = 0; k < 3; k++) {
        j_forces.delta_F[k] += f.force[k];
        j_forces.delta_torque[k] += f.torque_j[k];
      }
    }
  }

  void surfacesClose(SurfacesCloseData &scdata, ForceData &, ForceData &)
  {
    if (scdata.contact_flags) *scdata.contact_flags &= ~CONTACT_NORMAL_MODEL;
  }

  void beginPass(SurfacesIntersectData &, ForceData &, ForceData &) {}
  void endPass(SurfacesIntersectData &, ForceData &, ForceData &) {}

private:
  ContactModelBase *model;
  EllgranContact *contact;
  double *shear, *bulk;
  double **restitution;
  bool rolls;  // a rolling model reads kn, and reff under surface ellipsoid
  bool conservative, ting, limit_force, damping_is_restitution, elastic_potential, dissipated_energy;
};

}
}

#endif
#endif
