// validate, init and version, through the program itself.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <string>

#include "client/job_file/job_file.h"
#include "client/job_file/job_template.h"
#include "client/laboratory/grading_csv.h"
#include "client/terminal/exit_codes.h"
#include "core/experiment/presets.h"
#include "core/run/run.h"
#include "core/run/self_test.h"
#include "core/state/checkpoint.h"
#include "core/state/program_version.h"

namespace creepctl {
namespace {

namespace fs = std::filesystem;

struct Ended {
  int exit_code = -1;
  std::string out;
  std::string err;
};

std::string contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

class JobCommands : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "creepctl-test-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Runs creepctl with the arguments in the folder of the test.
  Ended creepctl(const std::string& arguments) const {
    const std::string command =
        "cd '" + folder_.string() + "' && '" CREEPCTL_PATH "' " + arguments + " >.out 2>.err";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, contents(folder_ / ".out"),
            contents(folder_ / ".err")};
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  const fs::path& folder() const { return folder_; }

 private:
  fs::path folder_;
};

std::string job_with_grading(const std::string& grading) {
  return "[specimen]\nparticles = 3000\n" + grading +
         "[[program]]\nstage = \"oedometric\"\nuntil = { axial_stress = \"1 MPa\" }\n";
}

TEST_F(JobCommands, every_example_is_valid) {
  int examples = 0;
  for (const auto& entry : fs::directory_iterator(CREEP_SOURCE_DIR "/client/examples")) {
    if (entry.path().extension() != ".toml") continue;
    ++examples;
    const Ended ended = creepctl("validate '" + entry.path().string() + "'");
    EXPECT_EQ(ended.exit_code, kOk) << ended.err;
    EXPECT_EQ(ended.err, "");
    EXPECT_NE(ended.out.find(": valid: "), std::string::npos) << ended.out;
  }
  EXPECT_GE(examples, 2);
}

TEST_F(JobCommands, the_example_takes_any_count_from_300_on) {
  std::string text = contents(CREEP_SOURCE_DIR "/client/examples/oedometer_creep.toml");
  const std::string line = "particles = 3000\n";
  ASSERT_NE(text.find(line), std::string::npos);
  text.replace(text.find(line), line.size(), "particles = 300\n");
  write("small.toml", text);
  const Ended ended = creepctl("validate small.toml");
  EXPECT_EQ(ended.exit_code, kOk);
  EXPECT_NE(ended.err.find("small.toml:"), std::string::npos);
  EXPECT_NE(ended.err.find(": warning: "), std::string::npos);
}

TEST_F(JobCommands, errors_are_file_line_column_on_stderr_and_exit_5) {
  write("bad.toml", job_with_grading("void_ratio = 0.01\nfoo = 1\n"));
  const Ended ended = creepctl("validate bad.toml");
  EXPECT_EQ(ended.exit_code, kInvalidInput);
  EXPECT_EQ(ended.out, "");
  EXPECT_EQ(ended.err.find("bad.toml:3:14: error: void_ratio = 0.01 is out of range: allowed 0.2 to 2\n"
                           "bad.toml:4:1: error: unknown key \"foo\""),
            0U)
      << ended.err;
}

TEST_F(JobCommands, empty_binary_and_unreadable_files_exit_5_with_a_place) {
  write("empty.toml", "");
  write("binary.toml", contents(CREEPCTL_PATH).substr(0, 4000));
  for (const std::string name : {"empty.toml", "binary.toml", "missing.toml", "."}) {
    const Ended ended = creepctl("validate " + name);
    EXPECT_EQ(ended.exit_code, kInvalidInput) << name;
    EXPECT_EQ(ended.err.find(name + ":1:"), 0U) << ended.err;
    EXPECT_NE(ended.err.find(": error: "), std::string::npos) << ended.err;
  }
}

TEST_F(JobCommands, validate_json_is_one_object_with_all_diagnostics) {
  write("bad.toml", job_with_grading("void_ratio = 0.01\nfoo = 1\n"));
  const Ended bad = creepctl("validate --json bad.toml");
  EXPECT_EQ(bad.exit_code, kInvalidInput);
  const auto json = nlohmann::json::parse(bad.out);
  EXPECT_EQ(json["valid"], false);
  ASSERT_EQ(json["errors"].size(), 2U);
  EXPECT_EQ(json["errors"][0]["line"], 3);
  EXPECT_EQ(json["errors"][0]["column"], 14);

  write("good.toml", job_with_grading(""));
  const Ended good = creepctl("validate --json good.toml");
  EXPECT_EQ(good.exit_code, kOk);
  EXPECT_EQ(nlohmann::json::parse(good.out)["valid"], true);
}

TEST_F(JobCommands, validate_says_what_a_fidelity_stands_for) {
  write(
      "fast.toml",
      "[specimen]\nparticles = 3000\n[[program]]\nstage = \"oedometric\"\nuntil = { axial_stress = \"1 MPa\" "
      "}\n[numerics]\nfidelity = \"fast\"\nskin = \"3 um\"\n");
  const auto numerics = nlohmann::json::parse(creepctl("validate --json fast.toml").out)["numerics"];
  EXPECT_EQ(numerics["fidelity"], "fast");
  EXPECT_EQ(numerics["inertia_scaling"], "all");
  EXPECT_EQ(numerics["skin"], "3 um");
  EXPECT_LT(numerics["minimum_cycles"], 150000);
  EXPECT_NE(creepctl("validate fast.toml").out.find("inertia_scaling = \"all\""), std::string::npos);
}

TEST_F(JobCommands, a_grading_file_is_put_in_and_found_beside_the_job) {
  fs::create_directory(folder() / "jobs");
  write("jobs/psd.csv", "# measured\ndiameter_mm,passing_percent\r\n0.1,0\r\n0.2,40\r\n0.4,100\r\n");
  write("jobs/job.toml", job_with_grading("grading = { file = \"psd.csv\" }\n"));
  EXPECT_EQ(creepctl("validate jobs/job.toml").exit_code, kOk);

  const JobFile job = read_job_file((folder() / "jobs/job.toml").string());
  ASSERT_TRUE(job.experiment);
  const auto& points = std::get<creep::GradingPoints>(job.experiment->specimen.grading).points;
  ASSERT_EQ(points.size(), 3U);
  EXPECT_EQ(points[1].diameter, 0.2e-3);
  EXPECT_EQ(points[1].passing, 0.4);
  // A worker gets the text alone.
  EXPECT_TRUE(creep::parse_experiment(job.text).experiment);
}

TEST_F(JobCommands, errors_beside_a_grading_file_keep_their_place) {
  write("falling.csv", "0.4 mm; 0\n0.1 mm; 1\n");
  write("job.toml", job_with_grading("grading = { file = \"falling.csv\", foo = 1 }\n"));
  const Ended ended = creepctl("validate job.toml");
  EXPECT_EQ(ended.exit_code, kInvalidInput);
  EXPECT_NE(ended.err.find("job.toml:3:22: error: in grading file \"falling.csv\": diameters must rise"),
            std::string::npos)
      << ended.err;
  EXPECT_NE(ended.err.find("job.toml:3:35: error: unknown key \"foo\""), std::string::npos) << ended.err;
}

TEST_F(JobCommands, a_bad_grading_file_is_named_with_its_lines_and_the_rest_is_checked_too) {
  write("psd.csv", "diameter_mm,passing\n0.1,0\nx,0.5\n0.4,7\nonly one\n");
  write("job.toml", job_with_grading("grading = { file = \"psd.csv\" }\nvoid_ratio = 9\n"));
  const Ended ended = creepctl("validate job.toml");
  EXPECT_EQ(ended.exit_code, kInvalidInput);
  for (const std::string place : {"psd.csv:3:1: error:", "psd.csv:4:1: error:", "psd.csv:5:1: error:",
                                  "job.toml:4:14: error: void_ratio"}) {
    EXPECT_NE(ended.err.find(place), std::string::npos) << place << "\n" << ended.err;
  }
  write("job.toml", job_with_grading("grading = { file = \"none.csv\" }\n"));
  EXPECT_NE(creepctl("validate job.toml")
                .err.find("job.toml:3:20: error: grading file \"none.csv\" cannot be read"),
            std::string::npos);
}

TEST_F(JobCommands, init_writes_a_valid_file_and_never_overwrites) {
  EXPECT_EQ(creepctl("init job.toml").exit_code, kOk);
  EXPECT_EQ(creepctl("validate job.toml").exit_code, kOk);
  write("mine.toml", "precious");
  const Ended ended = creepctl("init mine.toml");
  EXPECT_EQ(ended.exit_code, kFailed);
  EXPECT_NE(ended.err.find("exists already"), std::string::npos);
  EXPECT_EQ(contents(folder() / "mine.toml"), "precious");
}

TEST_F(JobCommands, init_that_cannot_write_is_an_error_of_the_world) {
  const Ended ended = creepctl("init nowhere/job.toml");
  EXPECT_EQ(ended.exit_code, kIoError);
  EXPECT_NE(ended.err.find("nowhere/job.toml: No such file or directory"), std::string::npos) << ended.err;
}

TEST_F(JobCommands, init_prints_without_a_file_and_takes_a_preset) {
  const Ended ended = creepctl("init --preset fontainebleau-ne34-literal");
  EXPECT_EQ(ended.exit_code, kOk);
  EXPECT_NE(ended.out.find("preset = \"fontainebleau-ne34-literal\""), std::string::npos);
  EXPECT_EQ(creepctl("init --preset nonsense").exit_code, kUsage);
}

TEST_F(JobCommands, usage_errors_exit_2_and_help_ends_with_an_example) {
  EXPECT_EQ(creepctl("").exit_code, kUsage);
  EXPECT_EQ(creepctl("validate").exit_code, kUsage);
  EXPECT_EQ(creepctl("validate --nonsense x").exit_code, kUsage);
  const Ended unknown = creepctl("validat x");
  EXPECT_EQ(unknown.exit_code, kUsage);
  EXPECT_NE(unknown.err.find("did you mean \"validate\"?"), std::string::npos);
  const Ended misspelt = creepctl("submit job.toml --labels sand=NE34");
  EXPECT_EQ(misspelt.exit_code, kUsage);
  EXPECT_NE(misspelt.err.find("did you mean --label?"), std::string::npos) << misspelt.err;
  EXPECT_EQ(creepctl("submit --nonsense --help").exit_code, kOk);

  const Ended help = creepctl("--help");
  EXPECT_EQ(help.exit_code, kOk);
  const std::regex command_line("\n  ([a-z]+)  +[A-Z]");
  const std::string commands = help.out.substr(help.out.find("Subcommands:"));
  int seen = 0;
  for (std::sregex_iterator at(commands.begin(), commands.end(), command_line), end; at != end;
       ++at, ++seen) {
    const Ended one = creepctl((*at)[1].str() + " --help");
    EXPECT_EQ(one.exit_code, kOk);
    EXPECT_NE(one.out.find("creepctl " + (*at)[1].str(), one.out.find("Example:\n")), std::string::npos)
        << one.out;
  }
  EXPECT_GE(seen, 3);
}

TEST_F(JobCommands, version_says_the_formats_and_the_arithmetic_too) {
  const std::string line = creepctl("--version").out;
  EXPECT_TRUE(std::regex_match(line, std::regex("creepctl [0-9]+\\.[0-9]+\\.[0-9]+\n")));
  const std::string all = creepctl("version").out;
  EXPECT_TRUE(std::regex_match(all, std::regex(line.substr(0, line.size() - 1) +
                                               "\ncheckpoint format [0-9]+ \\(reads 1 to [0-9]+\\)\n"
                                               "sample log format [0-9]+\narithmetic [0-9a-f]{16}\n")))
      << all;
  const auto json = nlohmann::json::parse(creepctl("version --json").out);
  EXPECT_EQ(json["name"], "creepctl");
  EXPECT_EQ("creepctl " + json["version"].get<std::string>() + "\n", line);
  EXPECT_EQ(json["checkpoint_format"], creep::kCheckpointVersion);
  EXPECT_EQ(json["arithmetic_id"], creep::arithmetic_id("portable"));
}

/// The one place of the version: the newest entry of the changelog.
TEST_F(JobCommands, version_is_that_of_the_changelog) {
  std::ifstream changelog(CREEP_SOURCE_DIR "/deploy/debian/changelog");
  std::string entry;
  std::getline(changelog, entry);
  const std::string version(creep::program_version());
  EXPECT_TRUE(entry.starts_with("creepd (" + version + ") ")) << entry;
  EXPECT_EQ(creepctl("--version").out, "creepctl " + version + "\n");
}

/// The template with "# " taken from each key.
std::string all_keys_taken(const std::string& text) {
  return std::regex_replace(text, std::regex("(^|\n)# ([a-z_0-9]+ = )"), "$1$2");
}

TEST(JobTemplate, stays_valid_and_the_same_experiment_with_every_key_taken) {
  for (const std::string_view preset : creep::material_preset_names()) {
    const std::string text = job_template(preset);
    const creep::ParseResult as_written = creep::parse_experiment(text);
    const creep::ParseResult taken = creep::parse_experiment(all_keys_taken(text));
    ASSERT_TRUE(as_written.experiment) << as_written.errors[0].message;
    ASSERT_TRUE(taken.experiment) << taken.errors[0].line << ": " << taken.errors[0].message;
    EXPECT_EQ(as_written.experiment->material.preset, preset);
    // Two defaults depend on other keys and two are none, so the file gives them where the experiment has
    // none.
    creep::Experiment expected = *as_written.experiment;
    expected.numerics.breakages_per_ageing = 8;
    expected.numerics.drift_tolerance = 0.05;
    expected.numerics.inertial_number_limit = 1e-3;
    std::get<creep::CreepStage>(expected.program[1]).axial_stress = 21.7e6;
    EXPECT_EQ(creep::experiment_hash(*taken.experiment), creep::experiment_hash(expected));
  }
}

TEST(JobTemplate, has_every_key_that_a_job_file_can_have) {
  // An unknown key that is like no other makes the reader list those it knows.
  const std::string base = job_template("fontainebleau-ne34");
  const std::regex list("\\(allowed: ([^)]*)\\)");
  std::size_t keys = 0;
  for (const std::string section : {"[specimen]", "[material]", "[[program]]", "[numerics]", "[output]"}) {
    std::string text = base;
    text.insert(text.rfind("\n" + section + "\n") + 1 + section.size(), "\nqqqqqqqqqqqqqqqq = 1");
    const creep::ParseResult result = creep::parse_experiment(text);
    ASSERT_EQ(result.errors.size(), 1U) << section;
    std::smatch match;
    ASSERT_TRUE(std::regex_search(result.errors[0].message, match, list)) << result.errors[0].message;
    std::istringstream words(match[1].str());
    for (std::string word; std::getline(words, word, ',');) {
      word.erase(0, word.find_first_not_of(' '));
      EXPECT_NE(base.find(word + " = "), std::string::npos) << section << " " << word;
      ++keys;
    }
  }
  EXPECT_GE(keys, 40U);
}

TEST(GradingCsv, quantities_and_named_columns_give_the_same_points) {
  const std::string expected = "[[\"1e-04 m\", 0.0], [\"4e-04 m\", 1.0]]";
  for (const std::string_view text : {"0.1 mm,0\n0.4 mm,1\n", "diameter_mm;passing\n0.1;0\n0.4;1",
                                      "diameter_um\tpassing_percent\n100\t0\n\n400\t100\n",
                                      "diameter,passing\n\"100 um\",0\n\"0.4 mm\",1.0\n"}) {
    const GradingCsv csv = read_grading_csv(text);
    EXPECT_TRUE(csv.errors.empty()) << text;
    EXPECT_EQ(csv.points, expected) << text;
  }
  EXPECT_EQ(read_grading_csv("").errors.size(), 1U);
  EXPECT_EQ(read_grading_csv("0.1,0\n").errors.size(), 1U);  // no unit
}

}  // namespace
}  // namespace creepctl
