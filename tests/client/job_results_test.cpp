#include "client/results/job_results.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "client/report/report_page.h"
#include "client/report/result_charts.h"
#include "client/results/broken_fraction.h"
#include "client/results/hold.h"
#include "tests/client/synthetic_job.h"

namespace creepctl {
namespace {

class JobResultsTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    directory_ = std::filesystem::path(testing::TempDir()) / (std::string("job_results_") + test->name());
    std::filesystem::remove_all(directory_);
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  JobResults made(const SyntheticJob& job) {
    write_synthetic_job(directory_, job);
    auto results = read_job_results(directory_);
    EXPECT_TRUE(results.ok()) << results.status();
    return *std::move(results);
  }

  std::filesystem::path directory_;
};

TEST(NumberTable, ReadsByNameAndKeepsFurtherColumns) {
  const auto table = NumberTable::parse("a,later,b\n1,7,2.5e-3\n-4,8,nan\n", "t.csv");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->rows(), 2u);
  EXPECT_EQ(table->at(0, "b"), 2.5e-3);
  EXPECT_EQ(table->at(1, "later"), 8.0);
  EXPECT_TRUE(std::isnan(table->at(1, "b")));
  EXPECT_TRUE(std::isnan(table->at(0, "missing")));
  EXPECT_TRUE(std::isnan(table->at(9, "a")));
  EXPECT_TRUE(table->column("missing").empty());
}

TEST(NumberTable, LeavesOutALineStillBeingWritten) {
  const auto table = NumberTable::parse("a,b\n1,2\n3,", "t.csv");
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->rows(), 1u);
  EXPECT_EQ(NumberTable::parse("", "t.csv")->rows(), 0u);
}

TEST(NumberTable, NamesTheLineThatIsDamaged) {
  const auto longer = NumberTable::parse("a,b\n1,2\n1,2,3\n", "t.csv");
  EXPECT_NE(std::string(longer.status().message()).find("t.csv:3:"), std::string::npos);
  const auto word = NumberTable::parse("a,b\n1,two\n", "t.csv");
  EXPECT_NE(std::string(word.status().message()).find("'two' is no number"), std::string::npos);
}

TEST_F(JobResultsTest, RefusesWhatIsNoJobDirectory) {
  EXPECT_TRUE(absl::IsNotFound(read_job_results(directory_).status()));
  std::filesystem::create_directories(directory_);
  EXPECT_TRUE(absl::IsInvalidArgument(read_job_results(directory_).status()));
}

TEST_F(JobResultsTest, RefusesADamagedSummary) {
  write_synthetic_job(directory_, {});
  std::ofstream(directory_ / "summary.json") << "{\"outcome\": ";
  EXPECT_TRUE(absl::IsInvalidArgument(read_job_results(directory_).status()));
}

TEST_F(JobResultsTest, HoldCountsStrainFromItsBeginningAndFindsTheSlope) {
  SyntheticJob job;
  const JobResults results = made(job);
  const auto hold = last_hold(results);
  ASSERT_TRUE(hold);
  EXPECT_EQ(hold->stage_rows.size(), 16u);
  EXPECT_EQ(hold->ageing_jumps(), 15u);
  // The initial dynamic stage strains by 2e-4; 1e-12 is for the sums of increments.
  EXPECT_NEAR(hold->curve.axial_strain.front(), 2e-4, 1e-12);
  EXPECT_NEAR(hold->curve.axial_strain.back(),
              2e-4 + synthetic_creep_strain(job, hold->curve.creep_time.back()), 2e-8);
  ASSERT_TRUE(hold->analysis.primary_fit);
  // Stage ends lie equally in log time but for the first, moved by the length of a dynamic stage.
  EXPECT_NEAR(hold->analysis.primary_fit->m, 0.8, 1e-3);
  EXPECT_NEAR(hold->analysis.primary_fit->rate(600.0) / (2e-4 * std::pow(600.0, -0.8)), 1.0, 0.01);
}

TEST_F(JobResultsTest, ComparesWithThePaperOnlyWhereTheSceneIsThePapers) {
  const auto compare = [&](const SyntheticJob& job) {
    std::filesystem::remove_all(directory_);
    const JobResults results = made(job);
    return comparisons(results, last_hold(results));
  };
  for (const Comparison& line : compare({})) EXPECT_NE(line.paper, "–") << line.quantity;
  SyntheticJob other_stress;
  other_stress.axial_stress = "10 MPa";
  for (const Comparison& line : compare(other_stress)) {
    EXPECT_EQ(line.paper, "–") << line.quantity;
    EXPECT_EQ(line.difference, "–") << line.quantity;
  }
  SyntheticJob longer;
  longer.duration = "20 d";
  const auto lines = compare(longer);
  EXPECT_EQ(lines[1].paper, "0.584");
  EXPECT_EQ(lines[3].paper, "–");
}

TEST_F(JobResultsTest, CountsStagesOfAnUnfinishedHoldWithoutJudgingThem) {
  SyntheticJob job;
  job.finished = false;
  const JobResults results = made(job);
  const auto lines = comparisons(results, last_hold(results));
  EXPECT_EQ(lines[3].run, "15");
  EXPECT_EQ(lines[3].difference, "–");
}

TEST_F(JobResultsTest, HasChartsAtEveryStateOfARun) {
  SyntheticJob packing;
  packing.loaded = false;
  packing.finished = false;
  const JobResults packed = made(packing);
  EXPECT_FALSE(last_hold(packed));
  EXPECT_EQ(result_charts(packed, std::nullopt).size(), 1u);  // the initial grading

  std::filesystem::remove_all(directory_);
  SyntheticJob initial_stage;
  initial_stage.dynamic_stages = 0;
  const JobResults early = made(initial_stage);
  for (const NamedChart& chart : result_charts(early, last_hold(early)))
    EXPECT_NE(chart.file_stem, "creep_rate_log_time");

  std::filesystem::remove_all(directory_);
  const JobResults whole = made({});
  EXPECT_EQ(result_charts(whole, last_hold(whole)).size(), 7u);
}

TEST_F(JobResultsTest, BrokenFractionIsBrokenOverPresentNumberOfAClass) {
  std::filesystem::create_directories(directory_);
  std::ofstream(directory_ / "job.toml") << "\n";
  // All mass between 0.1 and 0.4 mm (geometric mean 0.2 mm) at first; later half of it between 0.05 and 0.1
  // mm.
  std::ofstream(directory_ / "gsd.csv") << "curve,creep_time_s,diameter_m,passing\n"
                                        << "0,0,5e-5,0\n0,0,1e-4,0\n0,0,4e-4,1\n"
                                        << "1,10,5e-5,0\n1,10,1e-4,0.5\n1,10,4e-4,1\n";
  std::ofstream(directory_ / "samples.csv") << "broken_total,particles\n0,1000\n2,1026\n";
  std::ofstream(directory_ / "breakages.csv")
      << "creep_time_s,diameter_m\n0,1.9e-4\n5,1.9e-4\n20,1.9e-4\n5,3.9e-4\n";
  const auto results = read_job_results(directory_);
  ASSERT_TRUE(results.ok()) << results.status();
  const auto classes = broken_fractions(*results);
  ASSERT_EQ(classes.size(), 1u);  // only the class of 0.2 mm holds particles
  ASSERT_EQ(classes[0].fraction.size(), 1u);
  EXPECT_LE(classes[0].smallest, 0.2e-3);
  EXPECT_GT(classes[0].largest, 0.2e-3);
  // Two broken by 10 s, 500 of 1000 left.
  EXPECT_NEAR(classes[0].fraction[0], 2.0 / 500.0, 1e-12);
}

TEST(DurationText, ChoosesTheUnitOfTheTrade) {
  EXPECT_EQ(duration_text(172800.0), "2 d");
  EXPECT_EQ(duration_text(9000.0), "2.5 h");
  EXPECT_EQ(duration_text(90.0), "1.5 min");
  EXPECT_EQ(duration_text(0.0011), "1.1 ms");
}

}  // namespace
}  // namespace creepctl
