#include "core/experiment/experiment.h"

#include <iterator>

#include "core/arithmetic/digest.h"

namespace creep {
namespace {

/// Adds named values: the length and bytes of the name come first, so that no two experiments give the same
/// sequence of bytes by chance.
class FieldDigest {
 public:
  void tag(std::string_view name) {
    digest_.add(static_cast<std::uint64_t>(name.size()));
    digest_.add(name);
  }
  void add(std::string_view name, double value) {
    tag(name);
    digest_.add(value);
  }
  void add(std::string_view name, std::int64_t value) {
    tag(name);
    digest_.add(static_cast<std::uint64_t>(value));
  }
  template <typename Number>
  void add(std::string_view name, const std::optional<Number>& value) {
    if (value) add(name, *value);
  }
  std::string hex() const { return digest_.hex(); }

 private:
  Digest digest_;
};

void add_specimen(FieldDigest& digest, const SpecimenSpec& specimen) {
  digest.add("particles", specimen.particles);
  digest.add("side", specimen.side);
  if (const auto* lognormal = std::get_if<LognormalGrading>(&specimen.grading)) {
    digest.add("median_diameter", lognormal->median_diameter);
    digest.add("log_standard_deviation", lognormal->log_standard_deviation);
    digest.add("min_diameter", lognormal->min_diameter);
    digest.add("max_diameter", lognormal->max_diameter);
  } else {
    for (const GradingPoint& point : std::get<GradingPoints>(specimen.grading).points) {
      digest.add("diameter", point.diameter);
      digest.add("passing", point.passing);
    }
  }
  digest.add("void_ratio", specimen.void_ratio);
  digest.add("isotropic_stress", specimen.isotropic_stress);
  digest.add("seed", static_cast<std::int64_t>(specimen.seed));
}

// The name of a preset is left out: its values are what acts.
void add_material(FieldDigest& digest, const Material& material) {
  digest.add("shear_modulus", material.shear_modulus);
  digest.add("poisson_ratio", material.poisson_ratio);
  digest.add("friction", material.friction);
  digest.add("density", material.density);
  digest.add("roughness", material.roughness);
  digest.add("roughness_n1", material.roughness_n1);
  digest.add("roughness_n2", material.roughness_n2);
  digest.add("wall_stiffness_factor", material.wall_stiffness_factor);
  if (material.wall_friction > 0.0) digest.add("wall_friction", material.wall_friction);
  if (material.free_rotation) digest.tag("free_rotation");
  digest.add("limit_stress", material.limit_stress);
  digest.add("reference_diameter", material.reference_diameter);
  digest.add("size_exponent", material.size_exponent);
  digest.add("strength_variation", material.strength_variation);
  digest.add("strength_floor", material.strength_floor);
  digest.add("comminution_limit", material.comminution_limit);
  digest.add("split_layout", static_cast<std::int64_t>(material.split_layout));
  digest.add("crack_velocity", material.crack_velocity);
  digest.add("corrosion_index", material.corrosion_index);
  digest.add("grading_index_max_diameter", material.grading_index_max_diameter);
  digest.add("grading_index_min_diameter", material.grading_index_min_diameter);
  digest.add("fractal_dimension", material.fractal_dimension);
}

void add_program(FieldDigest& digest, const std::vector<Stage>& program) {
  for (const Stage& stage : program) {
    digest.tag(stage_name(stage));
    if (const Target* until = target_of(stage)) digest.add(measure_name(until->measure), until->value);
    if (const auto duration = duration_of(stage)) digest.add("duration", *duration);
    if (const auto* creep = std::get_if<CreepStage>(&stage)) {
      digest.add("axial_stress", creep->axial_stress);
      digest.add("deviatoric_stress", creep->deviatoric_stress);
    } else if (const auto* triaxial = std::get_if<TriaxialStage>(&stage)) {
      digest.add("radial_stress", triaxial->radial_stress);
      digest.add("axial_velocity", triaxial->axial_velocity);
    }
    if (const std::optional<Keep>& keep = keep_of(stage)) {
      digest.tag("keep");
      digest.add(measure_name(keep->measure), keep->step);
    }
  }
}

// The name of a fidelity is left out like that of a preset; the skin changes no bit of a result.
void add_numerics(FieldDigest& digest, const Numerics& numerics) {
  digest.add("minimum_cycles", numerics.minimum_cycles);
  digest.add("time_step_safety", numerics.time_step_safety);
  digest.add("breakages_per_ageing", numerics.breakages_per_ageing);
  // The paper's fraction is left out, and one that a count or the adaptive scheme overrides: hashes made
  // before it was a key stay valid.
  if (!numerics.breakages_per_ageing && numerics.breakage_fraction != kPaperBreakageFraction) {
    digest.add("breakage_fraction", numerics.breakage_fraction);
  }
  digest.add("ageing_error_tolerance", numerics.ageing_error_tolerance);
  digest.add("drift_tolerance", numerics.drift_tolerance);
  digest.add("inertial_number_limit", numerics.inertial_number_limit);
  digest.add("settle_tolerance", numerics.settle_tolerance);
  digest.add("unbalanced_tolerance", numerics.unbalanced_tolerance);
  digest.add("local_damping", numerics.local_damping);
  digest.add("inertia_scaling", static_cast<std::int64_t>(numerics.inertia_scaling));
  digest.add("failure_check_interval", numerics.failure_check_interval);
  digest.add("loading_velocity", numerics.loading_velocity);
}

}  // namespace

std::string_view measure_name(Target::Measure measure) {
  switch (measure) {
    case Target::Measure::kAxialStress:
      return "axial_stress";
    case Target::Measure::kMeanStress:
      return "mean_stress";
    case Target::Measure::kDeviatoricStress:
      return "deviatoric_stress";
    case Target::Measure::kStressRatio:
      return "stress_ratio";
    case Target::Measure::kAxialStrain:
      return "axial_strain";
    case Target::Measure::kDeviatoricStrain:
      return "deviatoric_strain";
  }
  return "";
}

std::string_view stage_name(const Stage& stage) {
  constexpr std::string_view kNames[] = {"oedometric", "isotropic", "triaxial",
                                         "unload",     "creep",     "relaxation"};
  static_assert(std::size(kNames) == std::variant_size_v<Stage>);
  return kNames[stage.index()];
}

const Target* target_of(const Stage& stage) {
  return std::visit(
      [](const auto& one) -> const Target* {
        if constexpr (requires { one.until; }) {
          return &one.until;
        } else {
          return nullptr;
        }
      },
      stage);
}

std::optional<double> duration_of(const Stage& stage) {
  return std::visit(
      [](const auto& one) -> std::optional<double> {
        if constexpr (requires { one.duration; }) {
          return one.duration;
        } else {
          return std::nullopt;
        }
      },
      stage);
}

const std::optional<Keep>& keep_of(const Stage& stage) {
  return std::visit([](const auto& one) -> const std::optional<Keep>& { return one.keep; }, stage);
}

std::string experiment_hash(const Experiment& experiment) {
  FieldDigest digest;
  if (experiment.start) {
    digest.tag("start");
    digest.tag(experiment.start->job);
    digest.tag(experiment.start->checkpoint);
  }
  add_specimen(digest, experiment.specimen);
  add_material(digest, experiment.material);
  add_program(digest, experiment.program);
  add_numerics(digest, experiment.numerics);
  return digest.hex();
}

std::string specimen_hash(const Experiment& experiment) {
  FieldDigest digest;
  add_specimen(digest, experiment.specimen);
  const Material& material = experiment.material;
  digest.add("density", material.density);
  digest.add("limit_stress", material.limit_stress);
  digest.add("reference_diameter", material.reference_diameter);
  digest.add("size_exponent", material.size_exponent);
  digest.add("strength_variation", material.strength_variation);
  digest.add("strength_floor", material.strength_floor);
  digest.add("comminution_limit", material.comminution_limit);
  // Inertia is scaled after packing, so it is not built in; its place is kept, and with it the hash of the
  // checkpoints that are there.
  digest.add("inertia_scaling", std::int64_t{0});
  return digest.hex();
}

}  // namespace creep
