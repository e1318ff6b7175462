// SPDX-License-Identifier: GPL-2.0-or-later

#include "fix_wall_gran_ellipsoid.h"

#include "ellgran_refusals.h"
#include "ellgran_step_velocity.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "input.h"
#include "memory.h"
#include "modify.h"
#include "neighbor.h"
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;
using namespace FixConst;

namespace {

const char CALLER[] = "Fix wall/gran/ellipsoid";
const char SYNTAX[] =
    "fix ID group wall/gran/ellipsoid <normal law> [damping ...] [tangential ...] [keywords] "
    "xplane|yplane|zplane lo hi [wiggle dim amplitude period] [shear dim velocity]";

constexpr double TWO_PI = 6.283185307179586476925286766559;

}    // namespace

FixWallGranEllipsoid::FixWallGranEllipsoid(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), atoms(lmp, CALLER), laws(nullptr), workspace(nullptr), dimension(0),
    motion(Motion::NONE), motion_axis(0), amplitude(0.0), period(1.0), shear_velocity(0.0),
    time_then(0.0), time_step(update->dt), step_then(update->ntimestep),
    last_step(update->ntimestep), fix_step_velocity(nullptr), history_length(0), touching(nullptr), history(nullptr),
    fix_rigid(nullptr), tallies(ELLGRAN_INIT(EllgranTallies)), friction(0.0), work_of_walls(0.0),
    power_of_walls(0.0), output_here{}, output_all{}, summed(true)
{
  if (ellgran_abi_version() != ELLGRAN_ABI_VERSION)
    error->all(FLERR, "{}: compiled for ABI version {} of ellgran, but linked with version {}",
               CALLER, static_cast<int>(ELLGRAN_ABI_VERSION),
               static_cast<int>(ellgran_abi_version()));
  atoms.require_atom_style();

  int iarg = parse_law(narg, arg);
  iarg = parse_wall(iarg, narg, arg);
  parse_motion(iarg, narg, arg);

  if (ellgran_workspace_new(&workspace) != ELLGRAN_SUCCESS)
    error->one(FLERR, "{}: {}", CALLER, ellgran_last_error());

  scalar_flag = vector_flag = 1;
  extscalar = extvector = 1;
  size_vector = NUMBER_OF_OUTPUTS;
  global_freq = 1;
  energy_global_flag = 1;
  create_attribute = 1;
  restart_global = 1;
  time_depend = (motion == Motion::WIGGLE) ? 1 : 0;
  restart_peratom = (history_length > 0) ? 1 : 0;
  maxexchange = static_cast<int>(walls.size()) * (history_length + 1);

  FixWallGranEllipsoid::grow_arrays(atom->nmax);
  atom->add_callback(Atom::GROW);
  if (restart_peratom) atom->add_callback(Atom::RESTART);
  for (int i = 0; i < atom->nlocal; i++) FixWallGranEllipsoid::set_arrays(i);
}

FixWallGranEllipsoid::~FixWallGranEllipsoid()
{
  atom->delete_callback(id, Atom::GROW);
  if (restart_peratom) atom->delete_callback(id, Atom::RESTART);
  memory->destroy(touching);
  memory->destroy(history);
  ellgran_laws_free(laws);
  ellgran_workspace_free(workspace);
  // Its place in LAMMPS' list is behind this fix, so that to delete it here shifts nothing before.
  if (fix_step_velocity && modify->nfix > 0 && modify->get_fix_by_id(id_step_velocity))
    modify->delete_fix(id_step_velocity);
}

/* The words of the fix are the law of the contact itself: both sides have these constants. */

int FixWallGranEllipsoid::parse_law(int narg, char **arg)
{
  if (narg < 4) error->all(FLERR, "{}: no law given: {}", CALLER, SYNTAX);
  EllgranLawParameters given = ELLGRAN_INIT(EllgranLawParameters);
  std::size_t consumed = 0;
  if (ellgran_law_parameters_parse(narg - 3, arg + 3, &consumed, &given) != ELLGRAN_SUCCESS)
    error->all(FLERR, "{} {}: {}", CALLER, id, ellgran_last_error());

  const std::size_t pairs = static_cast<std::size_t>(atom->ntypes) * atom->ntypes;
  const std::vector<EllgranLawParameters> parameters(pairs, given);
  const std::vector<uint8_t> is_set(pairs, 1);
  if (ellgran_laws_new(atom->ntypes, parameters.data(), is_set.data(), ELLGRAN_OPTION_NO_WARM_START,
                       &laws) != ELLGRAN_SUCCESS)
    error->all(FLERR, "{} {}: {}", CALLER, id, ellgran_last_error());
  int32_t i = 0, j = 0;
  if (ellgran_laws_create_energy(laws, &i, &j) != ELLGRAN_SUCCESS)
    error->all(FLERR, "{} {}: {}", CALLER, id, ellgran_last_error());
  if (i > 0 && comm->me == 0)
    error->warning(FLERR,
                   "{} {}: displacement total and displacement incremental can create energy, and nothing in this law "
                   "dissipates any: use displacement rescaled, or a law with damping",
                   CALLER, id);
  history_length = ellgran_laws_history_length(laws);
  return 3 + static_cast<int>(consumed);
}

int FixWallGranEllipsoid::parse_wall(int iarg, int narg, char **arg)
{
  if (iarg >= narg) error->all(FLERR, "{} {}: no wall given: {}", CALLER, id, SYNTAX);
  const char *word = arg[iarg];
  if (std::strcmp(word, "zcylinder") == 0 || std::strcmp(word, "region") == 0)
    error->all(FLERR, "{} {}: wall '{}' is not available: use xplane, yplane or zplane", CALLER, id,
               word);
  if (std::strcmp(word, "xplane") == 0)
    dimension = 0;
  else if (std::strcmp(word, "yplane") == 0)
    dimension = 1;
  else if (std::strcmp(word, "zplane") == 0)
    dimension = 2;
  else
    error->all(FLERR, "{} {}: unknown word '{}': {}", CALLER, id, word, SYNTAX);
  if (iarg + 3 > narg)
    error->all(FLERR, "{} {}: '{}' needs two positions: {} lo hi, NULL for none", CALLER, id, word,
               word);

  for (int k = 0; k < 2; k++) {
    const char *given = arg[iarg + 1 + k];
    if (std::strcmp(given, "NULL") == 0) continue;
    const double position = utils::numeric(FLERR, given, false, lmp);
    if (!std::isfinite(position))
      error->all(FLERR, "{} {}: {} position {} must be finite", CALLER, id, word, given);
    walls.push_back({position, (k == 0) ? 1.0 : -1.0, k});
  }
  if (walls.empty())
    error->all(FLERR, "{} {}: '{} NULL NULL' is no wall: give at least one position", CALLER, id,
               word);
  if (walls.size() == 2 && walls[0].position >= walls[1].position)
    error->all(FLERR, "{} {}: {} lo {} must be below hi {}", CALLER, id, word, walls[0].position,
               walls[1].position);
  if (domain->periodicity[dimension])
    error->all(FLERR,
               "{} {}: '{}' in a periodic dimension: use 'boundary' with f, s or m in that dimension",
               CALLER, id, word);
  return iarg + 3;
}

int FixWallGranEllipsoid::axis_word(const char *keyword, const char *word) const
{
  if (std::strcmp(word, "x") == 0) return 0;
  if (std::strcmp(word, "y") == 0) return 1;
  if (std::strcmp(word, "z") == 0) return 2;
  error->all(FLERR, "{} {}: {} dimension '{}' must be x, y or z", CALLER, id, keyword, word);
  return -1;
}

int FixWallGranEllipsoid::parse_motion(int iarg, int narg, char **arg)
{
  while (iarg < narg) {
    const std::string word = arg[iarg];
    if (word != "wiggle" && word != "shear")
      error->all(FLERR, "{} {}: unknown word '{}' after the wall: {}", CALLER, id, word, SYNTAX);
    if (motion != Motion::NONE)
      error->all(FLERR, "{} {}: a wall can either wiggle or shear, once", CALLER, id);
    const int words = (word == "wiggle") ? 4 : 3;
    if (iarg + words > narg)
      error->all(FLERR, "{} {}: '{}' needs {} values: {}", CALLER, id, word, words - 1, SYNTAX);
    motion_axis = axis_word(word.c_str(), arg[iarg + 1]);
    if (word == "wiggle") {
      motion = Motion::WIGGLE;
      amplitude = utils::numeric(FLERR, arg[iarg + 2], false, lmp);
      period = utils::numeric(FLERR, arg[iarg + 3], false, lmp);
      if (!std::isfinite(amplitude) || !std::isfinite(period) || period <= 0.0)
        error->all(FLERR, "{} {}: wiggle amplitude {} must be finite and period {} positive", CALLER,
                   id, arg[iarg + 2], arg[iarg + 3]);
    } else {
      motion = Motion::SHEAR;
      shear_velocity = utils::numeric(FLERR, arg[iarg + 2], false, lmp);
      if (!std::isfinite(shear_velocity))
        error->all(FLERR, "{} {}: shear velocity {} must be finite", CALLER, id, arg[iarg + 2]);
      if (motion_axis == dimension)
        error->all(FLERR, "{} {}: a plane cannot shear along its own normal", CALLER, id);
    }
    iarg += words;
  }
  return iarg;
}

int FixWallGranEllipsoid::setmask()
{
  return POST_INTEGRATE | POST_FORCE | MIN_POST_FORCE;
}

void FixWallGranEllipsoid::init()
{
  atoms.require_atom_style();
  if (utils::strmatch(update->integrate_style, "^respa"))
    error->all(FLERR, "{} does not support rRESPA: use 'run_style verlet'", CALLER);
  if (domain->periodicity[dimension])
    error->all(FLERR, "{} {}: the dimension of the wall became periodic", CALLER, id);
  atoms.require_shapes(groupbit);
  refuse_styles(lmp, CALLER, history_length > 0);
  if (motion == Motion::WIGGLE && input->command && std::strcmp(input->command, "rerun") == 0)
    error->all(FLERR, "{} {}: 'rerun' does not say where in its motion a wiggling wall is", CALLER, id);
  place_step_velocity_fix();

  fix_rigid = nullptr;
  for (auto *fix : modify->get_fix_list())
    if (fix->rigid_flag) {
      if (fix_rigid) error->all(FLERR, "{}: only one fix rigid is allowed", CALLER);
      fix_rigid = fix;
    }
}

void FixWallGranEllipsoid::setup(int vflag)
{
  post_force(vflag);
}

void FixWallGranEllipsoid::min_setup(int vflag)
{
  post_force(vflag);
}

void FixWallGranEllipsoid::min_post_force(int vflag)
{
  post_force(vflag);
}

void FixWallGranEllipsoid::place_step_velocity_fix()
{
  if (fix_step_velocity && !modify->get_fix_by_id(id_step_velocity)) fix_step_velocity = nullptr;
  if (fix_step_velocity || !FixEllgranStepVelocity::needed(modify)) return;
  fix_step_velocity = add_step_velocity(modify, std::string("ELLGRAN_STEP_VELOCITY_") + id);
  id_step_velocity = fix_step_velocity->id;
}

/* Called in every step and when forces are computed without a step: a step may have got another length or number. */

void FixWallGranEllipsoid::follow_time(bool passes)
{
  const bigint before = passes ? update->ntimestep - 1 : update->ntimestep;
  if (update->dt != time_step || before != last_step) {
    time_then += static_cast<double>(last_step - step_then) * time_step;
    time_step = update->dt;
    step_then = before;
  }
  last_step = update->ntimestep;
}

double FixWallGranEllipsoid::time_passed() const
{
  return time_then + static_cast<double>(last_step - step_then) * time_step;
}

std::vector<EllgranPlane> FixWallGranEllipsoid::planes_now(bool time_passes) const
{
  double shift = 0.0, velocity = 0.0;
  if (motion == Motion::WIGGLE) {
    const double rate = TWO_PI / period;
    const double phase = rate * time_passed();
    if (motion_axis == dimension) shift = amplitude * (1.0 - std::cos(phase));
    // As the grains' velocities, that of the wall is the one that brought it here in this step.
    velocity = time_passes
        ? 2.0 * amplitude * std::sin(phase - 0.5 * rate * time_step) *
            std::sin(0.5 * rate * time_step) / time_step
        : amplitude * rate * std::sin(phase);
  } else if (motion == Motion::SHEAR) {
    velocity = shear_velocity;
  }
  std::vector<EllgranPlane> planes(walls.size(), ELLGRAN_INIT(EllgranPlane));
  for (std::size_t k = 0; k < walls.size(); k++) {
    planes[k].point[dimension] = walls[k].position + shift;
    planes[k].normal[dimension] = walls[k].out;
    planes[k].velocity[motion_axis] = velocity;
  }
  return planes;
}

/* Half of the work of a force is done with the velocity to which it has led. */

void FixWallGranEllipsoid::post_integrate()
{
  work_of_walls += 0.5 * update->dt * power_of_walls;
  if (!tallies.inelastic_loads) return;
  EllgranStep step = ELLGRAN_INIT(EllgranStep);
  step.time_step = update->dt;
  step.advance_history = 1;
  const EllgranParticles particles = atoms.view();
  if (ellgran_tally_following_half_step(&particles, &step, &tallies) != ELLGRAN_SUCCESS)
    error->one(FLERR, "{} {}: {}", CALLER, id, ellgran_last_error());
}

void FixWallGranEllipsoid::post_force(int)
{
  std::fill_n(output_here, static_cast<int>(NUMBER_OF_OUTPUTS), 0.0);
  summed = false;
  find_contact_masses();

  // Time does not pass when LAMMPS computes forces anew at the start of a run or minimises.
  const bool time_passes = update->setupflag == 0 && update->whichflag != 2;
  follow_time(time_passes);
  const std::vector<EllgranPlane> planes = planes_now(time_passes);
  double wall_forces[6] = {};
  inelastic_loads.resize(12 * static_cast<std::size_t>(atom->nlocal));
  tallies.inelastic_loads = (atom->nlocal > 0) ? inelastic_loads.data() : nullptr;
  tallies.normal_elastic_energy = tallies.tangential_elastic_energy = tallies.touching_count = 0.0;

  EllgranStep step = ELLGRAN_INIT(EllgranStep);
  step.time_step = update->dt;
  step.advance_history = time_passes ? 1 : 0;

  if (atom->nlocal > 0) {
    EllgranParticles particles = atoms.view();
    if (fix_step_velocity) fix_step_velocity->replace_velocities(particles, false);
    if (!contact_masses.empty()) particles.contact_masses = contact_masses.data();
    const int wall_type = 1;    // every pair of types has the law of this fix
    if (ellgran_compute_planes(laws, workspace, &particles, atom->mask, groupbit, wall_type,
                               planes.size(), planes.data(), touching ? touching[0] : nullptr,
                               history ? history[0] : nullptr, &step, wall_forces,
                               &tallies) != ELLGRAN_SUCCESS)
      error->one(FLERR, "{} {}: {}", CALLER, id, ellgran_last_error());
  }

  // Friction has dissipated the work of the tangential forces less what the contacts hold of it.
  if (step.advance_history)
    friction = tallies.tangential_work - tallies.tangential_elastic_energy;
  else
    tallies.tangential_work = friction + tallies.tangential_elastic_energy;

  power_of_walls = 0.0;
  for (std::size_t k = 0; k < walls.size(); k++)
    for (int c = 0; c < 3; c++) power_of_walls -= wall_forces[3 * k + c] * planes[k].velocity[c];
  if (step.advance_history) work_of_walls += 0.5 * step.time_step * power_of_walls;

  for (std::size_t k = 0; k < walls.size(); k++)
    for (int c = 0; c < 3; c++)
      output_here[(walls[k].slot == 0 ? FORCE_LO : FORCE_HI) + c] = wall_forces[3 * k + c];
  output_here[NORMAL_ELASTIC] = tallies.normal_elastic_energy;
  output_here[TANGENTIAL_ELASTIC] = tallies.tangential_elastic_energy;
  output_here[VISCOUS_DISSIPATION] = tallies.viscous_dissipation;
  output_here[FRICTIONAL_DISSIPATION] = friction;
  output_here[DISSIPATED] = output_here[VISCOUS_DISSIPATION] + output_here[FRICTIONAL_DISSIPATION];
  output_here[TOUCHING] = tallies.touching_count;
  output_here[WORK_OF_WALLS] = work_of_walls;
}

void FixWallGranEllipsoid::find_contact_masses()
{
  if (!fix_rigid || ellgran_laws_uses_mass(laws) == 0) {
    contact_masses.clear();
    return;
  }
  // Atoms move between ranks only when neighbour lists are built.
  if (neighbor->ago != 0 && !contact_masses.empty()) return;
  int rank;
  const auto *body = static_cast<int *>(fix_rigid->extract("body", rank));
  const auto *body_masses = static_cast<double *>(fix_rigid->extract("masstotal", rank));
  contact_masses.assign(atom->rmass, atom->rmass + atom->nlocal + atom->nghost);
  if (body && body_masses)
    for (int i = 0; i < atom->nlocal; i++)
      if (body[i] >= 0) contact_masses[i] = body_masses[body[i]];
}

void FixWallGranEllipsoid::sum_output()
{
  if (summed) return;
  MPI_Allreduce(output_here, output_all, NUMBER_OF_OUTPUTS, MPI_DOUBLE, MPI_SUM, world);
  summed = true;
}

double FixWallGranEllipsoid::compute_scalar()
{
  sum_output();
  return output_all[NORMAL_ELASTIC] + output_all[TANGENTIAL_ELASTIC];
}

double FixWallGranEllipsoid::compute_vector(int k)
{
  sum_output();
  return output_all[k];
}

double FixWallGranEllipsoid::memory_usage()
{
  double bytes = static_cast<double>(ellgran_workspace_bytes(workspace));
  bytes += static_cast<double>(contact_masses.capacity() + inelastic_loads.capacity()) * sizeof(double);
  if (history_length > 0)
    bytes += static_cast<double>(atom->nmax) * static_cast<double>(walls.size()) *
        (sizeof(int) + history_length * sizeof(double));
  return bytes;
}

void FixWallGranEllipsoid::grow_arrays(int nmax)
{
  if (history_length == 0) return;
  const int columns = static_cast<int>(walls.size());
  memory->grow(touching, nmax, columns, "wall/gran/ellipsoid:touching");
  memory->grow(history, nmax, columns * history_length, "wall/gran/ellipsoid:history");
}

void FixWallGranEllipsoid::copy_arrays(int i, int j, int)
{
  if (history_length == 0) return;
  const int columns = static_cast<int>(walls.size());
  std::copy_n(touching[i], columns, touching[j]);
  std::copy_n(history[i], columns * history_length, history[j]);
}

void FixWallGranEllipsoid::set_arrays(int i)
{
  if (history_length == 0) return;
  const int columns = static_cast<int>(walls.size());
  std::fill_n(touching[i], columns, 0);
  std::fill_n(history[i], columns * history_length, 0.0);
}

int FixWallGranEllipsoid::pack_exchange(int i, double *buffer)
{
  if (history_length == 0) return 0;
  const int columns = static_cast<int>(walls.size());
  double *next = std::copy_n(touching[i], columns, buffer);
  next = std::copy_n(history[i], columns * history_length, next);
  return static_cast<int>(next - buffer);
}

int FixWallGranEllipsoid::unpack_exchange(int nlocal, double *buffer)
{
  if (history_length == 0) return 0;
  const int columns = static_cast<int>(walls.size());
  for (int k = 0; k < columns; k++) touching[nlocal][k] = static_cast<int>(buffer[k]);
  std::copy_n(buffer + columns, columns * history_length, history[nlocal]);
  return columns * (1 + history_length);
}

int FixWallGranEllipsoid::size_restart(int)
{
  return (history_length == 0) ? 0 : 1 + static_cast<int>(walls.size()) * (1 + history_length);
}

int FixWallGranEllipsoid::maxsize_restart()
{
  return size_restart(0);
}

int FixWallGranEllipsoid::pack_restart(int i, double *buffer)
{
  if (history_length == 0) return 0;
  buffer[0] = 1 + pack_exchange(i, buffer + 1);
  return static_cast<int>(buffer[0]);
}

void FixWallGranEllipsoid::unpack_restart(int nlocal, int nth)
{
  if (history_length == 0) return;
  double *extra = atom->extra[nlocal];
  for (int k = 0; k < nth; k++) extra += static_cast<int>(*extra);
  if (static_cast<int>(*extra) != size_restart(nlocal))
    error->one(FLERR,
               "{} {}: the restart file keeps another number of values per contact: give the fix the "
               "law and the walls that it had, or another ID",
               CALLER, id);
  unpack_exchange(nlocal, extra + 1);
}

void FixWallGranEllipsoid::write_restart(FILE *fp)
{
  const double mine[3] = {tallies.viscous_dissipation, friction, work_of_walls};
  double sums[3] = {0.0, 0.0, 0.0};
  MPI_Allreduce(mine, sums, 3, MPI_DOUBLE, MPI_SUM, world);
  if (comm->me == 0) {
    const double values[4] = {sums[0], time_passed(), sums[1], sums[2]};
    const int size = sizeof(values);
    fwrite(&size, sizeof(int), 1, fp);
    fwrite(values, sizeof(double), 4, fp);
  }
}

void FixWallGranEllipsoid::restart(char *buffer)
{
  double values[4];
  std::memcpy(values, buffer, sizeof(values));
  time_then = values[1];
  step_then = last_step = update->ntimestep;
  if (comm->me != 0) return;
  tallies.viscous_dissipation = values[0];
  friction = values[2];
  work_of_walls = values[3];
}

void FixWallGranEllipsoid::set_molecule(int, tagint, int, double *, double *, double *)
{
  error->all(FLERR, "Molecule update not implemented for fix {}", style);
}
