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
      1.0;                     ///< E' at walls over E' between grains; 2 = rigid walls (open reading) [-]
  double wall_friction = 0.0;  ///< mu, between a grain and a wall, after packing [-]
  bool free_rotation = false;  ///< particles may turn; the paper blocks their rotation
  // Strength (eqs 10-12)
  double limit_stress = 3.75e9;          ///< sigma_lim0 [Pa]
  double reference_diameter = 2e-3;      ///< d0 [m] (open reading)
  double size_exponent = 0.25;           ///< k of (d/d0)^-k [-] (open reading: 3/m_p)
  double strength_variation = 0.38;      ///< var [-]
  double strength_floor = 0.05;          ///< least value of 1 + var X [-] (open reading)
  double comminution_limit = 0.1155e-3;  ///< d_c: smaller particles never fail [m]; infinite: none does
  SplitLayout split_layout = SplitLayout::kOctahedral;
  // Cracks (eqs 14-21)
  double crack_velocity = 0.1;    ///< v0 [m/s]; 0: cracks do not grow
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

/// The value of a measure at which a loading stage ends.
struct Target {
  enum class Measure {
    kAxialStress,       ///< s_a [Pa]
    kMeanStress,        ///< p = (s_a + 2 s_r) / 3 [Pa]
    kDeviatoricStress,  ///< q = s_a - s_r [Pa]
    kStressRatio,       ///< q / p [-]
    kAxialStrain,       ///< engineering [-]
    kDeviatoricStrain,  ///< 2/3 (axial - radial strain) [-]
  };
  double value = 0.0;
  Measure measure = Measure::kAxialStress;
};

/// Named checkpoints of a stage: one at its end and, with `step`, one at each multiple of it.
struct Keep {
  double step = 0.0;  ///< of the measure; 0: at the end only
  Target::Measure measure = Target::Measure::kAxialStrain;
};

/// Top and bottom close at up to `loading_velocity` until an axial stress or strain; the sides are fixed.
struct OedometricStage {
  Target until;
  std::optional<Keep> keep = {};
};

/// All walls bring the stress to a mean stress, alike on all sides, and the specimen to rest there.
struct IsotropicStage {
  Target until{0.0, Target::Measure::kMeanStress};
  std::optional<Keep> keep = {};
};

/// Top and bottom close at a constant velocity; the sides hold their stress.
struct TriaxialStage {
  Target until;
  std::optional<double> radial_stress = {};  ///< [Pa]; default: the one held before, else the one reached
  double axial_velocity = 0.01;              ///< closing speed of the pair of platens [m/s]
  std::optional<Keep> keep = {};
};

/// Back to a lower axial or deviatoric stress, with the sides as they were (fixed, or holding their stress),
/// or to a lower mean stress on all sides.
struct UnloadStage {
  Target until;
  std::optional<Keep> keep = {};
};

/// Holds a stress for `duration` of creep_time: dynamic stages and ageing in turn. Sides stay fixed after an
/// oedometric stage, else they hold their stress.
struct CreepStage {
  double duration = 0.0;                         ///< of creep_time [s]
  std::optional<double> axial_stress;            ///< [Pa]; default: the one reached
  std::optional<double> deviatoric_stress = {};  ///< instead of axial_stress [Pa]
  std::optional<Keep> keep = {};
};

/// Holds the axial strain for `duration` of creep_time while the stress decays.
struct RelaxationStage {
  double duration = 0.0;  ///< of creep_time [s]
  std::optional<Keep> keep = {};
};

using Stage =
    std::variant<OedometricStage, IsotropicStage, TriaxialStage, UnloadStage, CreepStage, RelaxationStage>;

/// "oedometric", "creep", ...: the word of the job file.
std::string_view stage_name(const Stage& stage);

/// "axial_stress", ...: the word of the job file.
std::string_view measure_name(Target::Measure measure);

/// What a loading stage goes to; none for a hold (creep, relaxation).
const Target* target_of(const Stage& stage);
/// Of a hold [s]; none for a loading stage.
std::optional<double> duration_of(const Stage& stage);
const std::optional<Keep>& keep_of(const Stage& stage);

enum class InertiaScaling { kNone, kFragments, kAll };

/// 30 of 11 500 particles break in an ageing of the paper (section 4.1).
inline constexpr double kPaperBreakageFraction = 0.0026;

struct Numerics {
  std::string fidelity = "paper";
  std::int64_t minimum_cycles = 150000;               ///< of a dynamic stage
  double time_step_safety = 0.7;                      ///< on sqrt2 min sqrt(m/lambda_max) [-]
  std::optional<std::int64_t> breakages_per_ageing;   ///< n_age; none: of the fraction below, at least 1
  double breakage_fraction = kPaperBreakageFraction;  ///< n_age over the initial count [-]
  /// If given, n_age follows from it instead: error of the strain of each decade of creep_time, relative to
  /// that strain, by which ageing under frozen forces may be wrong [-] (run/ageing.h).
  std::optional<double> ageing_error_tolerance;
  /// If given, a dynamic stage also waits for the failure times: largest change over a window of ln of the
  /// creep_time at which the next ageing would end [-] (run/ageing.h).
  std::optional<double> drift_tolerance;
  /// If given, the platens slow down in loading so that the inertial number stays below it [-].
  std::optional<double> inertial_number_limit;
  double settle_tolerance = 0.005;     ///< on |stress/target - 1| [-]
  double unbalanced_tolerance = 1e-4;  ///< on the unbalanced force ratio [-]
  double local_damping = 0.7;          ///< alpha [-]
  InertiaScaling inertia_scaling = InertiaScaling::kNone;
  std::int64_t failure_check_interval = 1;  ///< cycles between checks of immediate failure
  double loading_velocity = 0.1;  ///< closing speed of the pair of platens, and its cap under servo [m/s]
  std::optional<double> skin;     ///< of the neighbour list [m]; default 0.01 d50. Never changes a result
};

struct Output {
  bool snapshots_per_decade = false;  ///< a .vtp per decade of age
};

/// Another job's checkpoint, from which this one starts instead of packing. Whoever takes the job puts the
/// bytes beside it.
struct Start {
  std::string job;         ///< id of a job, or path of its folder
  std::string checkpoint;  ///< name of a kept one, or the number N of checkpoints/ck.N; "": the newest
};

struct Experiment {
  std::string name;  ///< optional label, "" if none; not part of the physics
  std::optional<Start> start;
  SpecimenSpec specimen;
  Material material;
  std::vector<Stage> program;  ///< at least one stage
  Numerics numerics;
  Output output;
};

/// SHA-256 (64 hex digits) over every field that can change a result; name, skin and output do not count.
std::string experiment_hash(const Experiment& experiment);

/// SHA-256 over what is built into a packed specimen: [specimen], the density and strength of its grains. The
/// same for all jobs that may start from one another's checkpoints.
std::string specimen_hash(const Experiment& experiment);

/// Median diameter by mass, d50 [m].
double median_diameter(const Grading& grading);

}  // namespace creep
