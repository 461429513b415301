// What is wrong with a job file, and that nothing in one can hurt.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>

#include "core/experiment/experiment_toml.h"

namespace creep {
namespace {

// The line numbers of the tests below count in this text.
constexpr std::string_view kGood =
    "[specimen]\n"                               // 1
    "particles = 3000\n"                         // 2
    "void_ratio = 0.65\n"                        // 3
    "[material]\n"                               // 4
    "preset = \"fontainebleau-ne34\"\n"          // 5
    "[[program]]\n"                              // 6
    "stage = \"oedometric\"\n"                   // 7
    "until = { axial_stress = \"21.7 MPa\" }\n"  // 8
    "[[program]]\n"                              // 9
    "stage = \"creep\"\n"                        // 10
    "duration = \"2 d\"\n"                       // 11
    "[numerics]\n"                               // 12
    "fidelity = \"paper\"\n";                    // 13

/// kGood with one line replaced (0: the text is the whole file) must give exactly this one error.
struct BadInput {
  std::string name;
  int replaced_line;
  std::string text;
  int line;
  int column;
  std::string message_part;
};

void PrintTo(const BadInput& bad, std::ostream* out) { *out << bad.name; }

std::string with_line(int replaced_line, const std::string& text) {
  if (replaced_line == 0) return text;
  std::istringstream lines{std::string(kGood)};
  std::string out;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number)
    out += (number == replaced_line ? text : line) + "\n";
  return out;
}

class BadJobFile : public testing::TestWithParam<BadInput> {};

TEST_P(BadJobFile, gives_one_error_at_its_place) {
  const BadInput& bad = GetParam();
  const ParseResult result = parse_experiment(with_line(bad.replaced_line, bad.text));
  EXPECT_FALSE(result.experiment);
  ASSERT_EQ(result.errors.size(), 1U) << (result.errors.size() > 1 ? result.errors[1].message : "");
  EXPECT_EQ(result.errors[0].line, bad.line) << result.errors[0].message;
  EXPECT_EQ(result.errors[0].column, bad.column) << result.errors[0].message;
  EXPECT_NE(result.errors[0].message.find(bad.message_part), std::string::npos) << result.errors[0].message;
}

INSTANTIATE_TEST_SUITE_P(
    Text, BadJobFile,
    testing::Values(BadInput{"empty", 0, "", 1, 1, "the file is empty"},
                    BadInput{"only_a_comment", 0, "# nothing\n\n", 1, 1, "the file is empty"},
                    BadInput{"binary", 0,
                             std::string("\x7f"
                                         "ELF\x02\x01\0\0",
                                         8),
                             1, 1, "not valid TOML"},
                    BadInput{"zero_byte", 0, std::string("\0", 1), 1, 1, "not valid TOML"},
                    BadInput{"cut_code_point", 0, "a = 1\nb = \"\u00B5\xC2", 2, 7, "UTF-8"},
                    BadInput{"surrogate", 0, "# \u00B5 \xED\xA0\x80", 1, 5, "UTF-8"},
                    BadInput{"not_utf8", 2, "particles = 3000 # \xff", 2, 20, "UTF-8"},
                    BadInput{"unit_without_quotes", 8, "until = { axial_stress = 21.7 MPa }", 8, 31,
                             "not valid TOML"},
                    BadInput{"unit_without_quotes_on_a_line", 11, "duration = 2 d", 11, 14, "in quotes"},
                    BadInput{"table_name_begins_badly", 12, "[?]", 12, 2, "not valid TOML"},
                    BadInput{"a_key_twice", 3, "particles = 3000", 3, 13, "redefine"},
                    BadInput{"huge_integer", 2, "particles = 99999999999999999999", 2, 33, "64 bits"}),
    [](const auto& info) { return info.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Specimen, BadJobFile,
    testing::Values(
        BadInput{"void_ratio_too_small", 3, "void_ratio = 0.01", 3, 14, "out of range: allowed 0.2 to 2"},
        BadInput{"void_ratio_negative", 3, "void_ratio = -0.65", 3, 14, "allowed 0.2 to 2"},
        BadInput{"void_ratio_nan", 3, "void_ratio = nan", 3, 14, "finite"},
        BadInput{"void_ratio_infinite", 3, "void_ratio = inf", 3, 14, "finite"},
        BadInput{"void_ratio_in_quotes", 3, "void_ratio = \"0.65\"", 3, 14, "write 0.65 without quotes"},
        BadInput{"too_many_particles", 2, "particles = 100000000000", 2, 13, "allowed 20 to 10000000"},
        BadInput{"too_many_particles_with_exponent", 2, "particles = 1e11", 2, 13, "allowed 20 to 10000000"},
        BadInput{"particles_with_exponent", 2, "particles = 3e3", 2, 13, "without point or exponent"},
        BadInput{"particles_negative", 2, "particles = -5", 2, 13, "allowed 20 to 10000000"},
        BadInput{"particles_true", 2, "particles = true", 2, 13, "not true or false"},
        BadInput{"neither_particles_nor_side", 2, "", 1, 1, "needs particles"},
        BadInput{"particles_and_side", 3, "side = \"4 mm\"", 3, 8, "not both"},
        BadInput{"side_bare", 2, "side = 0.004", 2, 8, "like \"4 mm\""},
        BadInput{"side_negative", 2, "side = \"-4 mm\"", 2, 8, "out of range"},
        BadInput{"side_of_metres", 2, "side = \"1 m\"", 2, 8, "particles of this grading"},
        BadInput{"side_of_another_dimension", 2, "side = \"4 kPa\"", 2, 8,
                 "a length with its unit is wanted"},
        BadInput{"unknown_key", 3, "void_ration = 0.65", 3, 1, "did you mean \"void_ratio\"?"},
        BadInput{"unlike_key", 3, "porosity = 0.4", 3, 1, "allowed: particles, side, grading"},
        BadInput{"stress_bare", 3, "isotropic_stress = 100e3", 3, 20, "like \"100 kPa\""},
        BadInput{"seed_negative", 3, "seed = -1", 3, 8, "allowed 0 to"},
        BadInput{"grading_word", 3, "grading = \"fontainebleau-ne34\"", 3, 11, "must be a table"},
        BadInput{"grading_unknown", 3, "grading = { preset = \"fontainbleau-ne34\" }", 3, 22, "did you mean"},
        BadInput{"grading_empty", 3, "grading = {}", 3, 11, "exactly one of"},
        BadInput{"grading_file", 3, "grading = { file = \"psd.csv\" }", 3, 20,
                 "creepctl puts its points here"},
        BadInput{"points_fall", 3, "grading = { points = [[\"0.2 mm\", 0], [\"0.1 mm\", 1]] }", 3, 38,
                 "must rise"},
        BadInput{
            "passing_falls", 3,
            "grading = { points = [[\"0.1 mm\", 0], [\"0.2 mm\", 0.6], [\"0.3 mm\", 0.5], [\"0.4 mm\", 1]] }",
            3, 55, "must not fall"},
        BadInput{"points_begin_above_0", 3, "grading = { points = [[\"0.1 mm\", 0.1], [\"0.2 mm\", 1]] }", 3,
                 23, "pass 0"},
        BadInput{"points_end_below_1", 3, "grading = { points = [[\"0.1 mm\", 0], [\"0.2 mm\", 0.9]] }", 3,
                 38, "pass 1"},
        BadInput{"point_bare", 3, "grading = { points = [[0.1, 0], [\"0.2 mm\", 1]] }", 3, 24,
                 "needs its unit"},
        BadInput{"points_too_wide", 3, "grading = { points = [[\"1 um\", 0], [\"1 mm\", 1]] }", 3, 22,
                 "at most 100"}),
    [](const auto& info) { return info.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Material, BadJobFile,
    testing::Values(
        BadInput{"unknown_preset", 5, "preset = \"fontainebleau\"", 5, 10, "fontainebleau-ne34"},
        BadInput{"preset_number", 5, "preset = 34", 5, 10, "must be a string"},
        BadInput{"unknown_key", 5, "frictoin = 0.3", 5, 1, "did you mean \"friction\"?"},
        BadInput{"unit_of_another_dimension", 5, "roughness = \"0.6 MPa\"", 5, 13, "is a unit of stress"},
        BadInput{"misspelt_unit", 5, "limit_stress = \"3.75 Gpa\"", 5, 16, "did you mean \"GPa\"?"},
        BadInput{"negative_size", 5, "comminution_limit = \"-0.1 mm\"", 5, 21,
                 "out of range: allowed 1 um to 1 m"},
        BadInput{"poisson", 5, "poisson_ratio = 0.5", 5, 17, "allowed 0 to 0.49"},
        BadInput{"layout", 5, "split_layout = \"octaedral\"", 5, 16, "did you mean \"octahedral\"?"},
        BadInput{"limits_swapped", 5, "grading_index_max_diameter = \"5 um\"", 5, 30, "must be smaller"},
        BadInput{"no_table", 4, "[[material]]", 4, 1, "write [material]"}),
    [](const auto& info) { return info.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Program, BadJobFile,
    testing::Values(
        BadInput{"unknown_stage", 7, "stage = \"oedometer\"", 7, 9, "did you mean \"oedometric\"?"},
        BadInput{"no_stage", 10, "", 9, 1, "needs stage"}, BadInput{"no_target", 8, "", 6, 1, "needs until"},
        BadInput{"target_is_no_table", 8, "until = \"21.7 MPa\"", 8, 9, "needs until"},
        BadInput{"empty_target", 8, "until = {}", 8, 9, "needs a target"},
        BadInput{"target_of_another_stage", 8, "until = { mean_stress = \"1 MPa\" }", 8, 11,
                 "available: axial_stress"},
        BadInput{"two_targets", 8, "until = { axial_stress = \"1 MPa\", axial_strain = 0.1 }", 8, 9,
                 "one target"},
        BadInput{"strain_in_percent", 8, "until = { axial_strain = 10 }", 8, 26, "allowed 1e-05 to 0.45"},
        BadInput{"target_bare", 8, "until = { axial_stress = 21.7 }", 8, 26, "needs its unit"},
        BadInput{"target_misspelt_unit", 8, "until = { axial_stress = \"21.7 Mpa\" }", 8, 26,
                 "did you mean \"MPa\"?"},
        BadInput{"target_below_packing", 8, "until = { axial_stress = \"50 kPa\" }", 8, 26,
                 "above the 100 kPa"},
        BadInput{"target_unknown", 8, "until = { axial_stres = \"21.7 MPa\" }", 8, 11,
                 "did you mean \"axial_stress\"?"},
        BadInput{"duration_missing", 11, "", 9, 1, "needs duration"},
        BadInput{"duration_bare", 11, "duration = 172800", 11, 12, "like \"2 d\""},
        BadInput{"duration_word", 11, "duration = \"2 days\"", 11, 12, "did you mean \"d\"?"},
        BadInput{"duration_negative", 11, "duration = \"-2 d\"", 11, 12, "out of range"},
        BadInput{"hold_deviatoric_in_the_oedometer", 11, "duration = \"2 d\"\ndeviatoric_stress = \"5 MPa\"",
                 12, 21, "sides are fixed"},
        BadInput{"ratio_without_maximum", 11,
                 "duration = \"2 d\"\n[[program]]\nstage = \"triaxial\"\nuntil = { q_ratio = 0.5 }", 14, 21,
                 "belong together"},
        BadInput{"hold_with_steps_to_keep", 11, "duration = \"2 d\"\nkeep = { every_axial_strain = 0.01 }",
                 12, 10, "keeps the end"},
        BadInput{"keep_is_no_table", 8, "until = { axial_stress = \"21.7 MPa\" }\nkeep = 0.01", 9, 8,
                 "must be a table"},
        BadInput{"keep_unknown", 8, "until = { axial_stress = \"21.7 MPa\" }\nkeep = { every_strain = 0.01 }",
                 9, 10, "allowed: every_axial_strain"},
        BadInput{"unload_upwards", 11,
                 "duration = \"2 d\"\n[[program]]\nstage = \"unload\"\nuntil = { axial_stress = \"30 MPa\" }",
                 14, 26, "below the 21.7 MPa"},
        BadInput{
            "unload_deviatoric_in_the_oedometer", 11,
            "duration = \"2 d\"\n[[program]]\nstage = \"unload\"\nuntil = { deviatoric_stress = \"1 MPa\" }",
            14, 31, "sides are fixed"},
        BadInput{
            "oedometric_downwards", 11,
            "duration = \"2 d\"\n[[program]]\nstage = \"oedometric\"\nuntil = { axial_stress = \"1 MPa\" }",
            14, 26, "the stage \"unload\""},
        BadInput{
            "triaxial_of_isotropic_target", 11,
            "duration = \"2 d\"\n[[program]]\nstage = \"triaxial\"\nuntil = { mean_stress = \"10 MPa\" }", 14,
            11, "q_ratio with q_max"},
        BadInput{"triaxial_ratio_and_stress", 11,
                 "duration = \"2 d\"\n[[program]]\nstage = \"triaxial\"\nuntil = { deviatoric_stress = \"1 "
                 "MPa\", q_ratio = 0.5, q_max = \"2 MPa\" }",
                 14, 50, "not both"},
        BadInput{"triaxial_velocity_bare", 11,
                 "duration = \"2 d\"\n[[program]]\nstage = \"triaxial\"\naxial_velocity = 0.01\nuntil = { "
                 "axial_strain = 0.2 }",
                 14, 18, "like \"10 mm/s\""},
        BadInput{"one_table", 0, "[specimen]\nparticles = 3000\n[program]\nstage = \"creep\"\n", 3, 1,
                 "[[program]]"},
        BadInput{"creep_first", 0,
                 "[specimen]\nparticles = 3000\n[[program]]\nstage = \"creep\"\nduration = \"2 d\"\n", 3, 1,
                 "loading stage before"},
        BadInput{"missing", 0, "[specimen]\nparticles = 3000\n", 1, 1, "missing [[program]]"}),
    [](const auto& info) { return info.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Rest, BadJobFile,
    testing::Values(
        BadInput{"fidelity_error_below_all", 13, "fidelity = { error = 0.001 }", 13, 22,
                 "the smallest is 0.0"},
        BadInput{"fidelity_error_of_nothing", 13, "fidelity = { error = 0.0 }", 13, 22, "allowed 1e-06 to 1"},
        BadInput{"fidelity_without_error", 13, "fidelity = {}", 13, 12, "fidelity needs error"},
        BadInput{"fidelity_other_key", 13, "fidelity = { error = 0.5, eror = 1 }", 13, 27,
                 "did you mean \"error\"?"},
        BadInput{"drift_word", 13, "drift_tolerance = \"nine\"", 13, 19, "did you mean \"none\"?"},
        BadInput{"fidelity_unknown", 13, "fidelity = \"papper\"", 13, 12, "did you mean \"paper\"?"},
        BadInput{"cycles_in_quotes", 13, "minimum_cycles = \"150000\"", 13, 18,
                 "write 150000 without quotes"},
        BadInput{"cycles_fraction", 13, "minimum_cycles = 1.5e4", 13, 18, "without point or exponent"},
        BadInput{"velocity_bare", 13, "loading_velocity = 0.1", 13, 20, "is a velocity"},
        BadInput{"safety_above_1", 13, "time_step_safety = 1.1", 13, 20, "allowed 0.01 to 1"},
        BadInput{"ageing_word", 13, "breakages_per_ageing = \"adaptve\"", 13, 24,
                 "did you mean \"adaptive\"?"},
        BadInput{"ageing_tolerance_alone", 13, "ageing_error_tolerance = 0.1", 13, 26,
                 "needs breakages_per_ageing = \"adaptive\""},
        BadInput{"breakage_fraction_above_1", 13, "breakage_fraction = 8", 13, 21, "allowed 1e-06 to 1"},
        BadInput{"ageing_above_count", 13, "breakages_per_ageing = 3001", 13, 24, "must not exceed"},
        BadInput{"inertia", 13, "inertia_scaling = \"fragment\"", 13, 19, "did you mean \"fragments\"?"},
        BadInput{"snapshots", 13, "[output]\nsnapshots = \"per decade\"", 14, 13, "per decade of age"},
        BadInput{"section", 12, "[numeric]", 12, 2, "did you mean \"numerics\"?"},
        BadInput{"start_without_job", 12, "[start]\ncheckpoint = \"7\"\n[numerics]", 12, 1, "needs job"},
        BadInput{"name_number", 0,
                 "name = 3\n[specimen]\nparticles = 3000\n[[program]]\nstage = \"oedometric\"\n"
                 "until.axial_stress = \"1 MPa\"\n",
                 1, 8, "must be a string"},
        BadInput{"specimen_number", 0,
                 "specimen = 3\n[[program]]\nstage = \"oedometric\"\nuntil.axial_stress = \"1 MPa\"\n", 1, 12,
                 "write [specimen]"},
        BadInput{"specimen_missing", 0,
                 "[[program]]\nstage = \"oedometric\"\nuntil.axial_stress = \"1 MPa\"\n", 1, 1,
                 "missing section [specimen]"}),
    [](const auto& info) { return info.param.name; });

TEST(JobFileErrors, all_errors_come_at_once_in_the_order_of_the_text) {
  const ParseResult result = parse_experiment(
      "[numerics]\nskin = 1\n[specimen]\nparticles = 1\nvoid_ratio = \"x\"\nfoo = 1\n[[program]]\nstage = "
      "\"creep\"\n");
  ASSERT_EQ(result.errors.size(),
            6U);  // skin, particles, void_ratio, foo; creep without load and without duration
  for (std::size_t i = 1; i < result.errors.size(); ++i)
    EXPECT_LE(result.errors[i - 1].line, result.errors[i].line);
}

TEST(JobFileErrors, a_flood_is_cut) {
  std::string text = "[specimen]\n";
  for (int i = 0; i < 5000; ++i) text += "key" + std::to_string(i) + " = 1\n";
  EXPECT_EQ(parse_experiment(text).errors.size(), 101U);
}

TEST(JobFileErrors, quoted_text_cannot_steer_a_terminal) {
  const ParseResult result = parse_experiment(with_line(5, "preset = \"\\u001b[31m\\u009b31m\""));
  ASSERT_EQ(result.errors.size(), 1U);
  EXPECT_EQ(result.errors[0].message.find('\x1b'), std::string::npos);
  EXPECT_EQ(result.errors[0].message.find("\u009b"), std::string::npos);
}

// Each of these made a recursive parser overflow its stack, or a slow one hang.
TEST(JobFileErrors, depth_and_size_are_bounded) {
  const auto repeated = [](std::string_view part, int times) {
    std::string text;
    for (int i = 0; i < times; ++i) text += part;
    return text;
  };
  const std::vector<std::string> texts = {
      repeated("a.", 400'000) + "a = 1\n",
      std::string(1, '[').append(repeated("a.", 400'000)).append("a]\n"),
      repeated("\"=\".", 200'000) + "a = 1\n",
      repeated("'#'.", 200'000) + "a = 1\n",
      "a = " + repeated("[", 400'000),
      "a = " + repeated("{a=", 300'000),
      "a = " + repeated("{a.a.a.a.a.a.a.a.a.a=", 40'000),
      std::string(1024 * 1024 + 1, '#'),
  };
  for (const std::string& text : texts) {
    const ParseResult result = parse_experiment(text);
    EXPECT_FALSE(result.experiment) << text.substr(0, 20);
    EXPECT_EQ(result.errors.size(), 1U) << text.substr(0, 20);
  }
}

std::string mutated(std::string text, std::mt19937& random) {
  const auto below = [&](std::size_t limit) { return static_cast<std::size_t>(random()) % limit; };
  static constexpr std::string_view kPieces[] = {"\"", "'",  "[",    "]",      "{",   "}",  "=",
                                                 ".",  "\n", "#",    "\\",     "1e9", "-1", "nan",
                                                 ",",  "\0", "\xff", "\"\"\"", "0",   "[["};
  const std::size_t edits = 1 + below(4);
  for (std::size_t edit = 0; edit < edits && !text.empty(); ++edit) {
    const std::size_t at = below(text.size());
    const std::size_t length = std::min(1 + below(30), text.size() - at);
    switch (below(5)) {
      case 0:
        text[at] = static_cast<char>(below(256));
        break;
      case 1:
        text.erase(at, length);
        break;
      case 2:
        text.insert(at, kPieces[below(std::size(kPieces))]);
        break;
      case 3:
        text.insert(below(text.size()), text.substr(at, length));
        break;
      default:
        text.resize(at);
        break;
    }
  }
  return text;
}

TEST(JobFile, every_example_is_taken) {
  int seen = 0;
  for (const auto& entry : std::filesystem::directory_iterator(CREEP_SOURCE_DIR "/client/examples")) {
    if (entry.path().extension() != ".toml") continue;
    ++seen;
    std::ifstream file(entry.path(), std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    const ParseResult result = parse_experiment(text.str());
    for (const Diagnostic& error : result.errors)
      ADD_FAILURE() << entry.path() << ":" << error.line << ": " << error.message;
  }
  EXPECT_GE(seen, 5);
}

TEST(JobFileErrors, ten_thousand_mutations_of_the_example_are_all_answered) {
  std::ifstream file(CREEP_SOURCE_DIR "/client/examples/oedometer_creep.toml", std::ios::binary);
  const std::string example{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  ASSERT_TRUE(parse_experiment(example).experiment);
  std::mt19937 random(20240807);
  int refused = 0;
  for (int i = 0; i < 10'000; ++i) {
    const std::string text = mutated(example, random);
    const ParseResult result = parse_experiment(text);
    ASSERT_EQ(result.experiment.has_value(), result.errors.empty()) << text;
    for (const Diagnostic& error : result.errors) {
      ASSERT_GE(error.line, 1) << text;
      ASSERT_GE(error.column, 1) << text;
      ASSERT_FALSE(error.message.empty()) << text;
    }
    if (!result.experiment) ++refused;
    find_grading_file(text);
  }
  // Edits of comments leave a file good; most others do not.
  EXPECT_GT(refused, 5000);
}

}  // namespace
}  // namespace creep
