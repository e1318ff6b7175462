/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * fix wall/gran/ellipsoid: fix wall/gran, with the same words, for surface ellipsoid. Every contact of a particle with the
 * wall is found by the library and acts once.
 */

#ifdef FIX_CLASS
FixStyle(wall/gran/ellipsoid,FixWallGranEllipsoid)
#else

#ifndef LMP_FIX_WALL_GRAN_ELLIPSOID_H
#define LMP_FIX_WALL_GRAN_ELLIPSOID_H

#include <string>
#include <vector>

#include "ellgran.h"
#include "fix_wall_gran.h"

namespace LAMMPS_NS {

class FixWallGranEllipsoid : public FixWallGran {
 public:
  FixWallGranEllipsoid(class LAMMPS *, int, char **);
  virtual ~FixWallGranEllipsoid();
  virtual void post_create();
  virtual void pre_delete(bool unfixflag);
  virtual void init();
  virtual void setup(int vflag);
  virtual void post_run();

 protected:
  virtual void pre_neighbor();
  virtual void post_force_primitive(int);
  virtual void post_force_mesh(int);

 private:
  // a contact of one particle: its surface, and the triangle that stands for it
  struct Contact {
    EllgranWallSurface surface;
    int mesh, triangle;
    double depth;  // set where the deepest are chosen
  };
  static bool deeper(const Contact &one, const Contact &other) { return one.depth > other.depth; }

  // a triangle near a particle: its mesh, its number in the file of the mesh, its place on this rank
  struct Near {
    int mesh, number, place;
    bool operator<(const Near &other) const
    {
      if (mesh != other.mesh) return mesh < other.mesh;
      if (number != other.number) return number < other.number;
      return place < other.place;
    }
  };

  enum { PLANE, CYLINDER, MESH };

  int kind_;
  int axis_;
  double parameters_[3];
  // What is remembered of the contacts of a particle, one after the other, in fixes property/atom of at most so many values each:
  // LIGGGHTS warns of more.
  enum { MOST_VALUES = 20 };
  std::string storage_name_;
  std::vector<class FixPropertyAtom *> storage_;
  // of the particle at hand, before and after the step
  std::vector<double> before_, now_;
  EllgranWallContacts *found_;
  // for each particle; kept between steps for its memory alone
  std::vector<std::vector<Near> > near_;

  // remembered contacts of a particle: whether there is one, its point and normal, and the history of the contact model, each
  int slots() const;
  int slot_length() const;
  std::string storage_name(int piece) const;
  void find_storage();
  void load(int particle);
  void store(int particle);

  // the particle of which a contact was left out since the last word on it, and whether it was said; 0 for none
  int crowded_;
  bool crowd_said_;
  void say_crowded();
  double depth(const EllgranBody &particle, const EllgranWallSurface &surface) const;

  // row of compute wall/gran/local that the next contact fills
  int row_;

  EllgranBody body(int particle) const;
  void check(int32_t status) const;
  void act(int particle, std::vector<Contact> &contacts);
  void keep_deepest(int particle, std::vector<Contact> &contacts);
  void store_again(int particle, int place, const double *force_before, const double *torque_before);
  void forget(int particle);
  bool in_group(int particle) const;
  void gather_near();
  static bool acts_alone(const Contact &contact);
  bool counts_contacts() const;
};

}

#endif
#endif
