// What a sweep goes through, from the command line to the job files.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "client/sweep/sweep_end.h"
#include "client/sweep/sweep_plan.h"
#include "core/experiment/experiment_toml.h"

namespace creepctl {
namespace {

constexpr const char* kShear =
    "name = \"sand\"\n[specimen]\nparticles = 3000\nseed = 4\n"
    "[[program]]\nstage = \"isotropic\"\nuntil.mean_stress = \"10 MPa\"\n"
    "[[program]]\nstage = \"triaxial\"\nuntil = { q_ratio = 0.4, q_max = \"20 MPa\" }\n"
    "[[program]]\nstage = \"creep\"\nduration = \"1 h\"\n"
    "[[program]]\nstage = \"relaxation\"\nduration = \"1 h\"\n";

JobFile job_file(const std::string& text) {
  JobFile job;
  job.path = "sand.toml";
  job.text = text;
  job.experiment = creep::parse_experiment(text).experiment;
  EXPECT_TRUE(job.experiment) << text;
  return job;
}

creep::Experiment experiment_of(const SweepJob& job) {
  const auto text = job.trunk ? started_from(job, "trunk") : absl::StatusOr<std::string>(job.text);
  EXPECT_TRUE(text.ok()) << text.status();
  const auto parsed = creep::parse_experiment(*text);
  EXPECT_TRUE(parsed.experiment) << *text;
  return *parsed.experiment;
}

std::string refusal(const std::string& text, const SweepRequest& request) {
  const auto jobs = plan_sweep(job_file(text), request);
  return jobs.ok() ? "" : std::string(jobs.status().message());
}

using Seeds = std::vector<std::int64_t>;

TEST(SweepValues, seeds_are_a_count_a_range_or_a_list) {
  EXPECT_EQ(*parse_seeds("3"), (Seeds{1, 2, 3}));
  EXPECT_EQ(*parse_seeds("4..6"), (Seeds{4, 5, 6}));
  EXPECT_EQ(*parse_seeds("7, 0,2..3"), (Seeds{7, 0, 2, 3}));
  EXPECT_EQ(*parse_seeds("9..9"), (Seeds{9}));
  for (const std::string wrong : {"", "0", "-1", "3..1", "1..", "..3", "1,,2", "x", "1.5", "1,1", "1..2000",
                                  "1,2 3", "99999999999999999999", "0..9223372036854775807"}) {
    EXPECT_FALSE(parse_seeds(wrong).ok()) << wrong;
  }
}

TEST(SweepValues, ratios_lie_above_0_and_at_most_at_2) {
  EXPECT_EQ(*parse_stress_ratios("0.2, 0.75"), (std::vector<double>{0.2, 0.75}));
  for (const std::string wrong : {"", "0", "2.1", "nan", "0.2,,0.4", "0.2;0.4", "0.2,0.2", "20 %"}) {
    EXPECT_FALSE(parse_stress_ratios(wrong).ok()) << wrong;
  }
}

TEST(SweepValues, commas_inside_a_value_belong_to_it) {
  const auto varied = parse_varied_key(R"(specimen.grading={ preset = "a,b" },"x,\"y", [1, 2] ,2 d)");
  ASSERT_TRUE(varied.ok()) << varied.status();
  EXPECT_EQ(varied->key, "specimen.grading");
  EXPECT_EQ(varied->values,
            (std::vector<std::string>{R"({ preset = "a,b" })", R"("x,\"y")", "[1, 2]", "2 d"}));
  for (const std::string wrong : {"", "a", "=1", "a=", "a=1,,2", "a=1,1", "specimen.seed=1,2"}) {
    EXPECT_FALSE(parse_varied_key(wrong).ok()) << wrong;
  }
}

TEST(SweepPlan, without_ratios_every_combination_is_a_job_of_its_own) {
  SweepRequest request;
  request.seeds = {1, 2};
  request.varied = {{"numerics.minimum_cycles", {"20000", "40000"}}, {"program.2.duration", {"2 h", "1 d"}}};
  const auto jobs = plan_sweep(job_file(kShear), request);
  ASSERT_TRUE(jobs.ok()) << jobs.status();
  ASSERT_EQ(jobs->size(), 8U);
  EXPECT_EQ((*jobs)[0].name, "seed_1/minimum_cycles_20000/duration_2h");
  EXPECT_EQ((*jobs)[7].name, "seed_2/minimum_cycles_40000/duration_1d");
  for (const SweepJob& job : *jobs) EXPECT_FALSE(job.trunk || job.is_trunk);
  creep::Experiment last = experiment_of((*jobs)[7]);
  EXPECT_EQ(last.specimen.seed, 2U);
  EXPECT_EQ(last.numerics.minimum_cycles, 40000);
  EXPECT_EQ(std::get<creep::CreepStage>(last.program[2]).duration, 86400.0);
}

TEST(SweepPlan, the_jobs_of_a_seed_branch_from_one_trunk_sheared_a_little_beyond_the_largest_ratio) {
  SweepRequest request;
  request.stress_ratios = {0.3, 0.75};
  const auto jobs = plan_sweep(job_file(kShear), request);
  ASSERT_TRUE(jobs.ok()) << jobs.status();
  ASSERT_EQ(jobs->size(), 3U);
  const creep::Experiment trunk = experiment_of((*jobs)[0]);
  EXPECT_TRUE((*jobs)[0].is_trunk);
  ASSERT_EQ(trunk.program.size(), 2U);
  EXPECT_EQ(trunk.specimen.seed, 4U);
  const auto& shear = std::get<creep::TriaxialStage>(trunk.program[1]);
  EXPECT_NEAR(shear.keep->step, 0.15 * 20e6, 1e-3);  // Pa: the largest step of which both are multiples
  EXPECT_NEAR(shear.until.value, (5 + 0.1) * 0.15 * 20e6, 1e-3);
  EXPECT_EQ((*jobs)[2].name, "seed_4/q_0.75");
  EXPECT_EQ((*jobs)[2].trunk, 0U);
  EXPECT_EQ((*jobs)[2].checkpoint, "02_triaxial_deviatoric_stress_15MPa");
  const creep::Experiment branch = experiment_of((*jobs)[2]);
  ASSERT_EQ(branch.program.size(), 2U);
  EXPECT_NEAR(*std::get<creep::CreepStage>(branch.program[0]).deviatoric_stress, 15e6, 1e-6);
  EXPECT_EQ(creep::stage_name(branch.program[1]), "relaxation");
  EXPECT_EQ(creep::specimen_hash(branch), creep::specimen_hash(trunk));
}

TEST(SweepPlan, what_changes_only_the_branches_shares_their_trunk) {
  SweepRequest request;
  request.stress_ratios = {0.4};
  request.varied = {{"program.2.duration", {"1 h", "2 h"}}};
  auto jobs = plan_sweep(job_file(kShear), request);
  ASSERT_TRUE(jobs.ok()) << jobs.status();
  ASSERT_EQ(jobs->size(), 3U);
  EXPECT_EQ((*jobs)[1].trunk, (*jobs)[2].trunk);
  request.varied = {{"numerics.minimum_cycles", {"20000", "40000"}}};
  jobs = plan_sweep(job_file(kShear), request);
  ASSERT_EQ(jobs->size(), 4U);
  EXPECT_NE((*jobs)[1].trunk, (*jobs)[3].trunk);
  EXPECT_NE((*jobs)[0].name, (*jobs)[2].name);
}

TEST(SweepPlan, the_strength_given_goes_before_that_of_the_file) {
  SweepRequest request;
  request.stress_ratios = {0.5};
  request.q_max = "30 MPa";
  const auto jobs = plan_sweep(job_file(kShear), request);
  ASSERT_TRUE(jobs.ok()) << jobs.status();
  EXPECT_EQ((*jobs)[1].checkpoint, "02_triaxial_deviatoric_stress_15MPa");
}

TEST(SweepPlan, what_cannot_be_is_refused_by_the_name_of_its_option) {
  const std::string oedometer =
      "[specimen]\nparticles = 3000\n[[program]]\nstage = \"oedometric\"\nuntil.axial_stress = \"2 MPa\"\n"
      "[[program]]\nstage = \"creep\"\nduration = \"1 h\"\n";
  const std::string shear(kShear);
  SweepRequest ratios;
  ratios.stress_ratios = {0.4};
  EXPECT_NE(refusal(oedometer, ratios).find("--stress-ratio: sand.toml has no triaxial"), std::string::npos);
  EXPECT_NE(
      refusal(shear.substr(0, shear.find("[[program]]\nstage = \"creep")), ratios).find("nothing follows"),
      std::string::npos);
  EXPECT_NE(refusal(shear + "[start]\njob = \"x\"\n", ratios).find("[start]"), std::string::npos);
  std::string without = shear;
  without.replace(without.find("q_ratio = 0.4, q_max = \"20 MPa\""), 31, "deviatoric_stress = \"8 MPa\"");
  EXPECT_NE(refusal(without, ratios).find("--q-max"), std::string::npos);
  ratios.q_max = "22 m";
  EXPECT_NE(refusal(shear, ratios).find("--q-max"), std::string::npos);
  ratios.q_max = "";
  ratios.stress_ratios = {0.333, 0.4};
  EXPECT_NE(refusal(shear, ratios).find("rounder ratios"), std::string::npos);
  SweepRequest key;
  key.varied = {{"numerics.minimum_cycle", {"1"}}};
  EXPECT_NE(refusal(shear, key).find("minimum_cycles"), std::string::npos);
  SweepRequest many;
  for (std::int64_t seed = 0; seed < 600; ++seed) many.seeds.push_back(seed);
  many.varied = {{"program.2.duration", {"1 h", "2 h"}}};
  EXPECT_NE(refusal(shear, many).find("more than 1000"), std::string::npos);
  SweepRequest only_strength;
  only_strength.q_max = "20 MPa";
  EXPECT_NE(refusal(shear, only_strength).find("--q-max"), std::string::npos);
}

TEST(SweepEnd, one_failure_decides_how_the_sweep_ends) {
  std::vector<SweepEnd> ends = {{"a", "", true, kOk, "completed"}, {"b", "", true, kOk, "completed"}};
  EXPECT_EQ(exit_code_of(ends), kOk);
  ends.push_back({"c", "", false, kRunAgain, "stopped"});
  EXPECT_EQ(exit_code_of(ends), kRunAgain);
  ends.push_back({"d", "x/d", true, kFailed, "a guard"});
  EXPECT_EQ(exit_code_of(ends), kFailed);
  const std::string text = summary_text(ends, 0);
  EXPECT_NE(text.find("x/d"), std::string::npos) << text;
  EXPECT_NE(text.find("2 of 4 jobs are done"), std::string::npos) << text;
  EXPECT_EQ(text.find("completed"), std::string::npos) << text;
}

}  // namespace
}  // namespace creepctl
