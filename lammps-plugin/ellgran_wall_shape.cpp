// SPDX-License-Identifier: GPL-2.0-or-later

#include "ellgran_wall_shape.h"

#include "error.h"
#include "lammps.h"
#include "utils.h"

#include <cstdint>
#include <set>

using namespace LAMMPS_NS;

const char LAMMPS_NS::WALL_SHAPE_SYNTAX[] =
    "shape NAME [point x y z] [axis ax ay az] [radius r] [radii r1 r2] [bounds lo hi] [ends none|open|closed none|open|closed] "
    "[side inside|outside|centre]";

namespace {

struct Word {
  const char *word;
  int32_t value;
};

constexpr Word SIDES[] = {{"centre", ELLGRAN_SIDE_OF_CENTRE}, {"inside", ELLGRAN_SIDE_INSIDE}, {"outside", ELLGRAN_SIDE_OUTSIDE}};
constexpr Word ENDS[] = {{"none", ELLGRAN_END_NONE}, {"open", ELLGRAN_END_OPEN}, {"closed", ELLGRAN_END_CLOSED}};

// What the words of one shape are read with.
class Words {
 public:
  Words(LAMMPS *lmp, const std::string &caller, int narg, char **words) : lmp(lmp), caller(caller), narg(narg), words(words) {}

  [[nodiscard]] bool at_end() const { return place >= narg; }
  [[nodiscard]] int read() const { return place; }
  [[nodiscard]] const char *now() const { return words[place]; }
  const char *next() { return words[place++]; }

  // Begins a keyword with so many values.
  void begin(int count)
  {
    keyword = next();
    if (place + count > narg)
      lmp->error->all(FLERR, "{}: '{}' of shape {} needs {} value{}: {}", caller, keyword, shape, count, (count == 1) ? "" : "s",
                      WALL_SHAPE_SYNTAX);
    if (!given.insert(keyword).second) lmp->error->all(FLERR, "{}: '{}' of shape {} is given twice", caller, keyword, shape);
  }

  // The library checks the range.
  void numbers(double *values, int count)
  {
    for (int k = 0; k < count; k++) values[k] = utils::numeric(FLERR, next(), false, lmp);
  }

  template <int COUNT> int32_t one_of(const Word (&choices)[COUNT])
  {
    const std::string word = next();
    std::string all;
    for (const Word &choice : choices) {
      if (word == choice.word) return choice.value;
      all += std::string(all.empty() ? "" : ", ") + choice.word;
    }
    lmp->error->all(FLERR, "{}: '{}' of shape {} is one of {}, not '{}'", caller, keyword, shape, all, word);
    return 0;
  }

  std::string shape;

 private:
  LAMMPS *lmp;
  const std::string &caller;
  int narg;
  char **words;
  int place = 0;
  std::string keyword;
  std::set<std::string> given;
};

}    // namespace

int LAMMPS_NS::add_wall_shape(LAMMPS *lmp, const std::string &caller, EllgranWall *wall, int narg, char **arg)
{
  if (narg < 1) lmp->error->all(FLERR, "{}: 'shape' needs a name: {}", caller, WALL_SHAPE_SYNTAX);
  Words words(lmp, caller, narg, arg);
  const char *const name = words.next();
  words.shape = name;
  EllgranWallShape shape = ELLGRAN_INIT(EllgranWallShape);
  shape.name = name;
  shape.axis[2] = 1.0;
  while (!words.at_end()) {
    const std::string word = words.now();
    if (word == "point") {
      words.begin(3);
      words.numbers(shape.point, 3);
    } else if (word == "axis") {
      words.begin(3);
      words.numbers(shape.axis, 3);
    } else if (word == "radius") {
      words.begin(1);
      words.numbers(shape.radii, 1);
    } else if (word == "radii") {
      words.begin(2);
      words.numbers(shape.radii, 2);
    } else if (word == "bounds") {
      words.begin(2);
      words.numbers(shape.bounds, 2);
    } else if (word == "ends") {
      words.begin(2);
      for (int32_t &end : shape.ends) end = words.one_of(ENDS);
    } else if (word == "side") {
      words.begin(1);
      shape.side = words.one_of(SIDES);
    } else
      break;
  }
  if (ellgran_wall_add_shape(wall, &shape) != ELLGRAN_SUCCESS) lmp->error->all(FLERR, "{}: {}", caller, ellgran_last_error());
  return words.read();
}
