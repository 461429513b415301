// plan: what is extrapolated, and how near it comes to a real run.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "client/results/job_results.h"
#include "client/terminal/exit_codes.h"
#include "core/experiment/experiment_toml.h"
#include "core/experiment/fidelity.h"
#include "core/plan/plan.h"

namespace creepctl {
namespace {

namespace fs = std::filesystem;
using creep::make_plan;
using creep::Pilot;
using creep::Range;

std::string job_text(int particles, const std::string& numerics) {
  return "[specimen]\nparticles = " + std::to_string(particles) +
         "\n[[program]]\nstage = \"oedometric\"\nuntil = { axial_stress = \"21.7 MPa\" }\n"
         "[[program]]\nstage = \"creep\"\nduration = \"1 h\"\n[numerics]\n" +
         numerics;
}

creep::Experiment job(int particles, const std::string& numerics) {
  return *creep::parse_experiment(job_text(particles, numerics)).experiment;
}

/// 1500 particles, 11 dynamic stages with n_age 4.
Pilot pilot() {
  Pilot took;
  took.particles = 1500;
  took.loading_velocity = 1.0;
  took.breakages = 4;
  took.packing_cycles = 50'000;
  took.packing_speed = took.speed = 2e7;
  took.stages.resize(2);
  took.stages[0] = {.loading_cycles = 4000, .time_step = 2e-8, .shortening = 0.03, .growth = 1.2};
  took.stages[1] = {.time_step = 1.5e-8, .dynamic_stages = 11, .dynamic_cycles = 2000, .growth = 1.5};
  return took;
}

TEST(Plan, stages_go_with_the_particles_over_n_age) {
  EXPECT_DOUBLE_EQ(
      make_plan(job(1500, "breakages_per_ageing = 4\n"), pilot()).stages[1].dynamic_stages.expected, 11);
  EXPECT_DOUBLE_EQ(
      make_plan(job(15000, "breakages_per_ageing = 40\n"), pilot()).stages[1].dynamic_stages.expected, 11);
  EXPECT_DOUBLE_EQ(
      make_plan(job(3000, "breakages_per_ageing = 1\n"), pilot()).stages[1].dynamic_stages.expected, 81);
  const Range count = make_plan(job(1500, "breakages_per_ageing = 4\n"), pilot()).stages[1].dynamic_stages;
  EXPECT_LT(count.least, count.expected);
  EXPECT_GT(count.most, count.expected);
}

TEST(Plan, a_dynamic_stage_is_no_shorter_than_the_job_asks_for_nor_than_it_settles) {
  const std::string n_age = "breakages_per_ageing = 4\n";
  EXPECT_DOUBLE_EQ(make_plan(job(1500, n_age), pilot()).stages[1].cycles, 11 * 150'000.0);
  EXPECT_DOUBLE_EQ(make_plan(job(1500, n_age + "minimum_cycles = 300\n"), pilot()).stages[1].cycles,
                   11 * 2000.0);
}

TEST(Plan, loading_at_a_tenth_of_the_velocity_takes_the_way_over_the_velocity) {
  // Edge of 1500 grains of 0.21 mm at e = 0.65: about 2.2 mm; 3 % of it at 0.1 m/s in steps of 2e-8 s.
  const double slow = make_plan(job(1500, ""), pilot()).stages[0].cycles;
  EXPECT_NEAR(slow, 0.03 * 2.2e-3 / (0.1 * 2e-8), 0.2 * slow);
  EXPECT_NEAR(make_plan(job(1500, "loading_velocity = \"0.05 m/s\"\n"), pilot()).stages[0].cycles, 2 * slow,
              1.0);
  EXPECT_DOUBLE_EQ(make_plan(job(1500, "loading_velocity = \"10 m/s\"\n"), pilot()).stages[0].cycles, 4000);
}

TEST(Plan, the_error_is_that_of_the_fidelity_unless_a_key_is_overridden) {
  const double fast = creep::fidelity_measure(*creep::fidelity_index("fast")).error;
  EXPECT_EQ(make_plan(job(3000, "fidelity = \"fast\"\n"), pilot()).error, fast);
  EXPECT_EQ(make_plan(job(3000, "fidelity = \"fast\"\nskin = \"3 um\"\n"), pilot()).error, fast);
  EXPECT_FALSE(make_plan(job(3000, "fidelity = \"fast\"\nlocal_damping = 0.3\n"), pilot()).error);
}

TEST(Plan, memory_is_what_a_worker_was_seen_to_take) {
  // The shipped example: 17.8 MB at its highest, 3 000 grains and 5 000 at the end.
  Pilot took = pilot();
  took.stages[1].growth = 5.0 / 3.0;
  EXPECT_NEAR(make_plan(job(3000, ""), took).memory, 17760 * 1024.0, 2e6);
}

class PlanCommand : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "plan-test-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Exit code; stdout goes to the file `out`.
  int creepctl(const std::string& arguments) const {
    const std::string line =
        "cd '" + folder_.string() + "' && TMPDIR=. '" CREEPCTL_PATH "' " + arguments + " >out 2>err";
    const int status = std::system(line.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  void write(const std::string& text) const { std::ofstream(folder_ / "job.toml") << text; }
  nlohmann::json out() const {
    std::ifstream file(folder_ / "out");
    return nlohmann::json::parse(file);
  }
  const fs::path& folder() const { return folder_; }

 private:
  fs::path folder_;
};

TEST_F(PlanCommand, a_run_comes_out_within_a_factor_of_two_of_its_plan) {
  write(job_text(400, "minimum_cycles = 6000\nbreakages_per_ageing = 1\n"));
  ASSERT_EQ(creepctl("plan job.toml --json --threads 1"), kOk);
  const nlohmann::json plan = out();
  for (const auto& entry : fs::directory_iterator(folder())) {
    EXPECT_FALSE(entry.is_directory()) << entry.path() << " was left";
  }
  ASSERT_EQ(creepctl("run job.toml --out run --threads 1 --json"), kOk);
  std::ostringstream text;
  text << std::ifstream(folder() / "run" / "stage_timings.csv").rdbuf();
  const auto costs = NumberTable::parse(text.str(), "stage_timings.csv");
  ASSERT_TRUE(costs.ok());
  double packing = 0.0, loading = 0.0, hold = 0.0, seconds = 0.0;
  for (std::size_t row = 0; row < costs->rows(); ++row) {
    const double at = costs->at(row, "stage_row");
    (at < 0.0 ? packing : at < 1.0 ? loading : hold) += costs->at(row, "particle_steps");
    seconds += costs->at(row, "wall_seconds");
  }
  const auto expect_near = [](double planned, double real, double factor, const char* what) {
    EXPECT_GT(planned, real / factor) << what;
    EXPECT_LT(planned, real * factor) << what;
  };
  expect_near(plan["packing_particle_steps"], packing, 2.0, "packing");
  expect_near(plan["stages"][0]["particle_steps"], loading, 2.0, "loading");
  expect_near(plan["stages"][1]["particle_steps"], hold, 2.0, "hold");
  const double stages = static_cast<double>(costs->rows()) - 2.0;
  EXPECT_GE(stages, plan["stages"][1]["dynamic_stages"]["least"]);
  EXPECT_LE(stages, plan["stages"][1]["dynamic_stages"]["most"]);
  // Seconds of a machine on which other tests start and end meanwhile.
  expect_near(plan["wall_seconds"]["expected"], seconds, 10.0, "seconds");
}

TEST_F(PlanCommand, what_cannot_be_planned_exits_5_in_words) {
  write("[start]\njob = \"there\"\n[[program]]\nstage = \"creep\"\nduration = \"1 h\"\n");
  EXPECT_EQ(creepctl("plan job.toml"), kInvalidInput);
  write(job_text(400, "fidelity = \"fest\"\n"));
  EXPECT_EQ(creepctl("plan job.toml"), kInvalidInput);
  EXPECT_EQ(creepctl("plan nowhere.toml"), kInvalidInput);
  EXPECT_EQ(creepctl("plan"), kUsage);
}

TEST_F(PlanCommand, a_specimen_that_a_guard_stops_exits_1) {
  write(job_text(400, "time_step_safety = 1.0\nlocal_damping = 0.0\nloading_velocity = \"10 m/s\"\n"));
  EXPECT_EQ(creepctl("plan job.toml"), kFailed);
}

}  // namespace
}  // namespace creepctl
