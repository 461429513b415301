// compare: jobs in one picture, beside a laboratory's curve and the paper's table.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "client/report/overlay.h"
#include "client/terminal/exit_codes.h"
#include "tests/client/job_folders.h"

namespace creepctl {
namespace {

using Compare = JobFolders;

TEST_F(Compare, every_job_has_its_curve_and_the_laboratory_its_points_in_per_cent) {
  const auto jobs = read_compared_jobs({job("a", {.m = 0.8}), job("b", {.m = 0.9})});
  ASSERT_TRUE(jobs.ok()) << jobs.status();
  EXPECT_NE((*jobs)[0].label, (*jobs)[1].label);
  const auto curve =
      parse_laboratory_curve("# oedometer\r\nage_s,axial_strain\r\n10,0.001\r\n100,0.002\r\n", "lab");
  ASSERT_TRUE(curve.ok()) << curve.status();
  const auto charts = overlay_charts(*jobs, {*curve});
  ASSERT_EQ(charts.size(), 3U);
  ASSERT_EQ(charts[0].chart.series.size(), 3U);
  EXPECT_EQ(charts[0].chart.series[2].x, (std::vector<double>{10, 100}));
  EXPECT_EQ(charts[0].chart.series[2].y, (std::vector<double>{0.1, 0.2}));
  for (std::size_t i : {1U, 2U}) ASSERT_EQ(charts[i].chart.series.size(), 2U) << charts[i].file_stem;
  for (const NamedChart& chart : charts) {
    EXPECT_NE(chart.chart.series[0].hue, chart.chart.series[1].hue);
  }
  const Series& first = charts[0].chart.series[0];
  EXPECT_NEAR(first.y.back() - first.y[1],
              100.0 * (synthetic_creep_strain({.m = 0.8}, first.x.back()) -
                       synthetic_creep_strain({.m = 0.8}, first.x[1])),
              1e-6);
}

TEST_F(Compare, the_table_has_the_slope_each_job_was_made_with) {
  job("a", {.m = 0.8});
  job("b", {.m = 0.9});
  ASSERT_EQ(creepctl("compare a b --json"), kOk) << text("err");
  const auto list = nlohmann::json::parse(text("out"));
  ASSERT_EQ(list.size(), 2U);
  EXPECT_NEAR(list[0]["singh_mitchell_m"], 0.8, 0.05);
  EXPECT_NEAR(list[1]["singh_mitchell_m"], 0.9, 0.05);
  EXPECT_TRUE(list[0]["paper"].is_null());  // an oedometer is none of the paper's triaxial tests
}

TEST_F(Compare, a_job_at_a_stress_ratio_of_the_paper_has_its_row_beside_it_and_no_other) {
  JobResults results;
  results.samples = *NumberTable::parse(
      "radial_stress_Pa,deviatoric_stress_Pa\n1.001e7,9.0e6\n0.999e7,9.1e6\n1e7,1.4e7\n9e6,9.04e6\n",
      "samples.csv");
  Hold hold;
  hold.sample_rows = {0, 1};
  const auto test = paper_triaxial_creep(results, hold);
  ASSERT_TRUE(test);
  EXPECT_EQ(test->stress_ratio, 0.4);
  EXPECT_EQ(test->m, 0.7903);
  hold.sample_rows = {2};
  EXPECT_FALSE(paper_triaxial_creep(results, hold)) << "q/q_max = 0.62";
  hold.sample_rows = {3};
  EXPECT_FALSE(paper_triaxial_creep(results, hold)) << "9 MPa of lateral stress";
}

TEST_F(Compare, charts_are_written_and_what_is_no_job_or_curve_exits_5_by_name) {
  job("a", {});
  job("packing", {.dynamic_stages = 0, .loaded = false, .finished = false});
  write("lab.csv", "age_s,axial_strain\n60,0.002\n");
  ASSERT_EQ(creepctl("compare a packing --laboratory lab.csv --out charts --format svg"), kOk) << text("err");
  EXPECT_NE(text("charts/compared_creep_strain_log_time.svg").find("<svg"), std::string::npos);
  EXPECT_EQ(creepctl("compare a nowhere"), kInvalidInput);
  EXPECT_NE(text("err").find("nowhere"), std::string::npos);
  for (const std::string bad :
       {"age_s,strain\n60,0.002\n", "age_s,axial_strain\n", "age_s,axial_strain\n60,x\n", ""}) {
    write("lab.csv", bad);
    EXPECT_EQ(creepctl("compare a --laboratory lab.csv"), kInvalidInput) << bad;
    EXPECT_NE(text("err").find("lab.csv"), std::string::npos) << text("err");
  }
  EXPECT_EQ(creepctl("compare"), kUsage);
}

}  // namespace
}  // namespace creepctl
