/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * tangential tfd: partial slip, with model nfd and coefficientFriction per pair of types.
 */

#ifdef TANGENTIAL_MODEL
TANGENTIAL_MODEL(TANGENTIAL_TFD,tfd,41)
#else
#ifndef TANGENTIAL_MODEL_TFD_H_
#define TANGENTIAL_MODEL_TFD_H_

#include "atom.h"
#include "contact_models.h"
#include "ellgran_contact.h"
#include "error.h"
#include "global_properties.h"
#include "tangential_model_base.h"

namespace LIGGGHTS {
namespace ContactModels {

template<>
class TangentialModel<TANGENTIAL_TFD> : public TangentialModelBase
{
public:
  TangentialModel(LAMMPS *lmp, IContactHistorySetup *hsetup, class ContactModelBase *cmb) :
      TangentialModelBase(lmp, hsetup, cmb),
      model(cmb),
      contact(EllgranContact::take(lmp, cmb)),
      friction(NULL),
      elastic_potential(false),
      dissipated_energy(false),
      memory_offset(-1),
      memory_length(0),
      own_offset(-1)
  {
    contact->tangential_is_tfd = true;
  }

  ~TangentialModel() { EllgranContact::release(model); }

  inline void registerSettings(Settings &settings)
  {
    settings.registerOnOff("totalDisplacement", contact->displacement_is_total, false);
    settings.registerOnOff("computeElasticPotential", elastic_potential, false);
    settings.registerOnOff("computeDissipatedEnergy", dissipated_energy, false);
  }

  inline void postSettings(IContactHistorySetup *hsetup, ContactModelBase *)
  {
    // as the library has it: the memory, which is a displacement or a force, and with the latter its energy
    memory_offset = hsetup->add_history_value("ellgran_memory_x", "1");
    contact->memory_offset = memory_offset;
    hsetup->add_history_value("ellgran_memory_y", "1");
    hsetup->add_history_value("ellgran_memory_z", "1");
    memory_length = 3;
    if (!contact->displacement_is_total) {
      hsetup->add_history_value("ellgran_memory_energy", "0");
      memory_length = 4;
    }
    if (!contact->surface_is_ellipsoid) {
      // LIGGGHTS' own surface models remember neither the normal nor whether the contact is new
      own_offset = hsetup->add_history_value("ellgran_normal_x", "1");
      hsetup->add_history_value("ellgran_normal_y", "1");
      hsetup->add_history_value("ellgran_normal_z", "1");
      hsetup->add_history_value("ellgran_touched", "0");
    }
    if (elastic_potential) error->all(FLERR, "tangential tfd: computeElasticPotential is not available");
    if (dissipated_energy) error->all(FLERR, "tangential tfd: computeDissipatedEnergy is not available");
  }

  inline void connectToProperties(PropertyRegistry &registry)
  {
    if (!contact->laws) error->all(FLERR, "tangential tfd needs model nfd");
    registry.registerProperty("coeffFrict", &MODEL_PARAMS::createCoeffFrict);
    registry.connect("coeffFrict", friction, "tangential tfd");
    contact->friction = friction;
  }

  inline void surfacesIntersect(const SurfacesIntersectData &sidata, ForceData &i_forces, ForceData &j_forces)
  {
    if (sidata.contact_flags) *sidata.contact_flags |= CONTACT_TANGENTIAL_MODEL;
    // there model nfd has added this force to its own
    if (contact->surface_is_ellipsoid || !contact->geometry.touching) return;
    double *const own = &sidata.contact_history[own_offset];
    vectorCopy3D(own, contact->history.normal);
    contact->history.touched = own[3] != 0.0;
    contact->history.friction = friction[sidata.itype][sidata.jtype];
    const EllgranStep step = contact->step(sidata.computeflag && sidata.shearupdate);
    EllgranContactForce f = ELLGRAN_INIT(EllgranContactForce);
    contact->check(ellgran_staged_tangential(contact->staged, contact->laws, sidata.itype, sidata.jtype, sidata.meff, &step,
                                             &contact->history, &sidata.contact_history[memory_offset], &f));
    vectorCopy3D(contact->geometry.normal, own);
    own[3] = 1.0;
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

  inline void surfacesClose(SurfacesCloseData &scdata, ForceData &, ForceData &)
  {
    if (scdata.contact_flags) *scdata.contact_flags &= ~CONTACT_TANGENTIAL_MODEL;
    if (!scdata.contact_history) return;
    for (int k = 0; k < memory_length; k++) scdata.contact_history[memory_offset + k] = 0.0;
    if (own_offset >= 0)
      for (int k = 0; k < 4; k++) scdata.contact_history[own_offset + k] = 0.0;
  }

  inline void beginPass(SurfacesIntersectData &, ForceData &, ForceData &) {}
  inline void endPass(SurfacesIntersectData &, ForceData &, ForceData &) {}

private:
  ContactModelBase *model;
  EllgranContact *contact;
  double **friction;
  bool elastic_potential, dissipated_energy;
  int memory_offset, memory_length, own_offset;
};

}
}

#endif
#endif
