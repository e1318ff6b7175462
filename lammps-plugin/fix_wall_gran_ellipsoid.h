// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// `fix wall/gran/ellipsoid`: walls of any shape for ellipsoids, with the contact laws of ellgran.

#ifdef FIX_CLASS
// clang-format off
FixStyle(wall/gran/ellipsoid,FixWallGranEllipsoid);
// clang-format on
#else

#ifndef LMP_FIX_WALL_GRAN_ELLIPSOID_H
#define LMP_FIX_WALL_GRAN_ELLIPSOID_H

#include "fix.h"

#include "ellgran_atoms.h"
#include "ellgran_number_or_variable.h"
#include "ellgran_region.h"
#include "ellgran_wall_servo.h"
#include "ellgran_wall_velocity.h"

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace LAMMPS_NS {

class FixWallGranEllipsoid : public Fix {
 public:
  FixWallGranEllipsoid(class LAMMPS *lmp, int narg, char **arg) : FixWallGranEllipsoid(lmp, narg, arg, true) {}
  ~FixWallGranEllipsoid() override;

  int setmask() override;
  void init() override;
  void setup(int) override;
  void min_setup(int) override;
  void post_integrate() override;
  void post_force(int) override;
  void min_post_force(int) override;

  double compute_scalar() override;
  double compute_vector(int) override;
  void *extract(const char *, int &) override;

  /// Adds what the contacts with the wall contribute to the bound of the stable step (`ellgran_add_wall_to_step_sums`).
  void add_to_step_sums(const EllgranParticles &particles, double *sums, EllgranContactExtremes *extremes);
  [[nodiscard]] const EllgranLaws *contact_laws() const { return laws; }

  /// Whether the contacts of this step were recorded, and what they add to the sums of each owned atom
  /// (`ellgran_add_wall_recorded_to_grain_sums`); not for a rank without atoms.
  [[nodiscard]] bool has_contacts_of(bigint step) const { return step == step_of_contacts; }
  void add_to_grain_sums(double *sums) const;

  double memory_usage() override;
  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  int pack_restart(int, double *) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override;
  int maxsize_restart() override;
  void write_restart(FILE *) override;
  void restart(char *) override;

  // Does what the base class does, whose symbol has the width of atom IDs in its name: not to need it
  // lets a LAMMPS with other integer sizes load the plugin, which then says what is wrong.
  void set_molecule(int, tagint, int, double *, double *, double *) override;

 protected:
  /// `remembers_here`: with an array of what is remembered of the contacts of each atom.
  FixWallGranEllipsoid(class LAMMPS *, int, char **, bool remembers_here);

  /// The same later: an array of what is remembered of the contacts of each atom.
  void keep_with_atoms();

  EllgranAtoms atoms;
  bool remembers_here;
  EllgranLawParameters law_words;    // the law of the grains, which is that of the wall unless it has a material of its own
  EllgranLawParameters wall_words;    // that of the wall's material
  bool has_material;
  bool has_ids_of_file = false;    // what a restart file has of an atom ends with its ID
  bool histories_are_of_other_law = false;    // what a restart file has of contacts means nothing under this law
  EllgranLaws *laws;
  EllgranWorkspace *workspace;
  EllgranWall *wall;
  int wall_type;               // behind the types of atoms

  int dimension;               // of the normal of planes, or of the axis of a cylinder; -1 for other walls
  int plane_slots[2];          // part of the lower and of the upper plane; -1: there is none
  double plane_positions[2];
  bool is_cylinder, is_mesh;
  std::string region_id;       // empty: no region
  std::string region_measures; // of that region, as the wall has them
  std::vector<std::array<double, 3>> plane_normals;    // of endless planes, from words or a region
  struct Plane {
    std::array<double, 3> normal;
    double side;    // of the grains: 1 for that of the normal, -1 for the other, 0 for both
  };
  std::optional<Plane> only_plane;    // where the wall is one plane

  // The motion: at most one of wiggle and shear, velocity, and rotation, which may go together; and a servo
  bool wiggles, shears, rotates, moves;
  int motion_axis;
  double amplitude, period, shear_velocity;
  NumberOrVariable velocity[3], rotation_rate;
  double rotation_point[3], rotation_axis[3];
  std::unique_ptr<WallServo> servo;    // nullptr: none
  bool wall_turns_back = false;        // a restart file has the wall turned by another motion, of which nothing goes on
  // As a restart file has them
  enum {
    MOVES_BY_WORDS,
    TURNS,
    VARIES,
    WIGGLE,
    CONSTANT_VELOCITY = WIGGLE + 3,
    ROTATION_POINT = CONSTANT_VELOCITY + 3,
    ROTATION_AXIS = ROTATION_POINT + 3,
    CONSTANT_RATE = ROTATION_AXIS + 3,
    HAS_SERVO,
    SERVO_DIRECTION,
    NUMBER_OF_WORDS = SERVO_DIRECTION + 3
  };
  using MotionWords = std::array<double, NUMBER_OF_WORDS>;

  // Motion by variables: how far it went, the present values, and the mean ones over the last step
  double varied_displacement[3], varied_angle;
  double velocity_now[3], rate_now;
  double mean_velocity[3], mean_rate;
  bool means_are_known = false;    // a step was made
  WallVelocityAtStep at_step;      // of this motion, or of that of a region

  // Motion of a region: pose of the last step, and the velocities over the step
  bool pose_is_known;
  RegionPose pose;
  double region_velocity[3], region_rate;
  double region_step = 0.0;    // length of the step that they are of; 0: none was made

  // Time of a motion: `time_then` had passed at the step `step_then`, and steps are as long as `time_step` since. It goes on
  // whatever becomes of the number or the length of the steps.
  double time_then, time_step;
  bigint step_then, last_step;

  std::string id_step_velocity;
  class FixEllgranStepVelocity *fix_step_velocity;    // nullptr: `atom->v` is right
  class FixNVEEllipsoid *velocities_of_step;          // nullptr: forces see those of the half step, or are computed on a GPU
  bool sees_velocities_of_step = false;               // on a GPU too

  // What is remembered of the contacts of each atom, one row per atom
  int histories_length;
  double **contact_histories;

  // The contacts, one row each, if asked for
  bool tells_contacts;
  // Whether energies are summed up: in all runs, in none, or (neither) where somebody asks for them; and in this one
  bool keeps_energies, leaves_energies_out;
  bool sums_energies;
  // Whether atoms may change in a run without a new neighbour list; the last step whose forces were computed
  bool scene_may_change;
  class PairGranEllipsoid *pair = nullptr;    // the only one of ours, which has prepared most grains when the wall's turn comes
  bigint step_of_forces;
  // Whether a compute may ask for the contacts of a step, and the last step in which they were recorded
  bool contacts_wanted;
  bigint step_of_contacts;
  std::vector<double> contact_values;
  std::vector<double *> contact_rows;

  // The file of the triangles' loads: every so many steps, 0 for none
  int triangle_file_every;
  std::string triangle_file;

  // Masses of the rigid bodies that atoms are in
  class Fix *fix_rigid;
  std::vector<double> contact_masses;

  // This rank's share of the output, and the sums over ranks once somebody asks
  enum {
    FORCE_LO,
    FORCE_HI = FORCE_LO + 3,
    NORMAL_ELASTIC = FORCE_HI + 3,
    TANGENTIAL_ELASTIC,
    DISSIPATED,
    TOUCHING,
    VISCOUS_DISSIPATION,
    FRICTIONAL_DISSIPATION,
    WORK_OF_WALLS,
    FORCE,
    TORQUE = FORCE + 3,
    POWER = TORQUE + 3,
    NUMBER_OF_SUMS,
    // the same on all ranks
    DISPLACEMENT = NUMBER_OF_SUMS,
    VELOCITY = DISPLACEMENT + 3,
    SERVO_FORCE = VELOCITY + 3,
    SERVO_TARGET,
    NUMBER_OF_OUTPUTS
  };
  // Energies dissipated and work of the walls since the fix was made, this rank's share; the wall keeps the loads that dissipate
  EllgranTallies tallies;
  double friction, work_of_walls;
  EllgranWallLoad last_load;    // on the wall, at the end of the last step
  double output_here[NUMBER_OF_SUMS], output_all[NUMBER_OF_SUMS];
  double displacement[3], wall_velocity[3];
  bool summed;
  EllgranWallMotion motion_of_forces;    // the motion with which forces were computed last
  bool has_forces;                       // whether they were
  bool touches_here;                     // whether a grain of this rank touched then
  bool said_missing_image;               // whether it was said that the mesh ends at a periodic boundary

  int parse_law(int narg, char **arg);
  int32_t make_laws(const EllgranLawParameters &of_grains, const EllgranLawParameters &of_wall, EllgranLaws **made) const;
  void compare_with_law_of_file(const char *buffer, bool has_law_of_wall);
  int parse_wall(int iarg, int narg, char **arg);
  int parse_planes(int iarg, int narg, char **arg);
  int parse_cylinder(int iarg, int narg, char **arg);
  int parse_region(int iarg, int narg, char **arg);
  int parse_shapes(int iarg, int narg, char **arg);
  int parse_mesh(int iarg, int narg, char **arg);
  int parse_keywords(int iarg, int narg, char **arg);
  void parse_wiggle(char **arg);
  void parse_shear(char **arg);
  void parse_rotate(char **arg);
  void parse_triangle_file(char **arg);
  [[nodiscard]] MotionWords motion_words() const;
  [[nodiscard]] bool has_motion_of(const MotionWords &words) const;
  [[nodiscard]] bool has_servo_of(const MotionWords &words) const;
  [[nodiscard]] bool has_words(const MotionWords &words, int first, int last) const;
  void check_servo() const;
  [[nodiscard]] double number(const char *keyword, const char *word) const;
  void require_values(const char *keyword, int count, int iarg, int narg) const;
  void check(int32_t status) const;
  void check_words(int32_t status) const;
  void check_periodicity() const;
  void require_region_as_it_was() const;
  void warn_of_missing_images();
  int axis_word(const char *keyword, const char *word) const;
  void follow_time(bool passes);
  [[nodiscard]] double time_passed() const;
  [[nodiscard]] bool varies() const;
  void follow_variables(bool time_passes);
  [[nodiscard]] EllgranWallMotion motion_now(bool time_passes);
  class Region *present_region() const;
  void add_region_motion(EllgranWallMotion &motion, bool time_passes);
  void add_change_at_step(EllgranWallMotion &motion, const double *axis) const;
  void add_work_since_last_forces(const EllgranWallMotion &motion);
  void tell_contacts();
  void write_triangle_file(const EllgranWallMotion &motion);
  void place_step_velocity_fix();
  void find_contact_masses();
  void sum_output();
  void require_energies(const std::string &value) const;
  [[nodiscard]] bool energies_wanted() const;
};

}    // namespace LAMMPS_NS

#endif
#endif
