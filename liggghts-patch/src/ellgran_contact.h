/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * What the surface, normal and tangential model of one contact model share: the contact between its stages, and the laws.
 * LIGGGHTS' own structure for a contact has no room for the geometry of an ellipse.
 */

#ifndef ELLGRAN_CONTACT_H
#define ELLGRAN_CONTACT_H

#include <string>
#include <vector>

#include "ellgran.h"
#include "contact_interface.h"
#include "ellgran_local_output.h"
#include "lammps.h"

class PropertyRegistry;
namespace LAMMPS_NS {
class NeighList;
class PairGran;
}

namespace LIGGGHTS {
class IContactHistorySetup;
namespace ContactModels {

class ContactModelBase;

struct EllgranContact {
  // one per contact model; released by every model that took it
  static EllgranContact *take(LAMMPS_NS::LAMMPS *lmp, ContactModelBase *model);
  static void release(ContactModelBase *model);
  // that of the pair style or wall which keeps this contact history; NULL if it has no model of ours
  static EllgranContact *of(const IContactHistorySetup *owner);
  // whether any contact model has tangential tfd
  static bool any_has_friction();
  // brings LIGGGHTS' own histories of pairs up to date
  static void write_kept_histories(LAMMPS_NS::LAMMPS *lmp);
  // the workspace with what was prepared of particles for the pairs of this step, all at once; NULL if they were not
  static const EllgranWorkspace *prepared_for_pairs(LAMMPS_NS::LAMMPS *lmp);
  // LIGGGHTS finds what a contact remembers by the ID of the other particle: stops where two particles touch in two places across a
  // short periodic box, or one touches itself. The histories of pairs are up to date.
  static void refuse_second_contacts(LAMMPS_NS::LAMMPS *lmp);

  IContactHistorySetup *owner;
  EllgranStagedContact *staged;
  EllgranStagedGeometry geometry;
  EllgranLaws *laws;
  int types;

  bool is_wall;
  bool surface_is_ellipsoid;     // else the normal model stages spheres
  bool needs_equivalent_radius;  // a normal model of LIGGGHTS' own, or rolling friction, reads sidata.reff
  bool tangential_is_tfd;        // else a tangential model of LIGGGHTS' own may read sidata.kt
  bool displacement_is_total;    // setting totalDisplacement of tangential tfd
  double **friction;             // coefficients per pair of types, of tangential tfd

  // of the contact at hand, set by whoever stages it
  EllgranStagedHistory history;
  int memory_offset;             // of the tangential displacement in the history, of tangential tfd

  // body of a particle of atom style superquadric, checked; of a sphere
  EllgranBody ellipsoid(int i) const;
  EllgranBody sphere(int i, double radius) const;
  // stages two spheres, or a sphere and a plane, of LIGGGHTS' own surface model
  void stage_spheres(const SurfacesIntersectData &sidata);
  // the share of i in the penetration, from the moduli
  double share(int itype, int jtype) const { return shares[itype * (types + 1) + jtype]; }
  void connect_moduli(PropertyRegistry &registry, const char *caller);
  // stops with the library's message unless status is ELLGRAN_SUCCESS
  void check(int32_t status) const;
  void check_particles() const;
  // whether this is the pair style's or wall's model of a kind: normal, tangential, cohesion, rolling_friction, surface
  bool matches(const char *kind, const char *name) const;
  // whether the laws are all that acts at a contact: model nfd, tangential tfd or none, neither cohesion nor rolling friction
  bool has_own_models_alone() const;
  // what the contacts of a wall remember, in the order in which they do, in words that mean the same in all versions of restart files
  std::string remembered() const;
  // stops if another model of the same contact model would be wrong about this one without saying so
  void check_models() const;
  // all particles of the step, for the contacts that are staged by their indices
  void prepare_particles();
  EllgranStep step(int advance_history) const;
  // A law of E, nu, eta1, eta2 per type; or, with restitution (per pair of types, from 1) in place of viscosities, elastic with
  // the damping that gives it.
  void build_laws(const double *shear, const double *bulk, double *const *restitution, bool conservative, bool ting,
                  bool limit_force);

  // Forces of all pairs of the neighbour list by one call of the library. False, and nothing done, when something needs
  // the contacts one by one.
  bool compute_list(LAMMPS_NS::PairGran *pair, int eflag, int vflag, int addflag);

  // For compute pair/gran/local, whose pass over the pairs computes forces and applies none: where in the history LIGGGHTS
  // reads the contact point and the penetration; a contact of that pass; and the rows, when all contacts are there.
  void connect_local_output();
  void report(SurfacesIntersectData &sidata, const ForceData &forces_i);
  void begin_reports() { reports.clear(); }
  // A mesh takes the force at the point at -delta from the particle's centre. Moves that point to the line on which the force gives the
  // particle its torque, or the torques of mesh and particle are not opposite: the nearest one to where it was.
  static void balance_torque_of_mesh(SurfacesIntersectData &sidata, const ForceData &forces_i);
  void write_reports();
  // of the contact at hand, but for its forces
  EllgranContactReport geometry_report() const;

  // all particles as the library reads them, checked, with the velocities that forces see
  EllgranParticles particles() const;
  // the laws with the coefficients of friction of tangential tfd; NULL without model nfd
  const EllgranLaws *laws_with_friction();

private:
  EllgranContact(LAMMPS_NS::LAMMPS *lmp, ContactModelBase *model);
  ~EllgranContact();
  EllgranContact(const EllgranContact &);
  EllgranContact &operator=(const EllgranContact &);

  // whether a model remembers of a contact what is wrong of another one
  bool tells_contacts_apart() const;
  void refuse_second_contacts(const LAMMPS_NS::NeighList *list, int *const *touching) const;
  void build_list_laws();
  bool takes_list(LAMMPS_NS::PairGran *pair, int vflag, int addflag) const;
  EllgranNeighbourList neighbour_list(LAMMPS_NS::PairGran *pair) const;
  void warn_of_created_energy();

  LAMMPS_NS::LAMMPS *lmp;
  ContactModelBase *model;
  int users;
  double *youngs_modulus, *poissons_ratio;
  std::vector<double> shares;
  EllgranLaws *list_laws;  // with the coefficients of friction; NULL until they are needed
  EllgranWorkspace *workspace;
  LAMMPS_NS::PairGran *keeps_histories_of;  // in the workspace, where they are newer than in LIGGGHTS' list; else NULL
  std::vector<EllgranContactReport> reports;
  std::vector<double> told_history;  // of a contact, as compute pair/gran/local reads it
  bool warned_of_created_energy;
  std::vector<double> contact_masses;  // of all particles, infinite for those of fix freeze
  int64_t step_prepared;           // in which all pairs were last taken at once in a run; -1 if they were not
  int64_t lists_before;            // neighbour lists built when all pairs were last taken at once; -1 if they were not
};

}
}

#endif
