// creep-bench: particle-steps per second of the product's own cycle on a packing, as a user of another code
// would time it.
//
// The contact network is frozen by the small velocities, all checks of a job are on: contact stresses,
// immediate failure every cycle, cracks, energy sums, stable step. Walls stand still. Forces are those of the
// rough law unless
// --smooth is given. The step is held at 1e-8 s for parity with the scripts of other codes.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <string>
#include <thread>

#include "core/dem/dynamics.h"
#include "core/run/run.h"
#include "core/run/self_test.h"
#include "tests/bench/packing_file.h"

namespace {

struct Arguments {
  std::string packing;
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  bool smooth = false;
  long steps = 0;
  int rounds = 5;
  std::string instruction_set;
};

constexpr double kStep = 1e-8;      // s
constexpr double kVelocity = 5e-3;  // m/s

int bench(const Arguments& arguments) {
  creep::Experiment experiment;
  experiment.numerics.skin = 2e-6;
  if (arguments.smooth) experiment.material.roughness = 0.0;
  // So strong that nothing breaks: the checks run, the network stays.
  experiment.material.limit_stress *= 100.0;
  const auto kernels = creep::kernels_for(arguments.instruction_set);
  if (!kernels.ok()) {
    std::fprintf(stderr, "creep-bench: %s\n", std::string(kernels.status().message()).c_str());
    return 2;
  }
  auto specimen = creep::bench::read_packing(arguments.packing, experiment, kVelocity);
  if (!specimen.ok()) {
    std::fprintf(stderr, "creep-bench: %s\n", std::string(specimen.status().message()).c_str());
    return 5;
  }
  creep::Dynamics dynamics(experiment, **kernels, {arguments.threads, 0});
  dynamics.let_fail(true);
  dynamics.assess(*specimen);
  const auto advance = [&](long steps) {
    for (long step = 0; step < steps; ++step) {
      specimen->time_step = kStep;
      dynamics.cycle(*specimen, {});
    }
  };
  const auto particles = static_cast<double>(specimen->particles.size());
  const long steps = arguments.steps > 0 ? arguments.steps : static_cast<long>(2e7 / particles) + 1;
  advance(steps / 10 + 1);
  const std::int64_t searches = dynamics.searches();
  std::vector<double> rates;
  for (int round = 0; round < arguments.rounds; ++round) {
    const auto begin = std::chrono::steady_clock::now();
    advance(steps);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    rates.push_back(particles * static_cast<double>(steps) / seconds);
  }
  std::sort(rates.begin(), rates.end());
  std::printf(
      "%s law, %s kernels, %d threads: %.0f particles, %zu listed pairs, %ld steps x %d rounds, %ld "
      "searches\n",
      arguments.smooth ? "smooth" : "rough", (*kernels)->name, arguments.threads, particles,
      specimen->contacts.count, steps, arguments.rounds, static_cast<long>(dynamics.searches() - searches));
  std::printf("particle-steps per second: least %.3e, most %.3e, median %.3e\n", rates.front(), rates.back(),
              rates[rates.size() / 2]);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Times the cycle of creepd on a packing.", "creep-bench");
  app.add_option("--packing", arguments.packing,
                 "File of spheres: x y z radius in metres, box in the first line")
      ->required();
  app.add_option("--threads", arguments.threads, "Threads")->check(CLI::Range(1, 256));
  app.add_option("--steps", arguments.steps, "Steps a round (default: 2e7 particle-steps)")
      ->check(CLI::PositiveNumber);
  app.add_option("--rounds", arguments.rounds, "Timed rounds")->check(CLI::Range(1, 1000));
  app.add_option("--instruction-set", arguments.instruction_set,
                 "portable, avx2 or avx512 (default: the widest)")
      ->envname("CREEP_ISA");
  app.add_flag("--smooth", arguments.smooth, "Smooth Hertz contact, as the peers have");
  app.footer("Example: creep-bench --packing tests/bench/packing_1500.txt --threads 2");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : 2;
  }
  return bench(arguments);
}
