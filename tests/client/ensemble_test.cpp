// Several seeds of one job: their means, intervals, curves and pages.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "client/report/ensemble_charts.h"
#include "client/report/ensemble_page.h"
#include "client/results/ensemble.h"
#include "client/results/mean_curve.h"
#include "client/terminal/exit_codes.h"
#include "tests/client/job_folders.h"

namespace creepctl {
namespace {

// Student's t of 0.975, from the tables: of 1 and 2 degrees of freedom.
constexpr double kT1 = 12.706, kT2 = 4.303;

class EnsembleTest : public JobFolders {
 protected:
  std::vector<Ensemble> read() const {
    auto ensembles = read_ensembles({folder_.string()});
    EXPECT_TRUE(ensembles.ok()) << ensembles.status();
    return *std::move(ensembles);
  }
};

TEST(MeanCurve, has_the_interval_of_the_values_at_each_place) {
  std::vector<Curve> curves;
  for (const double slope : {1.0, 2.0, 3.0})
    curves.push_back({{1.0, 10.0, 1000.0}, {0.0, slope, 3.0 * slope}});
  const auto mean = mean_curve(curves, MeanOf::kValues);
  ASSERT_TRUE(mean);
  EXPECT_EQ(mean->count, 3U);
  ASSERT_EQ(mean->low.size(), mean->x.size());
  for (std::size_t i = 0; i < mean->x.size(); ++i) {
    const double decades = std::log10(mean->x[i]);
    EXPECT_NEAR(mean->mean[i], 2.0 * decades, 1e-12);
    // The standard deviation of 1, 2, 3 is 1; t to three decimals.
    EXPECT_NEAR(mean->high[i] - mean->mean[i], kT2 * decades / std::sqrt(3.0), 1e-3 * decades + 1e-12);
    EXPECT_NEAR(mean->mean[i] - mean->low[i], mean->high[i] - mean->mean[i], 1e-12);
  }
}

TEST(MeanCurve, ends_where_the_first_of_its_curves_ends) {
  const auto mean = mean_curve({{{1.0, 100.0}, {0.0, 1.0}}, {{10.0, 1000.0}, {0.0, 1.0}}}, MeanOf::kValues);
  ASSERT_TRUE(mean);
  EXPECT_NEAR(mean->x.front(), 10.0, 1e-9);
  EXPECT_NEAR(mean->x.back(), 100.0, 1e-9);
  EXPECT_FALSE(mean_curve({{{1.0, 2.0}, {0.0, 1.0}}, {{3.0, 4.0}, {0.0, 1.0}}}, MeanOf::kValues));
  EXPECT_FALSE(mean_curve({}, MeanOf::kValues));
}

TEST(MeanCurve, of_logarithms_is_geometric_and_leaves_out_what_has_none) {
  const auto mean = mean_curve({{{1.0, 5.0, 100.0}, {1.0, -3.0, 1.0}}, {{1.0, 100.0}, {100.0, 100.0}}},
                               MeanOf::kLogarithms);
  ASSERT_TRUE(mean);
  for (std::size_t i = 0; i < mean->x.size(); ++i) {
    EXPECT_NEAR(mean->mean[i], 10.0, 1e-9);
    // s of ln 1 and ln 100 is ln 100 / sqrt 2, so the half width is t ln 100 / 2; t to three decimals.
    EXPECT_NEAR(std::log(mean->high[i] / 10.0) / (kT1 * std::log(100.0) / 2.0), 1.0, 5e-5);
    EXPECT_GT(mean->low[i], 0.0);
  }
}

TEST(MeanCurve, of_one_is_itself_without_a_band) {
  const auto mean = mean_curve({{{1.0, 3.0, 100.0}, {0.0, 1.0, 4.0}}}, MeanOf::kValues);
  ASSERT_TRUE(mean);
  EXPECT_EQ(mean->mean, (std::vector<double>{0.0, 1.0, 4.0}));
  EXPECT_TRUE(mean->low.empty());
}

TEST(MeanText, shows_two_digits_of_the_half_width) {
  EXPECT_EQ(mean_text(creep::EnsembleMean{0.59234, 0.0061, 5}), "0.5923 ± 0.0061");
  EXPECT_EQ(mean_text(creep::EnsembleMean{0.0123, 0.0045, 5}, 100.0), "1.23 ± 0.45");
  EXPECT_EQ(mean_text(creep::EnsembleMean{12.4, 13.0, 2}), "12 ± 13");
  EXPECT_EQ(mean_text(creep::EnsembleMean{0.20000014, 5.8e-7, 2}, 100.0), "20.000 ± 0.000");
  EXPECT_EQ(mean_text(creep::EnsembleMean{-0.00012, 0.0035, 3}), "-0.0001 ± 0.0035");
  EXPECT_EQ(mean_text(creep::EnsembleMean{0.59234, {}, 1}), "0.5923");
  EXPECT_EQ(mean_text(std::nullopt), "–");
  EXPECT_EQ(geometric_mean_text(creep::EnsembleMean{std::log(0.002), std::log(2.0), 3}),
            "0.002 (0.001 to 0.004)");
}

TEST_F(EnsembleTest, jobs_that_differ_in_their_seed_alone_belong_together) {
  job("a/seed_1", {.m = 0.7, .seed = 1});
  job("a/seed_2", {.m = 0.8, .seed = 2});
  job("a/seed_3", {.m = 0.9, .seed = 3});
  job("a/again", {.m = 0.9, .seed = 3});
  job("a/seed_4", {.m = 0.9, .finished = false, .seed = 4});
  job("b", {.duration = "1 d", .seed = 1});
  job("packing", {.dynamic_stages = 0, .loaded = false, .seed = 2});
  const auto ensembles = read();
  ASSERT_EQ(ensembles.size(), 2U);
  EXPECT_EQ(ensembles[0].runs.size(), 3U);
  EXPECT_EQ(ensembles[0].repeated, 1U);
  EXPECT_EQ(ensembles[0].unfinished, 1U);
  EXPECT_EQ(ensembles[1].runs.size(), 1U);
  EXPECT_NE(ensembles[0].label, ensembles[1].label);
}

TEST_F(EnsembleTest, figures_are_the_means_of_those_of_the_runs) {
  double sum = 0.0, squares = 0.0, logs = 0.0;
  for (const int seed : {1, 2, 3}) {
    job("seed_" + std::to_string(seed), {.m = 0.6 + 0.1 * seed, .seed = seed});
    const ComparedFigures figures = compared_figures(read().front().runs.back());
    sum += *figures.m;
    squares += *figures.m * *figures.m;
    logs += std::log(*figures.rate_10_min);
  }
  const EnsembleFigures figures = ensemble_figures(read().front());
  const double mean = sum / 3.0;
  EXPECT_NEAR(figures.m->mean, mean, 1e-12);
  EXPECT_NEAR(figures.m->mean, 0.8, 0.05);  // as made; the fit of such curves is that far off
  // t to three decimals.
  EXPECT_NEAR(*figures.m->half_width, kT2 * std::sqrt((squares - 3.0 * mean * mean) / 2.0) / std::sqrt(3.0),
              1e-4);
  EXPECT_NEAR(figures.ln_rate_10_min->mean, logs / 3.0, 1e-12);
  EXPECT_EQ(figures.stages->mean, 15.0);
  EXPECT_EQ(figures.stages->half_width, 0.0);
  EXPECT_FALSE(figures.ln_time_to_failure);
  EXPECT_FALSE(figures.paper) << "an oedometer is none of the paper's triaxial tests";
}

TEST_F(EnsembleTest, charts_have_a_band_for_several_runs_and_none_for_one) {
  const auto bands_in = [](const Chart& chart) {
    return std::count_if(chart.series.begin(), chart.series.end(),
                         [](const Series& series) { return series.shape == Shape::kBand; });
  };
  job("seed_1", {.m = 0.7, .seed = 1});
  auto charts = ensemble_charts(read(), {});
  ASSERT_EQ(charts.size(), 3U);
  for (const NamedChart& chart : charts) EXPECT_EQ(bands_in(chart.chart), 0) << chart.file_stem;
  job("seed_2", {.m = 0.8, .seed = 2});
  charts = ensemble_charts(read(), {});
  ASSERT_EQ(charts.size(), 3U);
  for (const NamedChart& chart : charts) EXPECT_EQ(bands_in(chart.chart), 1) << chart.file_stem;
  // A band of two seeds is twelve times as wide as they are apart: the curves still fill a third of the
  // chart.
  const Layout placed = layout(charts[0].chart);
  double top = 1e9, bottom = 0.0;
  for (std::size_t i = 0; i < charts[0].chart.series.size(); ++i) {
    if (charts[0].chart.series[i].shape == Shape::kBand) continue;
    for (const PlacedPoint& point : placed.points[i]) {
      top = std::min(top, point.at.y);
      bottom = std::max(bottom, point.at.y);
    }
  }
  EXPECT_GT(bottom - top, placed.plot.height / 3.0);
}

TEST_F(EnsembleTest, a_page_of_single_runs_says_that_one_run_has_no_uncertainty) {
  job("seed_1", {.seed = 1});
  EXPECT_NE(ensemble_page("one", read()).find("One run has no uncertainty"), std::string::npos);
  job("seed_2", {.m = 0.9, .seed = 2});
  const std::string page = ensemble_page("two", read());
  EXPECT_EQ(page.find("One run has no uncertainty"), std::string::npos);
  EXPECT_NE(page.find("n = 2"), std::string::npos);
  EXPECT_NE(page.find(" ± "), std::string::npos);
  EXPECT_NE(page.find("0.584"), std::string::npos)
      << "the paper's void ratio, of whose oedometer these are trials";
}

TEST_F(EnsembleTest, figures_of_the_papers_oedometer_stand_beside_trials_of_it_and_no_others) {
  job("seed_1", {.axial_stress = "20 MPa", .seed = 1});
  EXPECT_EQ(ensemble_page("other", read()).find("0.584"), std::string::npos);
}

TEST_F(EnsembleTest, plot_report_and_compare_take_the_folder_of_a_sweep) {
  for (const int seed : {1, 2, 3})
    job("sweep/seed_" + std::to_string(seed),
        {.noise = 0.2, .noise_seed = static_cast<unsigned>(seed), .seed = seed});
  ASSERT_EQ(creepctl("plot sweep --format svg"), kOk) << text("err");
  EXPECT_NE(text("sweep/plots/mean_creep_rate_log_time.svg").find("<svg"), std::string::npos);
  ASSERT_EQ(creepctl("report sweep"), kOk) << text("err");
  EXPECT_NE(text("out").find("n = 3"), std::string::npos) << text("out");
  EXPECT_NE(text("sweep/report.html").find("</html>"), std::string::npos);
  ASSERT_EQ(creepctl("compare sweep --mean --json"), kOk) << text("err");
  const auto list = nlohmann::json::parse(text("out"));
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0]["directories"].size(), 3U);
  EXPECT_EQ(list[0]["creep_strain"]["n"], 3);
  EXPECT_LT(list[0]["creep_strain"]["low"], list[0]["creep_strain"]["mean"]);
  EXPECT_TRUE(list[0]["time_to_failure_s"].is_null());
  ASSERT_EQ(creepctl("compare sweep --json"), kOk) << text("err");
  EXPECT_EQ(nlohmann::json::parse(text("out")).size(), 3U);

  ASSERT_EQ(creepctl("report sweep/seed_1"), kOk) << text("err");  // of one job: as ever
  EXPECT_NE(text("out").find("e after packing"), std::string::npos) << text("out");
  EXPECT_EQ(creepctl("report sweep/seed_1 sweep/seed_2"), kUsage);
  EXPECT_NE(text("err").find("--out"), std::string::npos);
  EXPECT_EQ(creepctl("report sweep/seed_1 sweep/seed_2 --out two.html"), kOk) << text("err");
  EXPECT_EQ(creepctl("compare nowhere --mean"), kInvalidInput);
  EXPECT_NE(text("err").find("nowhere"), std::string::npos);
}

}  // namespace
}  // namespace creepctl
