// SPDX-License-Identifier: GPL-2.0-or-later
/// \file
/// What do the grains look like that a command makes: shape, size, density and orientation?
/// Shared by `fix pour/ellipsoid` and `create_ellipsoids`.

#ifndef ELLGRAN_GRAIN_MIXTURE_H
#define ELLGRAN_GRAIN_MIXTURE_H

#include "pointers.h"

#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace LAMMPS_NS {

/// Random numbers that depend on the seed, on what they are for and on a count alone: not on the number of ranks, nor on
/// what was drawn before, so that a restarted run goes on with the same ones.
class EllgranRandom {
 public:
  enum Purpose { LOOK, PLACE };
  EllgranRandom(int seed, Purpose purpose, std::uint64_t count);
  /// From 0 on, below 1.
  double uniform();
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

 private:
  std::mt19937_64 engine;
};

/// One grain: semi-axes along the body axes, quaternion (w, x, y, z) from body to world, centre.
struct EllgranGrain {
  double semi_axes[3];
  double quaternion[4];
  double position[3];
  double density;

  [[nodiscard]] double volume() const;
  [[nodiscard]] double mass() const { return density * volume(); }
  [[nodiscard]] double largest() const;
  [[nodiscard]] double smallest() const;
};

/// The words of a command that say what its grains look like, and grains after them.
class EllgranGrainMixture : protected Pointers {
 public:
  /// `caller` opens every message, for example "Fix pour/ellipsoid rain".
  EllgranGrainMixture(class LAMMPS *lmp, const std::string &caller);

  /// Reads the keyword at `iarg` with its values, and moves `iarg` behind them; false if the keyword is not one of the mixture.
  bool parse(int &iarg, int narg, char **arg);

  /// After the last word: stops if something is missing.
  void finish();

  /// The mean over the mixture, and the bounds of all semi-axes.
  [[nodiscard]] double mean_volume() const;
  [[nodiscard]] double mean_density() const { return 0.5 * (density[0] + density[1]); }
  [[nodiscard]] double largest() const;
  [[nodiscard]] double smallest() const;

  /// The grain of this number, without position and orientation.
  [[nodiscard]] EllgranGrain grain(EllgranRandom &random) const;
  /// Gives it an orientation.
  void orient(EllgranGrain &grain, EllgranRandom &random) const;

  /// A finite number, or an error that names keyword and word.
  double number(const std::string &keyword, const char *word) const;
  int integer(const std::string &keyword, const char *word) const;
  void require_values(const std::string &keyword, int count, int iarg, int narg) const;
  /// 1 for yes, 0 for no.
  bool yes_or_no(const std::string &keyword, const std::string &word) const;

  static const char SYNTAX[];

 private:
  enum Distribution { NONE, ONE, RANGE, POLY };
  enum Orientation { RANDOM, ALIGNED, GIVEN };
  using Lengths = std::array<double, 3>;

  std::string caller;
  // ONE: the first entry; RANGE: the first two are the bounds; POLY: as many as there are fractions.
  Distribution shape = NONE, scale = NONE;
  std::vector<Lengths> shapes;    // semi-axes
  std::vector<double> scales;
  std::vector<double> shape_fractions, scale_fractions;
  bool by_volume = false;
  double density[2] = {1.0, 1.0};
  Orientation orientation = RANDOM;
  double quaternion[4] = {1.0, 0.0, 0.0, 0.0};

  Distribution distribution(const std::string &keyword, int iarg, int narg, char **arg, int &count) const;
  void parse_shape(int &iarg, int narg, char **arg);
  void parse_scale(int &iarg, int narg, char **arg);
  void parse_orient(int &iarg, int narg, char **arg);
  double positive(const std::string &keyword, const char *word) const;
  void check_fractions(const std::string &keyword, const std::vector<double> &fractions) const;
  void require_order(const std::string &keyword, double low, double high) const;
};

}    // namespace LAMMPS_NS

#endif
