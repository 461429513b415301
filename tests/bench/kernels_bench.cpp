// Times the parts of a run one by one, on a packing given in CREEP_PACKING (default: the 1 500 spheres beside
// this file).
//
// What a part costs beside a cycle tells how often it may be done. creep-bench times whole cycles against
// other codes.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <string>

#include "core/arithmetic/check.h"
#include "core/dem/dynamics.h"
#include "core/run/ageing.h"
#include "core/run/self_test.h"
#include "core/state/checkpoint.h"
#include "tests/bench/packing_file.h"

namespace {

constexpr double kStep = 1e-8;      // s
constexpr double kVelocity = 5e-3;  // m/s

creep::Experiment unbreakable() {
  creep::Experiment experiment;
  experiment.numerics.skin = 2e-6;
  experiment.material.limit_stress *= 100.0;
  return experiment;
}

/// A packing under way, its list made, its forces computed.
struct Scene {
  explicit Scene(const std::string& instruction_set, int threads = 1)
      : dynamics(experiment, **creep::kernels_for(instruction_set), {threads, 0}) {
    const char* const given = std::getenv("CREEP_PACKING");
    auto read =
        creep::bench::read_packing(given != nullptr ? given : CREEP_DEFAULT_PACKING, experiment, kVelocity);
    CREEP_CHECK(read.ok(), "the packing cannot be read");
    specimen = *std::move(read);
    dynamics.let_fail(true);
    dynamics.assess(specimen);
    for (int i = 0; i < 100; ++i) cycle();
  }
  void cycle() {
    specimen.time_step = kStep;
    dynamics.cycle(specimen, {});
  }
  double particles() const { return static_cast<double>(specimen.particles.size()); }

  const creep::Experiment experiment = unbreakable();
  creep::Dynamics dynamics;
  creep::Specimen specimen;
};

void cycle(benchmark::State& state, const std::string& instruction_set) {
  if (!creep::kernels_for(instruction_set).ok()) return state.SkipWithError("not on this processor");
  Scene scene(instruction_set, static_cast<int>(state.range(0)));
  for (auto _ : state) scene.cycle();
  state.counters["particle_steps"] = benchmark::Counter(
      scene.particles(), benchmark::Counter::kIsIterationInvariantRate, benchmark::Counter::kIs1000);
}
BENCHMARK_CAPTURE(cycle, portable, "portable")->Arg(1)->UseRealTime();
BENCHMARK_CAPTURE(cycle, avx2, "avx2")->Arg(1)->UseRealTime();
BENCHMARK_CAPTURE(cycle, avx512, "avx512")->Arg(1)->Arg(2)->UseRealTime();

void search(benchmark::State& state) {
  Scene scene("");
  for (auto _ : state) {
    scene.specimen.contacts.valid = false;
    scene.dynamics.ensure_list(scene.specimen);
  }
}
BENCHMARK(search)->Unit(benchmark::kMicrosecond);

void assess(benchmark::State& state) {
  Scene scene("");
  for (auto _ : state) scene.dynamics.assess(scene.specimen);
}
BENCHMARK(assess)->Unit(benchmark::kMicrosecond);

void ageing_jump(benchmark::State& state) {
  const Scene scene("");
  creep::Experiment breakable;  // the stresses of the scene, the strength of the preset
  for (auto _ : state) {
    state.PauseTiming();
    creep::Specimen specimen = scene.specimen;
    state.ResumeTiming();
    benchmark::DoNotOptimize(creep::age(specimen, breakable.material, 4, 1e5));
  }
}
BENCHMARK(ageing_jump)->Unit(benchmark::kMicrosecond);

/// What the simulation waits for; writing to the disk comes after it.
void checkpoint_bytes(benchmark::State& state) {
  const Scene scene("");
  creep::RunState run;
  run.specimen = scene.specimen;
  std::size_t size = 0;
  for (auto _ : state) size = creep::write_checkpoint(run, {}).size();
  state.counters["bytes_per_particle"] = static_cast<double>(size) / scene.particles();
}
BENCHMARK(checkpoint_bytes)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
