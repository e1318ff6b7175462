/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * fix wall/gran/ellipsoid: fix wall/gran, with the same words, for surface ellipsoid, and the shapes of the library by their names.
 * The library takes all particles with the wall in one call, to their forces. Where something needs the contacts one by one, it finds
 * them in one call, and each acts through LIGGGHTS' own contact model, with the same result.
 */

#ifdef FIX_CLASS
FixStyle(wall/gran/ellipsoid,FixWallGranEllipsoid)
#else

#ifndef LMP_FIX_WALL_GRAN_ELLIPSOID_H
#define LMP_FIX_WALL_GRAN_ELLIPSOID_H

#include <cstddef>
#include <cstdio>
#include <vector>

#include "ellgran.h"
#include "fix_wall_gran.h"

namespace LIGGGHTS {
namespace ContactModels {
struct EllgranContact;
}
}

namespace LAMMPS_NS {

class FixWallGranEllipsoid : public FixWallGran {
 public:
  FixWallGranEllipsoid(class LAMMPS *, int, char **);
  virtual ~FixWallGranEllipsoid();
  virtual void post_create();
  virtual void init();
  virtual void setup(int vflag);
  virtual void post_run();

  // what is remembered of contacts goes with the particles
  virtual double memory_usage();
  virtual void grow_arrays(int count);
  virtual void copy_arrays(int from, int to, int);
  virtual void set_arrays(int particle);
  virtual int pack_exchange(int particle, double *buffer);
  virtual int unpack_exchange(int particle, double *buffer);
  virtual int size_restart(int particle);
  virtual int maxsize_restart();
  virtual int pack_restart(int particle, double *buffer);
  virtual void unpack_restart(int particle, int place);

  // so does what they mean
  virtual void write_restart(FILE *fp);
  virtual void restart(char *state);

  // what the present contacts contribute to the bound of the stable step, after forces were computed; whether there is a model nfd
  void add_to_step_sums(const EllgranParticles &particles, double *sums, EllgranContactExtremes *extremes);
  const EllgranLaws *laws_with_friction() const;
  bool has_laws() const;

 protected:
  virtual void pre_neighbor();
  virtual void post_force_primitive(int);
  virtual void post_force_mesh(int);

 private:
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

  EllgranWall *wall_;
  EllgranWorkspace *workspace_;
  // the step whose forces were computed in one call, -1 if those of the last step were not; neighbour lists built until then
  int64_t step_of_one_call_, lists_of_one_call_;
  // of a primitive wall: a point of it, or of its axis
  double point_[3];
  // the word of a primitive wall that depends on each of the coordinates; NULL: none
  const char *across_[3];
  // what is remembered of the contacts of each particle
  int histories_length_;
  double **histories_;
  // whether what a restart file has of them means nothing to these models
  bool histories_are_of_other_models_;

  // triangles near particles, as the library is told of them; kept between steps for their memory alone
  std::vector<Near> near_;
  std::vector<double> corners_, velocities_;
  std::vector<size_t> starts_;
  std::vector<uint32_t> lists_;

  // a particle with contacts that are not remembered since the last word on it, and whether it was said; 0 for none
  int crowded_;
  bool crowd_said_;
  void say_crowded();

  // row of compute wall/gran/local that the next contact fills
  int row_;

  void check(int32_t status) const;
  void read_older_histories();
  void refuse_meshes_named_twice() const;
  void add_primitive(int narg, char **arg);
  void add_shape(const char *style, const double *parameters);
  void check_periodicity() const;
  void lend_triangles();
  void refuse_turning_images() const;
  bool is_across(int dimension, const double *point) const;
  EllgranWallMotion motion_of_primitive() const;
  void act(const EllgranWallMotion *motion);
  bool takes_one_call(const LIGGGHTS::ContactModels::EllgranContact &model, const EllgranLaws *laws) const;
  void act_in_one_call(LIGGGHTS::ContactModels::EllgranContact &model, const EllgranLaws *laws, const EllgranWallMotion *motion);
  void act(LIGGGHTS::ContactModels::EllgranContact &model, size_t index);
  void store_again(int particle, int place, const double *force_before, const double *torque_before);
  bool counts_contacts() const;
};

}

#endif
#endif
