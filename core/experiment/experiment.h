// What was asked: an immutable, validated, SI description of one numerical experiment.
//
// The TOML reader (experiment_toml.h) is the only maker of an Experiment outside tests. Nothing here changes
// during a run. Defaults are the model's (Lei, Arroyo, Ciantia & Zhang, Table 1 and section 2) or, where the
// paper is silent, the documented open readings.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace creep {

/// Lognormal by mass, cut at both ends.
struct LognormalGrading {
  double median_diameter = 0.21e-3;           ///< d50 [m]
  double log_standard_deviation = 0.2770474;  ///< of ln d [-]; ln(1.53)/1.535
  double min_diameter = 0.1e-3;               ///< lower cut [m]
  double max_diameter = 0.4e-3;               ///< upper cut [m]
};

/// One point of a grading curve: `passing` is the mass fraction finer than `diameter` [m].
struct GradingPoint {
  double diameter = 0.0;
  double passing = 0.0;
};

/// Piecewise linear in ln(diameter); passing rises from 0 to 1.
struct GradingPoints {
  std::vector<GradingPoint> points;
};

using Grading = std::variant<LognormalGrading, GradingPoints>;

struct SpecimenSpec {
  std::optional<std::int64_t> particles;  ///< exactly one of particles, side is given
  std::optional<double> side;             ///< edge of the cube [m]
  Grading grading = LognormalGrading{};
  double void_ratio = 0.65;         ///< target after packing [-]
  double isotropic_stress = 100e3;  ///< at which packing ends and strains are zero [Pa]
  std::uint64_t seed = 1;
};

enum class SplitLayout { kOctahedral, kCubic, kTetrahedral };

struct Material {
  std::string preset = "fontainebleau-ne34";
  // Contact (eqs 1-7)
  double shear_modulus = 32e9;  ///< G [Pa]
  double poisson_ratio = 0.19;  ///< nu [-]
  double friction = 0.275;      ///< mu, between grains [-]
  double density = 2650.0;      ///< of the grains [kg/m3]
  double roughness = 0.6e-6;    ///< S_q of the pair [m] (open reading: pair, not grain); 0 = smooth Hertz
  double roughness_n1 = 0.05;   ///< n1 [-] (eq 6)
  double roughness_n2 = 5.0;    ///< n2 [-] (eq 7)
  double wall_stiffness_factor =
      1.0;  ///< E' at walls over E' between grains; 2 = rigid walls (open reading) [-]
  // Strength (eqs 10-12)
  double limit_stress = 3.75e9;          ///< sigma_lim0 [Pa]
  double reference_diameter = 2e-3;      ///< d0 [m] (open reading)
  double size_exponent = 0.25;           ///< k of (d/d0)^-k [-] (open reading: 3/m_p)
  double strength_variation = 0.38;      ///< var [-]
  double strength_floor = 0.05;          ///< least value of 1 + var X [-] (open reading)
  double comminution_limit = 0.1155e-3;  ///< d_c: smaller particles never fail [m]
  SplitLayout split_layout = SplitLayout::kOctahedral;
  // Cracks (eqs 14-21)
  double crack_velocity = 0.1;    ///< v0 [m/s]
  double corrosion_index = 60.0;  ///< n [-]
  // Grading index (eq 13)
  double grading_index_max_diameter = 0.27e-3;  ///< d_max [m]
  double grading_index_min_diameter = 0.01e-3;  ///< d_min [m]
  double fractal_dimension = 2.6;               ///< beta [-]

  /// E = 2 G (1 + nu) [Pa].
  double young_modulus() const { return 2.0 * shear_modulus * (1.0 + poisson_ratio); }
  /// E' of two equal grains, eq 4 [Pa].
  double reduced_modulus() const { return 0.5 * young_modulus() / (1.0 - poisson_ratio * poisson_ratio); }
  /// kt / kn = 2 (1 - nu) / (2 - nu) [-].
  double tangential_ratio() const { return 2.0 * (1.0 - poisson_ratio) / (2.0 - poisson_ratio); }
};

/// Top and bottom move at `loading_velocity` until the axial stress is reached; the sides are fixed.
struct OedometricStage {
  double axial_stress = 0.0;  ///< target [Pa]
};

/// Holds the axial stress (default: the one reached) for `duration` of creep_time: dynamic stages and ageing
/// in turn.
struct CreepStage {
  double duration = 0.0;               ///< of creep_time [s]
  std::optional<double> axial_stress;  ///< [Pa]
};

using Stage = std::variant<OedometricStage, CreepStage>;

/// "oedometric", "creep": the word of the job file.
std::string_view stage_name(const Stage& stage);

enum class InertiaScaling { kNone, kFragments, kAll };

struct Numerics {
  std::string fidelity = "paper";
  std::int64_t minimum_cycles = 150000;              ///< of a dynamic stage
  double time_step_safety = 0.7;                     ///< on sqrt2 min sqrt(m/lambda_max) [-]
  std::optional<std::int64_t> breakages_per_ageing;  ///< n_age; default max(1, round(0.0026 x initial count))
  double settle_tolerance = 0.005;                   ///< on |stress/target - 1| [-]
  double unbalanced_tolerance = 1e-4;                ///< on the unbalanced force ratio [-]
  double local_damping = 0.7;                        ///< alpha [-]
  InertiaScaling inertia_scaling = InertiaScaling::kNone;
  std::int64_t failure_check_interval = 1;  ///< cycles between checks of immediate failure
  double loading_velocity = 0.1;  ///< closing speed of the pair of platens, and its cap under servo [m/s]
  std::optional<double> skin;     ///< of the neighbour list [m]; default 0.01 d50. Never changes a result
};

struct Output {
  bool snapshots_per_decade = false;  ///< a .vtp per decade of age
};

struct Experiment {
  std::string name;  ///< optional label, "" if none; not part of the physics
  SpecimenSpec specimen;
  Material material;
  std::vector<Stage> program;  ///< at least one stage
  Numerics numerics;
  Output output;
};

/// SHA-256 (64 hex digits) over every field that can change a result; name, skin and output do not count.
std::string experiment_hash(const Experiment& experiment);

/// Median diameter by mass, d50 [m].
double median_diameter(const Grading& grading);

}  // namespace creep
