// What a good job file means.
#include "core/experiment/experiment.h"

#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <string>

#include "core/experiment/experiment_toml.h"
#include "core/experiment/fidelity.h"
#include "core/experiment/job_text.h"
#include "core/experiment/numerics_text.h"
#include "core/experiment/stage_text.h"
#include "core/experiment/wording.h"

namespace creep {
namespace {

constexpr std::string_view kLeast =
    "[specimen]\n"
    "particles = 3000\n"
    "[[program]]\n"
    "stage = \"oedometric\"\n"
    "until = { axial_stress = \"21.7 MPa\" }\n";

Experiment parsed(const std::string& text) {
  const ParseResult result = parse_experiment(text);
  for (const Diagnostic& error : result.errors) ADD_FAILURE() << error.line << ": " << error.message;
  return result.experiment.value_or(Experiment{});
}

TEST(Experiment, the_least_job_file_gives_the_defaults) {
  const Experiment experiment = parsed(std::string(kLeast));
  EXPECT_EQ(experiment.specimen.particles, 3000);
  EXPECT_FALSE(experiment.specimen.side);
  EXPECT_EQ(experiment.specimen.void_ratio, 0.65);
  EXPECT_EQ(experiment.material.preset, "fontainebleau-ne34");
  EXPECT_EQ(experiment.material.size_exponent, 0.25);
  EXPECT_EQ(experiment.numerics.minimum_cycles, 150000);
  ASSERT_EQ(experiment.program.size(), 1U);
  EXPECT_EQ(std::get<OedometricStage>(experiment.program[0]).until.value, 21.7e6);
  EXPECT_EQ(stage_name(experiment.program[0]), "oedometric");
}

TEST(Experiment, every_key_arrives_in_si) {
  const Experiment experiment = parsed(R"(
name = "all keys"
[specimen]
side = "4 mm"
grading = { points = [["0.1 mm", 0], ["0.2 mm", 0.4], ["0.4 mm", 1.0]] }
void_ratio = 0.7
isotropic_stress = "50 kPa"
seed = 9
[material]
preset = "fontainebleau-ne34-literal"
shear_modulus = "30 GPa"
poisson_ratio = 0.2
friction = 0.3
density = "2.6 g/cm3"
roughness = "0 um"
roughness_n1 = 0.06
roughness_n2 = 6
wall_stiffness_factor = 2
wall_friction = 0.25
rotation = "free"
limit_stress = "4 GPa"
reference_diameter = "1.5 mm"
strength_variation = 0.4
strength_floor = 0.1
comminution_limit = "0.1 mm"
split_layout = "cubic"
crack_velocity = "1 mm/s"
corrosion_index = 50
grading_index_max_diameter = "0.3 mm"
grading_index_min_diameter = "20 um"
fractal_dimension = 2.5
[[program]]
stage = "oedometric"
until = { axial_stress = "1 MPa" }
[[program]]
stage = "creep"
duration = "10 min"
axial_stress = "2 MPa"
[numerics]
fidelity = "paper"
minimum_cycles = 4000
time_step_safety = 0.5
breakages_per_ageing = 3
settle_tolerance = 0.01
unbalanced_tolerance = 1e-3
local_damping = 0.6
inertia_scaling = "fragments"
failure_check_interval = 10
drift_tolerance = 0.02
inertial_number_limit = 1e-3
loading_velocity = "50 mm/s"
skin = "3 um"
[output]
snapshots = "per decade of age"
)");
  EXPECT_EQ(experiment.name, "all keys");
  const SpecimenSpec& specimen = experiment.specimen;
  EXPECT_FALSE(specimen.particles);
  EXPECT_EQ(specimen.side, 4e-3);
  const std::vector<GradingPoint>& points = std::get<GradingPoints>(specimen.grading).points;
  ASSERT_EQ(points.size(), 3U);
  EXPECT_EQ(points[1].diameter, 0.2e-3);
  EXPECT_EQ(points[1].passing, 0.4);
  EXPECT_EQ(specimen.void_ratio, 0.7);
  EXPECT_EQ(specimen.isotropic_stress, 50e3);
  EXPECT_EQ(specimen.seed, 9U);
  const Material& material = experiment.material;
  EXPECT_EQ(material.preset, "fontainebleau-ne34-literal");
  EXPECT_EQ(material.shear_modulus, 30e9);
  EXPECT_EQ(material.poisson_ratio, 0.2);
  EXPECT_EQ(material.friction, 0.3);
  EXPECT_EQ(material.density, 2600.0);
  EXPECT_EQ(material.roughness, 0.0);
  EXPECT_EQ(material.roughness_n1, 0.06);
  EXPECT_EQ(material.roughness_n2, 6.0);
  EXPECT_EQ(material.wall_stiffness_factor, 2.0);
  EXPECT_EQ(material.wall_friction, 0.25);
  EXPECT_TRUE(material.free_rotation);
  EXPECT_EQ(material.limit_stress, 4e9);
  EXPECT_EQ(material.reference_diameter, 1.5e-3);
  EXPECT_EQ(material.size_exponent, 1.0 / 12.0);  // from the preset
  EXPECT_EQ(material.strength_variation, 0.4);
  EXPECT_EQ(material.strength_floor, 0.1);
  EXPECT_EQ(material.comminution_limit, 0.1e-3);
  EXPECT_EQ(material.split_layout, SplitLayout::kCubic);
  EXPECT_EQ(material.crack_velocity, 1e-3);
  EXPECT_EQ(material.corrosion_index, 50.0);
  EXPECT_EQ(material.grading_index_max_diameter, 0.3e-3);
  EXPECT_EQ(material.grading_index_min_diameter, 20e-6);
  EXPECT_EQ(material.fractal_dimension, 2.5);
  ASSERT_EQ(experiment.program.size(), 2U);
  EXPECT_EQ(std::get<CreepStage>(experiment.program[1]).duration, 600.0);
  EXPECT_EQ(std::get<CreepStage>(experiment.program[1]).axial_stress, 2e6);
  const Numerics& numerics = experiment.numerics;
  EXPECT_EQ(numerics.minimum_cycles, 4000);
  EXPECT_EQ(numerics.time_step_safety, 0.5);
  EXPECT_EQ(numerics.breakages_per_ageing, 3);
  EXPECT_FALSE(numerics.ageing_error_tolerance);
  EXPECT_EQ(numerics.drift_tolerance, 0.02);
  EXPECT_EQ(numerics.inertial_number_limit, 1e-3);
  EXPECT_EQ(numerics.settle_tolerance, 0.01);
  EXPECT_EQ(numerics.unbalanced_tolerance, 1e-3);
  EXPECT_EQ(numerics.local_damping, 0.6);
  EXPECT_EQ(numerics.inertia_scaling, InertiaScaling::kFragments);
  EXPECT_EQ(numerics.failure_check_interval, 10);
  EXPECT_EQ(numerics.loading_velocity, 50e-3);
  EXPECT_EQ(numerics.skin, 3e-6);
  EXPECT_TRUE(experiment.output.snapshots_per_decade);
}

TEST(Experiment, every_stage_and_target_is_read) {
  const Experiment experiment = parsed(R"(
[specimen]
particles = 3000
[[program]]
stage = "isotropic"
until = { mean_stress = "10 MPa" }
keep = {}
[[program]]
stage = "triaxial"
until = { deviatoric_stress = "5 MPa" }
axial_velocity = "20 mm/s"
keep = { every_axial_strain = 0.005 }
[[program]]
stage = "creep"
q_ratio = 0.4
q_max = "22.6 MPa"
duration = "1 h"
[[program]]
stage = "relaxation"
duration = "1 d"
[[program]]
stage = "unload"
until = { deviatoric_stress = "1 MPa" }
[[program]]
stage = "triaxial"
radial_stress = "12 MPa"
until = { stress_ratio = 1.2 }
[[program]]
stage = "unload"
until = { mean_stress = "1 MPa" }
[[program]]
stage = "oedometric"
until = { axial_strain = 0.2 }
)");
  using Measure = Target::Measure;
  ASSERT_EQ(experiment.program.size(), 8U);
  const auto& isotropic = std::get<IsotropicStage>(experiment.program[0]);
  EXPECT_EQ(isotropic.until.value, 10e6);
  ASSERT_TRUE(isotropic.keep);
  EXPECT_EQ(isotropic.keep->step, 0.0);
  const auto& triaxial = std::get<TriaxialStage>(experiment.program[1]);
  EXPECT_EQ(triaxial.until.value, 5e6);
  EXPECT_EQ(triaxial.until.measure, Measure::kDeviatoricStress);
  EXPECT_EQ(triaxial.axial_velocity, 0.02);
  EXPECT_FALSE(triaxial.radial_stress);
  ASSERT_TRUE(triaxial.keep);
  EXPECT_EQ(triaxial.keep->step, 0.005);
  EXPECT_EQ(triaxial.keep->measure, Measure::kAxialStrain);
  const auto& creep = std::get<CreepStage>(experiment.program[2]);
  ASSERT_TRUE(creep.deviatoric_stress);
  EXPECT_DOUBLE_EQ(*creep.deviatoric_stress, 0.4 * 22.6e6);
  EXPECT_EQ(std::get<RelaxationStage>(experiment.program[3]).duration, 86400.0);
  EXPECT_EQ(std::get<UnloadStage>(experiment.program[4]).until.measure, Measure::kDeviatoricStress);
  EXPECT_EQ(std::get<TriaxialStage>(experiment.program[5]).radial_stress, 12e6);
  EXPECT_EQ(std::get<TriaxialStage>(experiment.program[5]).until.measure, Measure::kStressRatio);
  EXPECT_EQ(std::get<UnloadStage>(experiment.program[6]).until.measure, Measure::kMeanStress);
  EXPECT_EQ(std::get<OedometricStage>(experiment.program[7]).until.measure, Measure::kAxialStrain);
}

TEST(Experiment, a_job_that_starts_from_a_checkpoint_may_begin_with_any_stage_and_leave_out_the_specimen) {
  const Experiment experiment = parsed(
      "[start]\njob = \"ab12\"\ncheckpoint = \"02_triaxial_end\"\n"
      "[[program]]\nstage = \"creep\"\ndeviatoric_stress = \"5 MPa\"\nduration = \"1 d\"\n");
  ASSERT_TRUE(experiment.start);
  EXPECT_EQ(experiment.start->job, "ab12");
  EXPECT_EQ(experiment.start->checkpoint, "02_triaxial_end");
}

TEST(Experiment, where_a_job_starts_from_is_one_line_for_a_terminal) {
  const std::string creep = "[[program]]\nstage = \"creep\"\nduration = \"1 d\"\n";
  for (const char* start :
       {"job = \"a\\nb\"\n", "job = \"\\u001b[2J\"\n", "job = \"a\"\ncheckpoint = \"x\\ty\"\n"}) {
    const ParseResult result = parse_experiment(std::string("[start]\n") + start + creep);
    ASSERT_EQ(result.errors.size(), 1u) << start;
    EXPECT_NE(result.errors[0].message.find("must be one line of at most"), std::string::npos) << start;
  }
  EXPECT_TRUE(
      parse_experiment("[start]\njob = \"/a folder/with 'quotes' and \u00e9\"\n" + creep).errors.empty());
}

TEST(Experiment, crushing_and_cracks_can_be_left_out) {
  const Experiment experiment =
      parsed(std::string(kLeast) + "[material]\ncrushing = false\ncracks = false\n");
  EXPECT_EQ(experiment.material.comminution_limit, std::numeric_limits<double>::infinity());
  EXPECT_EQ(experiment.material.crack_velocity, 0.0);
}

TEST(JobText, overrides_change_their_keys_and_nothing_else) {
  const std::string text =
      "name = \"a \\\"b\\\" \\\\ c\" # a comment\n[specimen]\nparticles = 300\nvoid_ratio = 0.7\n"
      "grading = { points = [[\"0.1 mm\", 0], [\"0.4 mm\", 1.0]] }\n"
      "[[program]]\nstage = \"oedometric\"\nuntil.axial_stress = \"2 MPa\"\n";
  const auto unchanged = with_overrides(text, {});
  ASSERT_TRUE(unchanged.ok()) << unchanged.status();
  EXPECT_EQ(experiment_hash(parsed(*unchanged)), experiment_hash(parsed(text)));
  EXPECT_EQ(parsed(*unchanged).name, parsed(text).name);
  const auto changed = with_overrides(text, {{"numerics.minimum_cycles", "500"},
                                             {"numerics.loading_velocity", "0.2 m/s"},
                                             {"program.0.until.axial_stress", "\"3 MPa\""},
                                             {"specimen.void_ratio", "0.8"}});
  ASSERT_TRUE(changed.ok()) << changed.status();
  Experiment expected = parsed(text);
  expected.numerics.minimum_cycles = 500;
  expected.numerics.loading_velocity = 0.2;
  expected.specimen.void_ratio = 0.8;
  std::get<OedometricStage>(expected.program[0]).until.value = 3e6;
  EXPECT_EQ(experiment_hash(parsed(*changed)), experiment_hash(expected));
  const auto program =
      with_overrides(text, {{"program", "[{ stage = \"oedometric\", until.axial_strain = 0.1 }]"}});
  ASSERT_TRUE(program.ok()) << program.status();
  EXPECT_EQ(target_of(parsed(*program).program.at(0))->measure, Target::Measure::kAxialStrain);
}

TEST(JobText, a_key_without_a_place_is_an_error) {
  for (const std::string key : {"program.3.duration", "specimen.particles.x", "program.x", ""}) {
    EXPECT_FALSE(with_overrides(kLeast, {{key, "1"}}).ok()) << key;
  }
}

TEST(JobText, keys_are_taken_out_and_stages_cut) {
  const std::string text =
      "[specimen]\nparticles = 300\n[[program]]\nstage = \"isotropic\"\nuntil.mean_stress = \"1 MPa\"\n"
      "[[program]]\nstage = \"triaxial\"\nuntil = { q_ratio = 0.5, q_max = \"2 MPa\" }\n"
      "[[program]]\nstage = \"creep\"\nq_ratio = 0.5\nq_max = \"2 MPa\"\nduration = \"1 h\"\n";
  EXPECT_EQ(string_at(text, "program.1.until.q_max"), "2 MPa");
  for (const std::string none : {"program.0.until.q_max", "program.3.stage", "specimen.particles", "x.y", ""})
    EXPECT_EQ(string_at(text, none), std::nullopt) << none;

  const auto held = without_keys(text, {"program.2.q_ratio", "program.2.q_max", "program.9.x", "numerics.x"});
  ASSERT_TRUE(held.ok()) << held.status();
  EXPECT_EQ(std::get<CreepStage>(parsed(*held).program.at(2)).deviatoric_stress, std::nullopt);
  EXPECT_EQ(std::get<CreepStage>(parsed(text).program.at(2)).deviatoric_stress, 1e6);
  EXPECT_EQ(held->find("numerics"), std::string::npos);

  const auto loading = with_stages(text, 0, 2);
  ASSERT_TRUE(loading.ok()) << loading.status();
  ASSERT_EQ(parsed(*loading).program.size(), 2U);
  EXPECT_EQ(stage_name(parsed(*loading).program[1]), "triaxial");
  EXPECT_FALSE(with_stages(text, 2, 2).ok());
}

TEST(StageText, a_kept_checkpoint_is_named_by_its_stage_and_what_it_was_kept_at) {
  const TriaxialStage shear{.until = {}, .keep = Keep{0.05 * 22.6e6, Target::Measure::kDeviatoricStress}};
  EXPECT_EQ(kept_checkpoint_name(1, shear, 4), "02_triaxial_deviatoric_stress_4.52MPa");
  EXPECT_EQ(kept_checkpoint_name(1, shear, std::nullopt), "02_triaxial_end");
}

TEST(JobText, sections_that_are_left_out_are_those_of_the_source) {
  const auto text = with_sections_of(
      "[start]\njob = \"ab12\"\n[numerics]\nminimum_cycles = 77\n[[program]]\nstage = "
      "\"relaxation\"\nduration = \"1 d\"\n",
      std::string(kLeast) + "[numerics]\nminimum_cycles = 12\n[material]\nfriction = 0.5\n");
  ASSERT_TRUE(text.ok()) << text.status();
  const Experiment experiment = parsed(*text);
  EXPECT_EQ(experiment.specimen.particles, parsed(std::string(kLeast)).specimen.particles);
  EXPECT_EQ(experiment.material.friction, 0.5);
  EXPECT_EQ(experiment.numerics.minimum_cycles, 77);
  ASSERT_EQ(experiment.program.size(), 1U);
  EXPECT_EQ(specimen_hash(experiment), specimen_hash(parsed(std::string(kLeast))));
}

TEST(Experiment, ageing_may_adapt_to_a_tolerance) {
  const std::string least(kLeast);
  const Numerics fixed = parsed(least).numerics;
  EXPECT_FALSE(fixed.ageing_error_tolerance || fixed.drift_tolerance || fixed.inertial_number_limit);
  const std::string adaptive = least + "[numerics]\nbreakages_per_ageing = \"adaptive\"\n";
  EXPECT_EQ(parsed(adaptive).numerics.ageing_error_tolerance, 0.1);
  const Numerics asked = parsed(adaptive + "ageing_error_tolerance = 0.03\n").numerics;
  EXPECT_EQ(asked.ageing_error_tolerance, 0.03);
  EXPECT_FALSE(asked.breakages_per_ageing);
}

TEST(Experiment, failures_of_an_ageing_are_a_count_or_a_fraction_of_the_particles) {
  const auto hash_of = [](const std::string& lines) {
    return experiment_hash(parsed(std::string(kLeast) + "[numerics]\n" + lines));
  };
  const std::string reference = std::string(kLeast) + "[numerics]\nfidelity = \"reference\"\n";
  const Numerics fraction = parsed(reference + "breakage_fraction = 0.001\n").numerics;
  EXPECT_EQ(fraction.breakage_fraction, 0.001);
  EXPECT_FALSE(fraction.breakages_per_ageing);
  EXPECT_EQ(parsed(reference + "breakage_fraction = 0.001\nbreakages_per_ageing = 7\n")
                .numerics.breakages_per_ageing,
            7);
  EXPECT_EQ(hash_of("breakage_fraction = 0.0026\n"), hash_of(""));
  EXPECT_NE(hash_of("breakage_fraction = 0.001\n"), hash_of(""));
  EXPECT_EQ(hash_of("fidelity = \"balanced\"\nbreakages_per_ageing = \"adaptive\"\n"),
            hash_of("fidelity = \"fast\"\nbreakages_per_ageing = \"adaptive\"\n"));
}

Numerics numerics_of(const std::string& lines) {
  return parsed(std::string(kLeast) + "[numerics]\n" + lines).numerics;
}

TEST(Fidelity, each_is_a_set_of_keys_that_a_job_could_give_itself) {
  const auto hash_of = [](const std::string& lines) {
    return experiment_hash(parsed(std::string(kLeast) + "[numerics]\n" + lines));
  };
  for (const std::string_view name : fidelity_names()) {
    const std::string asked = "fidelity = " + ::creep::quoted(name) + "\n";
    std::string keys = "fidelity = \"paper\"\n";
    for (const NumericsValue& at : numerics_values(numerics_of(asked))) {
      if (at.key == "fidelity") continue;
      keys += std::string(at.key) + " = " + at.value + "\n";
    }
    EXPECT_EQ(hash_of(asked), hash_of(keys)) << keys;
    EXPECT_EQ(numerics_of(asked).fidelity, name);
    EXPECT_EQ(hash_of(asked) == hash_of(""), name == "paper") << name;
  }
}

TEST(Fidelity, every_key_overrides_it_wherever_it_stands) {
  const Numerics fast = numerics_of("minimum_cycles = 77\nfidelity = \"fast\"\n");
  EXPECT_EQ(fast.minimum_cycles, 77);
  EXPECT_EQ(fast.inertia_scaling, InertiaScaling::kAll);
  const Numerics slow = numerics_of(
      "fidelity = \"fast\"\ninertia_scaling = \"none\"\nloading_velocity = \"0.1 m/s\"\n"
      "drift_tolerance = \"none\"\ninertial_number_limit = \"none\"\n");
  EXPECT_FALSE(slow.drift_tolerance || slow.inertial_number_limit);
  EXPECT_EQ(slow.inertia_scaling, InertiaScaling::kNone);
  const Numerics adaptive = numerics_of("fidelity = \"reference\"\nbreakages_per_ageing = \"adaptive\"\n");
  EXPECT_FALSE(adaptive.breakages_per_ageing);
  EXPECT_TRUE(adaptive.ageing_error_tolerance);
}

TEST(Fidelity, an_error_takes_the_cheapest_that_is_as_good_and_no_worse_one) {
  const auto hash_of = [](const std::string& fidelity) {
    return experiment_hash(parsed(std::string(kLeast) + "[numerics]\nfidelity = " + fidelity + "\n"));
  };
  for (std::size_t i = 0; i < fidelity_names().size(); ++i) {
    const double error = fidelity_measure(i).error;
    const std::string asked = "{ error = " + shortest(error) + " }";
    const Numerics chosen = numerics_of("fidelity = " + asked + "\n");
    const FidelityMeasure found = fidelity_measure(*fidelity_index(chosen.fidelity));
    EXPECT_LE(found.error, error);
    EXPECT_GE(found.speed, fidelity_measure(i).speed);
    EXPECT_EQ(hash_of(asked), hash_of(::creep::quoted(chosen.fidelity)));
  }
  EXPECT_EQ(numerics_of("fidelity = { error = 1.0 }\n").fidelity, "fast");
  EXPECT_FALSE(cheapest_fidelity(fidelity_measure(most_accurate_fidelity()).error / 2));
}

TEST(Fidelity, an_error_measured_on_larger_specimens_brings_a_warning) {
  const std::string program = "[[program]]\nstage = \"creep\"\nduration = \"1 d\"\n";
  const auto warnings = [&](int particles) {
    return parse_experiment("[specimen]\nparticles = " + std::to_string(particles) + "\n" + program +
                            "[numerics]\nfidelity = { error = 0.5 }\n")
        .warnings.size();
  };
  EXPECT_EQ(warnings(kMeasuredParticles), 0U);
  EXPECT_EQ(warnings(kMeasuredParticles - 1), 1U);
}

TEST(Experiment, a_key_of_the_material_overrides_the_preset_wherever_it_stands) {
  const Experiment experiment = parsed(
      std::string(kLeast) + "[material]\nsize_exponent = 0.2\npreset = \"fontainebleau-ne34-literal\"\n");
  EXPECT_EQ(experiment.material.size_exponent, 0.2);
}

TEST(Experiment, few_particles_bring_a_warning_and_no_error) {
  const ParseResult result = parse_experiment(
      "[specimen]\nparticles = 300\n[[program]]\nstage = \"oedometric\"\nuntil = { axial_stress = \"1 MPa\" "
      "}\n");
  EXPECT_TRUE(result.experiment);
  ASSERT_EQ(result.warnings.size(), 1U);
  EXPECT_EQ(result.warnings[0].line, 2);
  EXPECT_EQ(result.warnings[0].column, 13);
}

TEST(Experiment, a_grading_file_is_found_in_every_way_to_write_it) {
  for (const std::string text :
       {"[specimen]\ngrading = { file = \"psd.csv\" }\n", "[specimen.grading]\nfile = 'psd.csv'\n",
        "specimen.grading.file = \"psd.csv\" # caf\u00E9\n",
        "name = \"caf\u00E9\"\nspecimen = { seed = 1, grading = { file = \"psd.csv\" } }"}) {
    const auto file = find_grading_file(text);
    ASSERT_TRUE(file) << text;
    EXPECT_EQ(file->path, "psd.csv");
    EXPECT_EQ(text.substr(file->key_begin, file->key_end - file->key_begin), "file");
    const std::string value = text.substr(file->value_begin, file->value_end - file->value_begin);
    EXPECT_EQ(value.substr(1, value.size() - 2), "psd.csv");
  }
  EXPECT_FALSE(find_grading_file(kLeast));
  EXPECT_FALSE(find_grading_file("[specimen"));
}

TEST(ExperimentHash, every_field_that_can_change_a_result_changes_it) {
  Experiment base = parsed(std::string(kLeast));
  base.program.push_back(CreepStage{.duration = 60.0, .axial_stress = {}});
  using Change = std::function<void(Experiment&)>;
  const std::vector<Change> changes = {
      [](Experiment& e) { e.specimen.particles = 3001; },
      [](Experiment& e) { e.specimen.particles.reset(), e.specimen.side = 4e-3; },
      [](Experiment& e) { std::get<LognormalGrading>(e.specimen.grading).median_diameter *= 2; },
      [](Experiment& e) { std::get<LognormalGrading>(e.specimen.grading).log_standard_deviation *= 2; },
      [](Experiment& e) { std::get<LognormalGrading>(e.specimen.grading).min_diameter *= 2; },
      [](Experiment& e) { std::get<LognormalGrading>(e.specimen.grading).max_diameter *= 2; },
      [](Experiment& e) {
        e.specimen.grading = GradingPoints{{{1e-4, 0.0}, {4e-4, 1.0}}};
      },
      [](Experiment& e) {
        e.specimen.grading = GradingPoints{{{1e-4, 0.0}, {2e-4, 0.5}, {4e-4, 1.0}}};
      },
      [](Experiment& e) { e.specimen.void_ratio = 0.66; },
      [](Experiment& e) { e.specimen.isotropic_stress = 101e3; },
      [](Experiment& e) { e.specimen.seed = 2; },
      [](Experiment& e) { e.material.shear_modulus *= 2; },
      [](Experiment& e) { e.material.poisson_ratio *= 2; },
      [](Experiment& e) { e.material.friction *= 2; },
      [](Experiment& e) { e.material.density *= 2; },
      [](Experiment& e) { e.material.roughness *= 2; },
      [](Experiment& e) { e.material.roughness_n1 *= 2; },
      [](Experiment& e) { e.material.roughness_n2 *= 2; },
      [](Experiment& e) { e.material.wall_stiffness_factor *= 2; },
      [](Experiment& e) { e.material.wall_friction += 0.1; },
      [](Experiment& e) { e.material.free_rotation = true; },
      [](Experiment& e) { e.material.limit_stress *= 2; },
      [](Experiment& e) { e.material.reference_diameter *= 2; },
      [](Experiment& e) { e.material.size_exponent *= 2; },
      [](Experiment& e) { e.material.strength_variation *= 2; },
      [](Experiment& e) { e.material.strength_floor *= 2; },
      [](Experiment& e) { e.material.comminution_limit *= 2; },
      [](Experiment& e) { e.material.split_layout = SplitLayout::kCubic; },
      [](Experiment& e) { e.material.crack_velocity *= 2; },
      [](Experiment& e) { e.material.corrosion_index *= 2; },
      [](Experiment& e) { e.material.grading_index_max_diameter *= 2; },
      [](Experiment& e) { e.material.grading_index_min_diameter *= 2; },
      [](Experiment& e) { e.material.fractal_dimension = 2.5; },
      [](Experiment& e) { std::get<OedometricStage>(e.program[0]).until.value *= 2; },
      [](Experiment& e) { std::get<CreepStage>(e.program[1]).duration *= 2; },
      [](Experiment& e) { std::get<CreepStage>(e.program[1]).axial_stress = 30e6; },
      [](Experiment& e) { std::get<CreepStage>(e.program[1]).deviatoric_stress = 30e6; },
      [](Experiment& e) { std::get<CreepStage>(e.program[1]).keep = Keep{}; },
      [](Experiment& e) {
        std::get<OedometricStage>(e.program[0]).until.measure = Target::Measure::kAxialStrain;
      },
      [](Experiment& e) { e.program[1] = RelaxationStage{60.0}; },
      [](Experiment& e) {
        e.start = Start{"ab12", ""};
      },
      [](Experiment& e) {
        e.start = Start{"ab12", "7"};
      },
      [](Experiment& e) { e.program.pop_back(); },
      [](Experiment& e) { e.program.push_back(CreepStage{.duration = 60.0, .axial_stress = {}}); },
      [](Experiment& e) { e.numerics.minimum_cycles = 1; },
      [](Experiment& e) { e.numerics.time_step_safety *= 2; },
      [](Experiment& e) { e.numerics.breakages_per_ageing = 8; },
      [](Experiment& e) { e.numerics.breakage_fraction *= 2; },
      [](Experiment& e) { e.numerics.ageing_error_tolerance = 0.1; },
      [](Experiment& e) { e.numerics.drift_tolerance = 0.1; },
      [](Experiment& e) { e.numerics.inertial_number_limit = 0.1; },
      [](Experiment& e) { e.numerics.settle_tolerance *= 2; },
      [](Experiment& e) { e.numerics.unbalanced_tolerance *= 2; },
      [](Experiment& e) { e.numerics.local_damping *= 2; },
      [](Experiment& e) { e.numerics.inertia_scaling = InertiaScaling::kAll; },
      [](Experiment& e) { e.numerics.failure_check_interval = 2; },
      [](Experiment& e) { e.numerics.loading_velocity *= 2; },
  };
  std::set<std::string> hashes = {experiment_hash(base)};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    Experiment changed = base;
    changes[i](changed);
    EXPECT_TRUE(hashes.insert(experiment_hash(changed)).second) << "change " << i;
  }
  EXPECT_EQ(hashes.begin()->size(), 64U);
}

TEST(ExperimentHash, labels_skin_and_output_do_not_count) {
  const Experiment base = parsed(std::string(kLeast));
  Experiment changed = base;
  changed.name = "another name";
  changed.material.preset = "another word for the same values";
  changed.numerics.skin = 5e-6;
  changed.output.snapshots_per_decade = true;
  EXPECT_EQ(experiment_hash(changed), experiment_hash(base));
}

}  // namespace
}  // namespace creep
