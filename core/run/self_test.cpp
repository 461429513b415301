#include "core/run/self_test.h"

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "core/arithmetic/check.h"
#include "core/arithmetic/digest.h"
#include "core/arithmetic/elementary.h"
#include "core/dem/dynamics.h"
#include "core/dem/particle_birth.h"
#include "core/dem/splitter.h"
#include "core/state/state.h"

namespace creep {
namespace {

constexpr int kGrainsOnEdge = 3;
constexpr int kGrains = kGrainsOnEdge * kGrainsOnEdge * kGrainsOnEdge;

/// A cube of weak grains that touch, no two alike, with a little motion: crushed between platens, every
/// kernel, the search, splits and cracks take part.
Specimen touching_grains(const Experiment& experiment) {
  constexpr double kRadius = 0.1e-3;
  constexpr double kSpacing = 1.998 * kRadius;
  Specimen specimen;
  for (std::size_t axis = 0; axis < 3; ++axis)
    specimen.walls.position[2 * axis + 1] = kGrainsOnEdge * kSpacing;
  for (int grain = 0; grain < kGrains; ++grain) {
    Birth birth;
    birth.id = birth.parent = specimen.next_id++;
    birth.radius = kRadius * (1.0 - 0.0005 * (grain % 7));
    const int place[3] = {grain % kGrainsOnEdge, grain / kGrainsOnEdge % kGrainsOnEdge,
                          grain / (kGrainsOnEdge * kGrainsOnEdge)};
    for (int axis = 0; axis < 3; ++axis) {
      birth.position[axis] = (place[axis] + 0.5) * kSpacing + 1e-7 * (grain * (axis + 3) % 11 - 5);
      birth.velocity[axis] = 0.01 * (grain * (axis + 2) % 13 - 6);
    }
    append_particle(specimen.particles, experiment, birth);
    specimen.initial_mass += specimen.particles.mass.back();
  }
  specimen.friction = experiment.material.friction;
  return specimen;
}

}  // namespace

absl::StatusOr<const Kernels*> kernels_for(const std::string& instruction_set) {
  if (instruction_set == "portable") return &portable_kernels();
  if (instruction_set.empty() || instruction_set == "avx512") {
    if (avx512_kernels() != nullptr) return avx512_kernels();
  }
  if (instruction_set.empty() || instruction_set == "avx2") {
    if (avx2_kernels() != nullptr) return avx2_kernels();
  }
  if (instruction_set.empty()) return &portable_kernels();
  if (instruction_set != "avx2" && instruction_set != "avx512") {
    return absl::InvalidArgumentError(
        absl::StrCat("unknown instruction set \"", instruction_set, "\": portable, avx2 or avx512"));
  }
  return absl::InvalidArgumentError(absl::StrCat("this processor does not have ", instruction_set));
}

absl::StatusOr<std::string> choose_instruction_set(const std::string& wish) {
  const absl::StatusOr<const Kernels*> kernels = kernels_for(wish);
  if (!kernels.ok()) return kernels.status();
  return std::string((*kernels)->name);
}

std::string arithmetic_id(const std::string& instruction_set) {
  const absl::StatusOr<const Kernels*> kernels = kernels_for(instruction_set);
  CREEP_CHECK(kernels.ok(), "the instruction set was not chosen by choose_instruction_set");
  Experiment experiment;
  experiment.specimen.particles = kGrains;
  experiment.specimen.seed = 7;
  experiment.material.limit_stress = 1.2e9;
  experiment.numerics.loading_velocity = 1.0;
  Dynamics dynamics(experiment, **kernels, {});
  RunState state;
  state.specimen = touching_grains(experiment);
  dynamics.assess(state.specimen);
  dynamics.let_fail(true);
  WallControl control{};
  for (AxisControl& axis : control)
    axis = {AxisControl::Mode::kServo, 20e6, experiment.numerics.loading_velocity};
  constexpr int kCycles = 400;
  for (int cycle = 0; cycle < kCycles; ++cycle) {
    const CycleResult result = dynamics.cycle(state.specimen, control);
    CREEP_CHECK(result.finite, "the self-test has left the numbers: it would tell nothing");
    split(state.specimen, experiment, dynamics, result.failures);
  }
  CREEP_CHECK(state.specimen.broken_total > 0, "nothing breaks in the self-test");
  Digest digest;
  digest.add(digest_of(state));
  for (int k = 1; k < 50; ++k) {
    digest.add(elementary::exp(0.37 * k));
    digest.add(elementary::log(0.37 * k));
    digest.add(elementary::pow(0.02 * k, 60.5));
  }
  return digest.hex().substr(0, 16);
}

}  // namespace creep
