// creepctl plot and report, as a user calls them.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include "tests/client/synthetic_job.h"

namespace creepctl {
namespace {

struct Ended {
  int exit_code = -1;
  std::string output;  ///< stdout and stderr
};

Ended creepctl(const std::string& arguments) {
  Ended ended;
  FILE* pipe = popen((std::string("'") + CREEPCTL_PATH + "' " + arguments + " 2>&1").c_str(), "r");
  std::array<char, 4096> buffer{};
  for (std::size_t count = 0; (count = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) {
    ended.output.append(buffer.data(), count);
  }
  const int status = pclose(pipe);
  if (WIFEXITED(status)) ended.exit_code = WEXITSTATUS(status);
  return ended;
}

std::string text_of(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

class PlotReportTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    directory_ = std::filesystem::path(testing::TempDir()) / (std::string("plot_report_") + test->name());
    std::filesystem::remove_all(directory_);
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  std::string quoted() const { return "'" + directory_.string() + "'"; }

  std::filesystem::path directory_;
};

TEST_F(PlotReportTest, PlotWritesEveryChartInBothFormats) {
  write_synthetic_job(directory_, {});
  const Ended ended = creepctl("plot " + quoted());
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  for (const char* stem : {"void_ratio_log_stress", "creep_strain_log_time", "creep_rate_log_time", "grading",
                           "grading_index_log_time", "stress_ripple", "broken_fraction_log_time"}) {
    const auto path = directory_ / "plots" / stem;
    EXPECT_GT(text_of(path.string() + ".svg").size(), 5000u) << stem;
    EXPECT_EQ(text_of(path.string() + ".png").substr(1, 3), "PNG") << stem;
    EXPECT_NE(ended.output.find(path.string() + ".svg"), std::string::npos) << stem;
  }
}

TEST_F(PlotReportTest, PlotPutsOneFormatWhereItIsTold) {
  write_synthetic_job(directory_, {});
  const auto out = directory_ / "elsewhere" / "pictures";
  const Ended ended = creepctl("plot " + quoted() + " --format png --out '" + out.string() + "'");
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_TRUE(std::filesystem::exists(out / "grading.png"));
  EXPECT_FALSE(std::filesystem::exists(out / "grading.svg"));
  EXPECT_FALSE(std::filesystem::exists(directory_ / "plots"));
  EXPECT_EQ(creepctl("plot " + quoted() + " --format gif").exit_code, 2);
}

TEST_F(PlotReportTest, MissingForeignAndDamagedDirectoriesAreInvalidInput) {
  for (const char* command : {"plot ", "report "}) {
    const Ended missing = creepctl(command + quoted());
    EXPECT_EQ(missing.exit_code, 5);
    EXPECT_NE(missing.output.find("no such job directory"), std::string::npos) << missing.output;
  }
  std::filesystem::create_directories(directory_);
  for (const char* command : {"plot ", "report "}) {
    const Ended foreign = creepctl(command + quoted());
    EXPECT_EQ(foreign.exit_code, 5);
    EXPECT_NE(foreign.output.find("no job.toml"), std::string::npos) << foreign.output;
  }
  write_synthetic_job(directory_, {});
  std::ofstream(directory_ / "samples.csv") << "a,b\nnot,numbers\n";
  const Ended damaged = creepctl("report " + quoted());
  EXPECT_EQ(damaged.exit_code, 5);
  EXPECT_NE(damaged.output.find("samples.csv:2:"), std::string::npos) << damaged.output;
}

TEST_F(PlotReportTest, ReportStandsAloneAndHoldsTheFigures) {
  write_synthetic_job(directory_, {});
  const Ended ended = creepctl("report " + quoted());
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_EQ(ended.output.substr(0, ended.output.find('\n')), (directory_ / "report.html").string());
  const std::string page = text_of(directory_ / "report.html");
  for (const char* outside : {"http", "src=", "@import", "<link", "<script", "url(//"}) {
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  }
  for (const char* inside :
       {"synthetic &lt;creep&gt;", "00c0ffee", "0.584", "fontainebleau-ne34", "target void ratio not reached",
        "R²", "3.200e+07", "One packing is one sample", "Singh-Mitchell",
        "broken at the first grading of the hold", "= 0.0421, Einav", "void_ratio = 0.65", "unexplained"}) {
    EXPECT_NE(page.find(inside), std::string::npos) << inside;
  }
  // A page with seven drawings: every reference must find its own glyph.
  std::set<std::string> ids;
  for (std::size_t at = page.find(" id=\""); at != std::string::npos; at = page.find(" id=\"", at + 1)) {
    const std::string id = page.substr(at + 5, page.find('"', at + 5) - at - 5);
    EXPECT_TRUE(ids.insert(id).second) << id;
  }
  for (std::size_t at = page.find("href=\"#"); at != std::string::npos; at = page.find("href=\"#", at + 1)) {
    ASSERT_TRUE(ids.contains(page.substr(at + 7, page.find('"', at + 7) - at - 7)));
  }
}

TEST_F(PlotReportTest, ReportPrintsTheHeadlineBesideThePaper) {
  write_synthetic_job(directory_, {});
  const std::string output = creepctl("report " + quoted()).output;
  // e at the end of loading: 1.6497 x (1 - 0.041) - 1 = 0.5821.
  EXPECT_NE(output.find("0.5821 | paper 0.584 | difference -0.0019"), std::string::npos) << output;
  EXPECT_NE(output.find("the closing one included: 15 | paper 15"), std::string::npos) << output;
  EXPECT_NE(output.find("the initial one included: 16 | paper 15"), std::string::npos) << output;
  EXPECT_NE(output.find("creep strain"), std::string::npos);
  EXPECT_NE(output.find("I_G"), std::string::npos);
}

TEST_F(PlotReportTest, ReportOfAnotherSceneComparesNothing) {
  SyntheticJob job;
  job.axial_stress = "10 MPa";
  write_synthetic_job(directory_, job);
  const std::string output = creepctl("report " + quoted()).output;
  EXPECT_EQ(output.find("0.584"), std::string::npos) << output;
  EXPECT_NE(output.find("Not the paper's scene"), std::string::npos) << output;
}

TEST_F(PlotReportTest, UnfinishedRunsArePlottedAndReported) {
  for (const bool loaded : {false, true}) {
    for (const int stages : {0, 1, 4}) {
      SyntheticJob job;
      job.loaded = loaded;
      job.dynamic_stages = stages;
      job.finished = false;
      std::filesystem::remove_all(directory_);
      write_synthetic_job(directory_, job);
      EXPECT_EQ(creepctl("plot " + quoted()).exit_code, 0);
      EXPECT_EQ(creepctl("report " + quoted()).exit_code, 0);
      EXPECT_NE(text_of(directory_ / "report.html").find("not ended"), std::string::npos);
    }
  }
  for (const char* file : {"samples.csv", "stages.csv", "breakages.csv", "gsd.csv"}) {
    std::filesystem::remove(directory_ / file);
  }
  const Ended nothing = creepctl("plot " + quoted());
  EXPECT_EQ(nothing.exit_code, 0);
  EXPECT_NE(nothing.output.find("nothing to plot yet"), std::string::npos) << nothing.output;
  EXPECT_EQ(creepctl("report " + quoted()).exit_code, 0);
}

TEST_F(PlotReportTest, HelpEndsWithAnExample) {
  for (const char* command : {"plot", "report"}) {
    const Ended help = creepctl(std::string(command) + " --help");
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_NE(help.output.find(std::string("Example:\n  creepctl ") + command), std::string::npos);
  }
}

}  // namespace
}  // namespace creepctl
