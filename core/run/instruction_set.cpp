#include "core/run/instruction_set.h"

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "core/arithmetic/check.h"
#include "core/arithmetic/digest.h"
#include "core/arithmetic/elementary.h"
#include "core/dem/packing.h"
#include "core/dem/splitter.h"
#include "core/run/run.h"
#include "core/run/state.h"

namespace creep {

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
  // A few dozen weak grains crushed between platens: every kernel, the search, splits and cracks take part.
  Experiment experiment;
  experiment.specimen.particles = 60;
  experiment.specimen.seed = 7;
  experiment.material.limit_stress = 1e9;
  experiment.numerics.loading_velocity = 20.0;
  Dynamics dynamics(experiment, **kernels, {});
  RunState state;
  state.specimen = scatter(experiment);
  state.specimen.friction = experiment.material.friction;
  dynamics.assess(state.specimen);
  dynamics.let_fail(true);
  WallControl control{};
  for (AxisControl& axis : control)
    axis = {AxisControl::Mode::kServo, 5e6, experiment.numerics.loading_velocity};
  constexpr int kCycles = 1500;
  for (int cycle = 0; cycle < kCycles; ++cycle) {
    split(state.specimen, experiment, dynamics, dynamics.cycle(state.specimen, control).failures);
  }
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
