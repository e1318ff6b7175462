// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_grain_mixture.h"

#include "error.h"
#include "math_const.h"
#include "math_extra.h"
#include "utils.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;
using MathConst::MY_2PI;
using MathConst::MY_PI;

namespace {

// Fractions are typed with a few digits.
constexpr double FRACTION_TOLERANCE = 1.0e-6;

double volume_of(double a, double b, double c)
{
  return 4.0 / 3.0 * MY_PI * a * b * c;
}

// The entry that a number from 0 to 1 falls upon.
std::size_t pick(const std::vector<double> &fractions, double value)
{
  double sum = 0.0;
  for (std::size_t k = 0; k + 1 < fractions.size(); k++) {
    sum += fractions[k];
    if (value < sum) return k;
  }
  return fractions.size() - 1;
}

}    // namespace

const char EllgranGrainMixture::SYNTAX[] =
    "shape one dx dy dz | range dxlo dxhi dylo dyhi dzlo dzhi | poly n dx dy dz fraction ..., "
    "scale one s | range slo shi | poly n s fraction ..., fractions number|volume, dens lo hi, "
    "orient random | align ex ey ez | quat w i j k";

EllgranRandom::EllgranRandom(int seed, Purpose purpose, std::uint64_t count)
{
  std::seed_seq key{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(purpose),
                    static_cast<std::uint32_t>(count), static_cast<std::uint32_t>(count >> 32)};
  engine.seed(key);
}

// Not the distributions of the standard library: each implements them in its own way.
double EllgranRandom::uniform()
{
  return static_cast<double>(engine() >> 11) * 0x1p-53;
}

double EllgranGrain::volume() const
{
  return volume_of(semi_axes[0], semi_axes[1], semi_axes[2]);
}

double EllgranGrain::largest() const
{
  return std::max({semi_axes[0], semi_axes[1], semi_axes[2]});
}

double EllgranGrain::smallest() const
{
  return std::min({semi_axes[0], semi_axes[1], semi_axes[2]});
}

EllgranGrainMixture::EllgranGrainMixture(LAMMPS *lmp, const std::string &caller_name) :
    Pointers(lmp), caller(caller_name)
{
}

double EllgranGrainMixture::number(const std::string &keyword, const char *word) const
{
  if (!utils::is_double(word)) error->all(FLERR, "{}: {} value '{}' is not a number", caller, keyword, word);
  const double value = utils::numeric(FLERR, word, false, lmp);
  if (!std::isfinite(value)) error->all(FLERR, "{}: {} value {} must be finite", caller, keyword, word);
  return value;
}

int EllgranGrainMixture::integer(const std::string &keyword, const char *word) const
{
  if (!utils::is_integer(word)) error->all(FLERR, "{}: {} value '{}' is not an integer", caller, keyword, word);
  return utils::inumeric(FLERR, word, false, lmp);
}

double EllgranGrainMixture::positive(const std::string &keyword, const char *word) const
{
  const double value = number(keyword, word);
  if (value <= 0.0) error->all(FLERR, "{}: {} value {} must be greater than 0", caller, keyword, word);
  return value;
}

void EllgranGrainMixture::require_values(const std::string &keyword, int count, int iarg, int narg) const
{
  if (iarg + 1 + count > narg)
    error->all(FLERR, "{}: '{}' needs {} value{}, {} given: {}", caller, keyword, count, (count == 1) ? "" : "s",
               std::max(0, narg - iarg - 1), SYNTAX);
}

bool EllgranGrainMixture::yes_or_no(const std::string &keyword, const std::string &word) const
{
  if (word != "yes" && word != "no") error->all(FLERR, "{}: {} '{}' must be yes or no", caller, keyword, word);
  return word == "yes";
}

void EllgranGrainMixture::require_order(const std::string &keyword, double low, double high) const
{
  if (low > high) error->all(FLERR, "{}: {} lower bound {} is above the upper bound {}", caller, keyword, low, high);
}

void EllgranGrainMixture::check_fractions(const std::string &keyword, const std::vector<double> &fractions) const
{
  double sum = 0.0;
  for (const double fraction : fractions) {
    if (fraction < 0.0) error->all(FLERR, "{}: {} fraction {} must not be negative", caller, keyword, fraction);
    sum += fraction;
  }
  if (std::fabs(sum - 1.0) > FRACTION_TOLERANCE)
    error->all(FLERR, "{}: the fractions of {} sum to {}: they must sum to 1", caller, keyword, sum);
}

// The word behind a keyword, one, range or poly, and the number of entries of poly.
EllgranGrainMixture::Distribution EllgranGrainMixture::distribution(const std::string &keyword, int iarg, int narg,
                                                                    char **arg, int &count) const
{
  require_values(keyword, 1, iarg, narg);
  const std::string word = arg[iarg + 1];
  count = 1;
  if (word == "one") return ONE;
  if (word == "range") return RANGE;
  if (word == "poly") {
    require_values(keyword, 2, iarg, narg);
    count = integer(keyword + " poly", arg[iarg + 2]);
    // Each entry has two words or more: a larger number cannot be meant, and would overflow what counts words.
    if (count < 1 || count > narg)
      error->all(FLERR, "{}: {} poly {} entries: there must be 1 or more, each with its values and its fraction", caller,
                 keyword, arg[iarg + 2]);
    return POLY;
  }
  error->all(FLERR, "{}: unknown word '{}' after {}: one, range or poly: {}", caller, word, keyword, SYNTAX);
  return NONE;
}

bool EllgranGrainMixture::parse(int &iarg, int narg, char **arg)
{
  const std::string word = arg[iarg];
  if (word == "shape") {
    parse_shape(iarg, narg, arg);
  } else if (word == "scale") {
    parse_scale(iarg, narg, arg);
  } else if (word == "orient") {
    parse_orient(iarg, narg, arg);
  } else if (word == "fractions") {
    require_values(word, 1, iarg, narg);
    const std::string value = arg[iarg + 1];
    if (value != "number" && value != "volume")
      error->all(FLERR, "{}: fractions '{}' must be number or volume", caller, value);
    by_volume = (value == "volume");
    iarg += 2;
  } else if (word == "dens") {
    require_values(word, 2, iarg, narg);
    for (int k = 0; k < 2; k++) density[k] = positive(word, arg[iarg + 1 + k]);
    require_order(word, density[0], density[1]);
    iarg += 3;
  } else if (word == "diam") {
    error->all(FLERR, "{}: 'diam' is for spheres: give three diameters by 'shape one D D D', and a distribution of size by "
                      "'scale range' or 'scale poly'", caller);
  } else if (word == "mol" || word == "molfrac" || word == "rigid" || word == "shake") {
    error->all(FLERR, "{}: '{}' is not supported: grains are single ellipsoids, of 'shape'", caller, word);
  } else
    return false;
  return true;
}

void EllgranGrainMixture::parse_shape(int &iarg, int narg, char **arg)
{
  int count = 0;
  shapes.clear();
  shape_fractions.clear();
  shape = distribution("shape", iarg, narg, arg, count);
  const std::string keyword = "shape " + std::string(arg[iarg + 1]);
  int next = iarg + 2;
  if (shape == RANGE) {
    require_values(keyword, 6, iarg + 1, narg);
    shapes.resize(2);
    for (int k = 0; k < 3; k++) {
      for (int bound = 0; bound < 2; bound++) shapes[bound][k] = 0.5 * positive(keyword, arg[next++]);
      require_order(keyword, shapes[0][k], shapes[1][k]);
    }
  } else {
    const int each = (shape == POLY) ? 4 : 3;
    require_values(keyword, (shape == POLY ? 1 : 0) + count * each, iarg + 1, narg);
    if (shape == POLY) next++;
    for (int entry = 0; entry < count; entry++) {
      Lengths axes{};
      for (double &axis : axes) axis = 0.5 * positive(keyword, arg[next++]);
      shapes.push_back(axes);
      if (shape == POLY) shape_fractions.push_back(number(keyword, arg[next++]));
    }
    if (shape == POLY) check_fractions(keyword, shape_fractions);
  }
  iarg = next;
}

void EllgranGrainMixture::parse_scale(int &iarg, int narg, char **arg)
{
  int count = 0;
  scales.clear();
  scale_fractions.clear();
  scale = distribution("scale", iarg, narg, arg, count);
  const std::string keyword = "scale " + std::string(arg[iarg + 1]);
  int next = iarg + 2;
  if (scale == RANGE) {
    require_values(keyword, 2, iarg + 1, narg);
    for (int bound = 0; bound < 2; bound++) scales.push_back(positive(keyword, arg[next++]));
    require_order(keyword, scales[0], scales[1]);
  } else {
    const int each = (scale == POLY) ? 2 : 1;
    require_values(keyword, (scale == POLY ? 1 : 0) + count * each, iarg + 1, narg);
    if (scale == POLY) next++;
    for (int entry = 0; entry < count; entry++) {
      scales.push_back(positive(keyword, arg[next++]));
      if (scale == POLY) scale_fractions.push_back(number(keyword, arg[next++]));
    }
    if (scale == POLY) check_fractions(keyword, scale_fractions);
  }
  iarg = next;
}

void EllgranGrainMixture::parse_orient(int &iarg, int narg, char **arg)
{
  require_values("orient", 1, iarg, narg);
  const std::string word = arg[iarg + 1];
  if (word == "random") {
    orientation = RANDOM;
    iarg += 2;
  } else if (word == "align") {
    require_values("orient align", 3, iarg + 1, narg);
    double direction[3];
    for (int k = 0; k < 3; k++) direction[k] = number("orient align", arg[iarg + 2 + k]);
    const double length = std::hypot(direction[0], direction[1], direction[2]);
    if (length == 0.0) error->all(FLERR, "{}: orient align needs a direction other than 0 0 0", caller);
    for (double &component : direction) component /= length;
    orientation = ALIGNED;
    // The shortest rotation that takes the first body axis there; about y where it points the other way.
    quaternion[0] = 1.0 + direction[0];
    quaternion[1] = 0.0;
    quaternion[2] = -direction[2];
    quaternion[3] = direction[1];
    if (quaternion[0] < 1.0e-12) {
      quaternion[0] = quaternion[3] = 0.0;
      quaternion[2] = 1.0;
    }
    MathExtra::qnormalize(quaternion);
    iarg += 5;
  } else if (word == "quat") {
    require_values("orient quat", 4, iarg + 1, narg);
    for (int k = 0; k < 4; k++) quaternion[k] = number("orient quat", arg[iarg + 2 + k]);
    if (quaternion[0] == 0.0 && quaternion[1] == 0.0 && quaternion[2] == 0.0 && quaternion[3] == 0.0)
      error->all(FLERR, "{}: orient quat 0 0 0 0 is no orientation: give w i j k of any other length", caller);
    MathExtra::qnormalize(quaternion);
    orientation = GIVEN;
    iarg += 6;
  } else
    error->all(FLERR, "{}: unknown word '{}' after orient: random, align ex ey ez, or quat w i j k", caller, word);
}

void EllgranGrainMixture::finish()
{
  if (shape == NONE) error->all(FLERR, "{}: no shape given: {}", caller, SYNTAX);
  if (scale == NONE) {
    scale = ONE;
    scales = {1.0};
  }
  if (by_volume && shape != POLY && scale != POLY)
    error->all(FLERR, "{}: 'fractions volume' is about the fractions of shape poly or scale poly, and there are none", caller);
  if (by_volume) {
    // Grains are drawn by number: a fraction by volume over the volume of such a grain.
    double sum = 0.0;
    for (std::size_t k = 0; k < shape_fractions.size(); k++)
      sum += shape_fractions[k] /= shapes[k][0] * shapes[k][1] * shapes[k][2];
    for (double &fraction : shape_fractions) fraction /= sum;
    sum = 0.0;
    for (std::size_t k = 0; k < scale_fractions.size(); k++) sum += scale_fractions[k] /= scales[k] * scales[k] * scales[k];
    for (double &fraction : scale_fractions) fraction /= sum;
  }
}

double EllgranGrainMixture::mean_volume() const
{
  double volume = 0.0;
  if (shape == RANGE)
    volume = volume_of(0.5 * (shapes[0][0] + shapes[1][0]), 0.5 * (shapes[0][1] + shapes[1][1]),
                       0.5 * (shapes[0][2] + shapes[1][2]));
  else
    for (std::size_t k = 0; k < shapes.size(); k++)
      volume += (shape == POLY ? shape_fractions[k] : 1.0) * volume_of(shapes[k][0], shapes[k][1], shapes[k][2]);
  double cube = 0.0;
  if (scale == RANGE) {
    // The mean of s^3 over the range, without a difference of fourth powers.
    const double low = scales[0], high = scales[1];
    cube = 0.25 * (low + high) * (low * low + high * high);
  } else
    for (std::size_t k = 0; k < scales.size(); k++)
      cube += (scale == POLY ? scale_fractions[k] : 1.0) * scales[k] * scales[k] * scales[k];
  return volume * cube;
}

double EllgranGrainMixture::largest() const
{
  double axis = 0.0;
  for (const Lengths &axes : shapes) axis = std::max(axis, *std::max_element(axes.begin(), axes.end()));
  return axis * *std::max_element(scales.begin(), scales.end());
}

double EllgranGrainMixture::smallest() const
{
  double axis = shapes[0][0];
  for (const Lengths &axes : shapes) axis = std::min(axis, *std::min_element(axes.begin(), axes.end()));
  return axis * *std::min_element(scales.begin(), scales.end());
}

EllgranGrain EllgranGrainMixture::grain(EllgranRandom &random) const
{
  EllgranGrain made{};
  if (shape == RANGE)
    for (int k = 0; k < 3; k++) made.semi_axes[k] = random.uniform(shapes[0][k], shapes[1][k]);
  else
    std::copy_n((shape == POLY ? shapes[pick(shape_fractions, random.uniform())] : shapes[0]).begin(), 3, made.semi_axes);
  double factor = scales[0];
  if (scale == RANGE)
    factor = random.uniform(scales[0], scales[1]);
  else if (scale == POLY)
    factor = scales[pick(scale_fractions, random.uniform())];
  for (double &axis : made.semi_axes) axis *= factor;
  made.density = random.uniform(density[0], density[1]);
  made.quaternion[0] = 1.0;
  return made;
}

void EllgranGrainMixture::orient(EllgranGrain &made, EllgranRandom &random) const
{
  if (orientation == GIVEN) {
    std::copy_n(quaternion, 4, made.quaternion);
  } else if (orientation == ALIGNED) {
    const double half = 0.5 * MY_2PI * random.uniform();
    double about_first[4] = {std::cos(half), std::sin(half), 0.0, 0.0};
    double there[4] = {quaternion[0], quaternion[1], quaternion[2], quaternion[3]};
    MathExtra::quatquat(there, about_first, made.quaternion);
  } else {
    // K. Shoemake, Uniform random rotations, Graphics Gems III (1992), 124-132.
    const double u = random.uniform();
    const double first = MY_2PI * random.uniform(), second = MY_2PI * random.uniform();
    made.quaternion[0] = std::sqrt(u) * std::cos(second);
    made.quaternion[1] = std::sqrt(1.0 - u) * std::sin(first);
    made.quaternion[2] = std::sqrt(1.0 - u) * std::cos(first);
    made.quaternion[3] = std::sqrt(u) * std::sin(second);
  }
}
