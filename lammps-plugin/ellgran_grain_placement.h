// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// Where in a region is room for a further grain, and how does it become a particle of LAMMPS?
/// Shared by `fix pour/ellipsoid` and `create_ellipsoids`. All ranks hold the same grains and ask the same questions, so that all
/// find the same answers; whether two grains or a grain and a wall overlap is the library's contact search.

#ifndef ELLGRAN_GRAIN_PLACEMENT_H
#define ELLGRAN_GRAIN_PLACEMENT_H

#include "lmptype.h"
#include "pointers.h"

#include "ellgran.h"
#include "ellgran_atoms.h"
#include "ellgran_grain_mixture.h"

#include <array>
#include <string>
#include <vector>

namespace LAMMPS_NS {

class EllgranGrainPlacement : protected Pointers {
 public:
  /// `caller` opens every message, for example "Fix pour/ellipsoid rain".
  EllgranGrainPlacement(class LAMMPS *lmp, const std::string &caller);
  ~EllgranGrainPlacement() override;
  EllgranGrainPlacement(const EllgranGrainPlacement &) = delete;
  EllgranGrainPlacement &operator=(const EllgranGrainPlacement &) = delete;

  /// Stops where no grain could ever be inserted: the kind of box, of atoms, the ABI version of the library.
  void require_scene() const;

  /// The region for the grains: `whole_grains`: for all of each grain, so that the faces of the region are walls but for those
  /// where a periodic box goes on; else for their centres alone. Stops if the region will not do.
  void set_region(class Region *region, bool whole_grains);

  /// Its bounding box within the simulation box, and its volume.
  const double *low() const { return bound[0]; }
  const double *high() const { return bound[1]; }
  double volume() const { return region_volume; }

  /// Learns from all ranks which grains are in reach of a new one of the largest semi-axis `largest`, if the region is higher
  /// than where it was defined by `rise`. Half of the size that most new grains have, `typical`, is for speed alone.
  /// `ignore_others`: particles without a shape are as if they were not there, else they stop the run.
  void collect(double largest, double typical, double rise, bool ignore_others);

  /// Is the grain's centre in the region?
  bool is_inside(const double *position) const;
  /// Is the grain in the region as `set_region` was told, and does it overlap none that is there?
  bool is_free(const EllgranGrain &grain);
  /// From now on it is there.
  void add(const EllgranGrain &grain);

  /// Makes it a particle on the rank where it belongs, with the ID `tag`, in the groups of `mask`. Ghosts must have gone.
  void create(const EllgranGrain &grain, int type, tagint tag, int mask, const double *velocity);
  /// LAMMPS forgets its ghosts, whose places are needed.
  void begin_creation();
  /// After the last of `count` grains, whose particles have IDs up to `last_tag`.
  void end_creation(bigint count, bigint last_tag);
  /// The greatest ID of all particles.
  tagint greatest_tag() const;

 private:
  struct Present {
    double position[3], quaternion[4], semi_axes[3];
    double largest, smallest;
    double axes[3][3];    // from the centre to the tips, the longest first
    double reach[3];      // half of the box around it
    double tag;
  };

  std::string caller;
  EllgranAtoms atoms;
  Region *region = nullptr;
  bool whole = true;
  double bound[2][3] = {};
  double region_volume = 0.0;
  double raised = 0.0;
  int created_here = 0;

  EllgranWall *wall = nullptr;
  bool bodies = false;    // grains lie around surfaces of it
  std::vector<std::array<double, 6>> blocks;    // those among the bodies, and their bounds
  EllgranLaws *wall_laws = nullptr;
  EllgranWorkspace *workspace = nullptr;
  std::vector<double> wall_histories;

  // Grains by the cells that the boxes around them reach into: those around balls have no end of cells for needles.
  std::vector<Present> present;
  std::vector<std::vector<int>> cells;
  std::vector<int> asked;    // the last question in which a grain came up
  int question = 0;
  double cell_low[3] = {}, cell_size = 1.0;
  int cell_count[3] = {1, 1, 1};

  void check(int32_t status) const;
  void require_closed(const class Region *part) const;
  void find_bounds();
  void find_volume();
  void make_wall();
  void add_plane(int axis, double position, double direction);
  bool touches_wall(const EllgranGrain &grain, const double *reach);
  bool touches_wall_at(const EllgranGrain &grain, const double *position, double scale);
  static void find_axes(Present &grain);
  static Present present_of(const EllgranGrain &grain);
  static EllgranBody body_of(const Present &grain);
  bool overlaps(const Present &grain, const EllgranBody &body, const Present &other) const;
  void cells_of(const double *position, const double *reach, int range[3][2]) const;
  /// With all images that reach into the cells.
  void remember(const Present &grain);
  template <typename Visit> void each_image(const double *position, const double *reach, Visit visit) const;
};

}    // namespace LAMMPS_NS

#endif
