// SPDX-License-Identifier: MIT OR Apache-2.0
//
// A small packing of ellipsoids through ellgran_compute_pairs, one call a step with the caller's own arrays, and the
// same contacts one by one through ellgran_contact. C++11. Any consistent units.
//
//   c++ -std=c++11 neighbour_list.cpp $(pkg-config --cflags --libs ellgran) -o neighbour_list && ./neighbour_list
//
// Prints pairs listed, contacts, elastic energy and the largest force at the last step. Fails if forces or torques of
// the two ways differ by more than rounding, and says by how much.
//
// pairs listed:   54
// contacts:       28
// elastic energy: 1.2e+05
// largest force:  1.632e+05
// the neighbour list and single contacts agree
#include <ellgran.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

namespace {

using Vector = std::array<double, 3>;
using Quaternion = std::array<double, 4>;

void check(std::int32_t status)
{
  if (status != ELLGRAN_SUCCESS) {
    std::fprintf(stderr, "ellgran: error %d: %s\n", static_cast<int>(status), ellgran_last_error());
    std::exit(EXIT_FAILURE);
  }
}

struct Free {
  void operator()(EllgranLaws *laws) const { ellgran_laws_free(laws); }
  void operator()(EllgranWorkspace *workspace) const { ellgran_workspace_free(workspace); }
};

// Numbers that are the same with every compiler.
class Random {
 public:
  double between(double low, double high)
  {
    state_ = state_ * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return low + (high - low) * static_cast<double>(state_ >> 11) / 9007199254740992.0;
  }

 private:
  std::uint64_t state_ = 1;
};

struct Packing {
  std::vector<Vector> positions, velocities, angular_velocities, semi_axes, forces, torques;
  std::vector<Quaternion> quaternions;
  std::vector<std::int32_t> types;

  std::size_t size() const { return positions.size(); }
};

// Ellipsoids about the points of a cubic lattice, in random poses, near enough to touch.
Packing random_packing()
{
  Packing p;
  Random random;
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 3; ++y)
      for (int z = 0; z < 3; ++z) {
        p.positions.push_back({{1.9 * x + random.between(-0.1, 0.1), 1.9 * y + random.between(-0.1, 0.1),
                                1.9 * z + random.between(-0.1, 0.1)}});
        p.velocities.push_back({{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)}});
        p.angular_velocities.push_back({{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)}});
        p.semi_axes.push_back({{random.between(0.7, 1.2), random.between(0.7, 1.2), random.between(0.7, 1.2)}});
        p.quaternions.push_back({{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1),
                                  random.between(0.1, 1)}});
        p.types.push_back(1 + static_cast<std::int32_t>(p.types.size() % 2));
      }
  p.forces.assign(p.size(), Vector());
  p.torques.assign(p.size(), Vector());
  return p;
}

// Every pair whose bounding spheres come near each other, once.
std::vector<std::vector<std::int32_t>> near_pairs(const Packing &p)
{
  std::vector<std::vector<std::int32_t>> neighbours(p.size());
  for (std::size_t i = 0; i < p.size(); ++i)
    for (std::size_t j = i + 1; j < p.size(); ++j) {
      double squared = 0;
      for (int k = 0; k < 3; ++k) squared += std::pow(p.positions[j][k] - p.positions[i][k], 2);
      if (squared < 2.5 * 2.5) neighbours[i].push_back(static_cast<std::int32_t>(j));
    }
  return neighbours;
}

EllgranBody body(const Packing &p, std::size_t k)
{
  EllgranBody b = ELLGRAN_INIT(EllgranBody);
  for (int m = 0; m < 3; ++m) {
    b.position[m] = p.positions[k][m];
    b.velocity[m] = p.velocities[k][m];
    b.angular_velocity[m] = p.angular_velocities[k][m];
    b.semi_axes[m] = p.semi_axes[k][m];
  }
  for (int m = 0; m < 4; ++m) b.quaternion[m] = p.quaternions[k][m];
  b.mass = 1;
  b.particle_type = p.types[k];
  b.identifier = static_cast<std::int64_t>(k) + 1;
  return b;
}

double largest(const std::vector<Vector> &a)
{
  double most = 0;
  for (const Vector &v : a) most = std::fmax(most, std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
  return most;
}

double difference(const std::vector<Vector> &a, const std::vector<Vector> &b)
{
  std::vector<Vector> d(a);
  for (std::size_t k = 0; k < d.size(); ++k)
    for (int m = 0; m < 3; ++m) d[k][m] -= b[k][m];
  return largest(d) / largest(b);
}

}  // namespace

int main()
{
  // Two materials; the pair 1 2 is mixed from them.
  const std::vector<std::vector<const char *>> decks = {
      {"nfd", "1e6", "0.3", "50", "50", "tangential", "tfd", "0.5"},
      {"nfd", "4e6", "0.2", "90", "60", "tangential", "tfd", "0.4"}};
  std::vector<EllgranLawParameters> parameters(4, ELLGRAN_INIT(EllgranLawParameters));
  const std::vector<std::uint8_t> is_set = {1, 0, 0, 1};
  for (std::size_t k = 0; k < 2; ++k)
    check(ellgran_law_parameters_parse(decks[k].size(), decks[k].data(), nullptr, &parameters[3 * k]));
  EllgranLaws *new_laws = nullptr;
  check(ellgran_laws_new(2, parameters.data(), is_set.data(), 0, &new_laws));
  const std::unique_ptr<EllgranLaws, Free> laws(new_laws);
  EllgranWorkspace *new_workspace = nullptr;
  check(ellgran_workspace_new(&new_workspace));
  const std::unique_ptr<EllgranWorkspace, Free> workspace(new_workspace);

  Packing p = random_packing();
  const std::vector<std::vector<std::int32_t>> neighbours = near_pairs(p);
  const std::size_t count = p.size();
  const std::size_t length = static_cast<std::size_t>(ellgran_laws_history_length(laws.get()));

  // Rows of the list, and beside each row its flags and histories: what an engine keeps anyway.
  std::vector<std::int32_t> central, neighbour_counts;
  std::vector<const std::int32_t *> rows;
  std::vector<std::vector<std::int32_t>> touching(count);
  std::vector<std::vector<double>> history(count);
  std::vector<std::int32_t *> touching_rows;
  std::vector<double *> history_rows;
  for (std::size_t i = 0; i < count; ++i) {
    central.push_back(static_cast<std::int32_t>(i));
    neighbour_counts.push_back(static_cast<std::int32_t>(neighbours[i].size()));
    rows.push_back(neighbours[i].data());
    touching[i].assign(neighbours[i].size(), 0);
    history[i].assign(neighbours[i].size() * length, 0.0);
    touching_rows.push_back(touching[i].data());
    history_rows.push_back(history[i].data());
  }
  std::vector<std::vector<std::int32_t>> touching_alone(touching);
  std::vector<std::vector<double>> history_alone(history);

  EllgranParticles particles = ELLGRAN_INIT(EllgranParticles);
  particles.owned_count = count;
  particles.count = count;
  particles.positions = p.positions.data()->data();
  particles.velocities = p.velocities.data()->data();
  particles.angular_velocities = p.angular_velocities.data()->data();
  particles.types = p.types.data();
  particles.semi_axes = p.semi_axes.data()->data();
  particles.semi_axes_stride = sizeof(Vector);
  particles.quaternions = p.quaternions.data()->data();
  particles.quaternions_stride = sizeof(Quaternion);
  particles.forces = p.forces.data()->data();
  particles.torques = p.torques.data()->data();

  EllgranNeighbourList list = ELLGRAN_INIT(EllgranNeighbourList);
  list.count = count;
  list.central = central.data();
  list.neighbour_counts = neighbour_counts.data();
  list.neighbours = rows.data();
  list.index_mask = -1;
  list.touching = touching_rows.data();
  list.history = history_rows.data();
  list.newton = 1;
  list.record_contacts = 1;

  EllgranStep step = ELLGRAN_INIT(EllgranStep);
  step.time_step = 1e-3;
  step.advance_history = 1;
  EllgranTallies tallies = ELLGRAN_INIT(EllgranTallies);
  double apart = 0;
  for (int n = 0; n < 20; ++n) {
    list.unchanged = n > 0;
    for (std::size_t k = 0; k < count; ++k)
      for (int m = 0; m < 3; ++m) p.positions[k][m] += step.time_step * p.velocities[k][m];
    p.forces.assign(count, Vector());
    p.torques.assign(count, Vector());
    check(ellgran_compute_pairs(laws.get(), workspace.get(), &particles, &list, &step, &tallies));

    std::vector<Vector> forces(count), torques(count);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t m = 0; m < neighbours[i].size(); ++m) {
        const std::size_t j = static_cast<std::size_t>(neighbours[i][m]);
        const EllgranBody body_i = body(p, i), body_j = body(p, j);
        EllgranContactForce contact = ELLGRAN_INIT(EllgranContactForce);
        check(ellgran_contact(laws.get(), &body_i, &body_j, &step, &touching_alone[i][m],
                              &history_alone[i][m * length], nullptr, &contact));
        for (int a = 0; a < 3; ++a) {
          forces[i][a] -= contact.force[a];
          forces[j][a] += contact.force[a];
          torques[i][a] += contact.torque_i[a];
          torques[j][a] += contact.torque_j[a];
        }
      }
    apart = std::fmax(apart, std::fmax(difference(p.forces, forces), difference(p.torques, torques)));
  }

  // The contacts of the last step one by one: their energies are those of the tallies.
  EllgranContactForce contact = ELLGRAN_INIT(EllgranContactForce);
  double energy = 0;
  for (std::size_t k = 0; k < ellgran_recorded_count(workspace.get()); ++k) {
    check(ellgran_recorded_contact(workspace.get(), k, nullptr, nullptr, &contact));
    energy += contact.elastic_energy;
  }

  std::printf("pairs listed:   %lld\n", static_cast<long long>(tallies.pair_count));
  std::printf("contacts:       %.0f\n", tallies.touching_count);
  std::printf("elastic energy: %.4g\n", tallies.normal_elastic_energy + tallies.tangential_elastic_energy);
  std::printf("largest force:  %.4g\n", largest(p.forces));
  if (!(apart <= 1e-12)) {
    std::fprintf(stderr, "wrong: the two ways differ by %g of the largest force or torque\n", apart);
    return EXIT_FAILURE;
  }
  if (!(std::fabs(energy - tallies.normal_elastic_energy) <= 1e-12 * energy)) {
    std::fprintf(stderr, "wrong: the recorded contacts hold an energy of %g\n", energy);
    return EXIT_FAILURE;
  }
  std::printf("the neighbour list and single contacts agree\n");
  return EXIT_SUCCESS;
}
