// settle_packing PACKING STRESS SERVO REST THREADS > SETTLED: smooth spheres without friction come to rest at
// a mean stress [Pa].
//
// SERVO cycles between walls held at the stress, then at most REST cycles between walls that stand still, in
// which the rest of the motion dies out. For the start of comparisons with other programs, and for copies of
// a packing side by side (tile_packing.py): where two copies meet their grains press and slide until they
// have found their places, which costs rebuilds of the neighbour list and cycles that no packing of one piece
// has.
#include <cstdio>
#include <cstdlib>

#include "core/dem/dynamics.h"
#include "core/run/self_test.h"
#include "tests/bench/packing_file.h"

int main(int count, char** words) {
  if (count != 6) {
    std::fprintf(stderr, "usage: settle_packing PACKING STRESS SERVO REST THREADS\n");
    return 2;
  }
  creep::Experiment experiment;
  experiment.material.roughness = 0.0;
  experiment.material.friction = 0.0;
  experiment.material.comminution_limit = 1.0;  // nothing breaks
  const double stress = std::atof(words[2]);
  auto specimen = creep::bench::read_packing(words[1], experiment, 0.0);
  const auto kernels = creep::kernels_for("");
  if (!specimen.ok() || !kernels.ok()) {
    std::fprintf(stderr, "settle_packing: %s\n", std::string(specimen.status().message()).c_str());
    return 5;
  }
  creep::Dynamics dynamics(experiment, **kernels, {.threads = std::atoi(words[5])});
  dynamics.assess(*specimen);
  creep::WallControl servo{};
  for (creep::AxisControl& axis : servo) axis = {creep::AxisControl::Mode::kServo, stress, 0.1};
  for (long left = std::atol(words[3]); left > 0; --left) dynamics.cycle(*specimen, servo);
  // Not before the last motion of the walls has died out.
  const long rest = std::atol(words[4]);
  for (long cycle = 0; cycle < rest && !(cycle > 10000 && specimen->unbalanced_force_ratio < 1e-8); ++cycle) {
    dynamics.cycle(*specimen, creep::WallControl{});
  }
  const auto& at = specimen->walls.position;
  std::printf(
      "# x y z r (metres). box %.17g %.17g %.17g %.17g %.17g %.17g ; smooth, frictionless, %g Pa, unbalanced "
      "%.2g\n",
      at[0], at[2], at[4], at[1], at[3], at[5], stress, specimen->unbalanced_force_ratio);
  for (const creep::Body& body : specimen->particles.body) {
    std::printf("%.17g %.17g %.17g %.17g\n", body.x, body.y, body.z, body.radius);
  }
  return 0;
}
