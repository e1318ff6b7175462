/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * The loop over pairs for model nfd with surface ellipsoid, and tangential tfd or none: the library takes the whole neighbour
 * list in one call. Where something needs the contacts one by one, LIGGGHTS' own loop runs instead, with the same result.
 */

#ifndef ELLGRAN_PAIRS_H
#define ELLGRAN_PAIRS_H

#include "contact_model_constants.h"
#include "ellgran_contact.h"

namespace LIGGGHTS {
namespace ContactModels {

template<int M, int T, int C, int R, int S>
struct GranStyle;
template<typename Style>
class ContactModel;

// The same contact model by another name, for which LIGGGHTS' own loop is not replaced.
template<typename Model>
class OneByOne : public Model
{
public:
  OneByOne(LAMMPS_NS::LAMMPS *lmp, IContactHistorySetup *hsetup, bool is_wall, const int64_t hash) :
      Model(lmp, hsetup, is_wall, hash)
  {}
};

}

namespace PairStyles {

template<typename Model>
class Granular;

template<int T>
class Granular<ContactModels::ContactModel<ContactModels::GranStyle<
    ContactModels::NFD, T, ContactModels::COHESION_OFF, ContactModels::ROLLING_OFF, ContactModels::SURFACE_ELLIPSOID> > > :
    public Granular<ContactModels::OneByOne<ContactModels::ContactModel<ContactModels::GranStyle<
        ContactModels::NFD, T, ContactModels::COHESION_OFF, ContactModels::ROLLING_OFF, ContactModels::SURFACE_ELLIPSOID> > > >
{
  typedef Granular<ContactModels::OneByOne<ContactModels::ContactModel<ContactModels::GranStyle<
      ContactModels::NFD, T, ContactModels::COHESION_OFF, ContactModels::ROLLING_OFF, ContactModels::SURFACE_ELLIPSOID> > > >
      Base;

public:
  Granular(LAMMPS_NS::LAMMPS *lmp, LAMMPS_NS::PairGran *parent, const int64_t hash) :
      Base(lmp, parent, hash),
      contact(ContactModels::EllgranContact::of(parent))
  {}

  virtual void compute_force(LAMMPS_NS::PairGran *pair, int eflag, int vflag, int addflag)
  {
    const bool ours = T == ContactModels::TANGENTIAL_TFD || T == ContactModels::TANGENTIAL_OFF;
    if (!ours || !contact->compute_list(pair, eflag, vflag, addflag)) Base::compute_force(pair, eflag, vflag, addflag);
  }

private:
  ContactModels::EllgranContact *contact;
};

}
}

#endif
