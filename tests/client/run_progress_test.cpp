#include "client/terminal/run_progress.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace creepctl {
namespace {

creep::Experiment experiment() {
  creep::Experiment experiment;
  experiment.program = {creep::OedometricStage{21.7e6}, creep::CreepStage{172800.0, std::nullopt}};
  return experiment;
}

RunProgress in_creep(double creep_time) {
  RunProgress progress;
  progress.stage = "creep";
  progress.stage_index = 1;
  progress.dynamic_stage = 3;
  progress.creep_time = creep_time;
  progress.axial_strain = 0.0512;
  progress.grading_index = 0.1234;
  progress.broken_total = 71;
  progress.particle_steps_per_second = 1.6e7;
  progress.seconds_left = 240.0;
  return progress;
}

int full_cells(const std::string& line) {
  return static_cast<int>(std::count(line.begin(), line.end(), '#'));
}

TEST(RunProgress, TheBarOfACreepStageIsLogarithmic) {
  // From 1 ms to 172 800 s: 8.24 decades in 16 cells.
  EXPECT_EQ(full_cells(live_line(in_creep(0.0), experiment(), 200, false)), 0);
  EXPECT_EQ(full_cells(live_line(in_creep(13.1), experiment(), 200, false)), 8);  // sqrt(1e-3 x 172 800) s
  EXPECT_EQ(full_cells(live_line(in_creep(172800.0), experiment(), 200, false)), 16);
}

TEST(RunProgress, TheLiveLineHoldsEverythingWhereThereIsRoom) {
  EXPECT_EQ(live_line(in_creep(13.1), experiment(), 200, false),
            "creep 3  13.1 s [########........] 2 d  strain 5.12 %  I_G 0.1234  broken 71  1.6e+07 p-steps/s "
            " 4 min left");
}

TEST(RunProgress, TheLiveLineNeverWraps) {
  for (int width = 12; width < 160; ++width) {
    const std::string ascii = live_line(in_creep(13.1), experiment(), width, false);
    EXPECT_LE(static_cast<int>(ascii.size()), width);
    const std::string unicode = live_line(in_creep(13.1), experiment(), width, true);
    const auto columns =
        std::count_if(unicode.begin(), unicode.end(), [](char c) { return (c & 0xc0) != 0x80; });
    EXPECT_LE(columns, width);
  }
}

TEST(RunProgress, PlainLinesCarryNoEscapes) {
  const std::string line = plain_line(in_creep(13.1), experiment());
  EXPECT_TRUE(std::all_of(line.begin(), line.end(), [](char c) { return c >= ' ' && c <= '~'; })) << line;
  EXPECT_NE(line.find("creep time 13.1 s of 2 d"), std::string::npos) << line;
}

TEST(RunProgress, AHalfWrittenOrForeignFileShowsNothing) {
  EXPECT_FALSE(parse_run_progress(""));
  EXPECT_FALSE(parse_run_progress("{\"stage\": \"cre"));
  EXPECT_FALSE(parse_run_progress("[1, 2]"));
  const auto progress =
      parse_run_progress(R"({"stage": "packing", "creep_time_s": null, "warnings": ["loose", 3]})");
  ASSERT_TRUE(progress);
  EXPECT_FALSE(progress->creep_time);
  EXPECT_EQ(progress->warnings, std::vector<std::string>{"loose"});
}

TEST(RunProgress, DurationsReadWell) {
  EXPECT_EQ(short_duration(0.00123), "0.00123 s");
  EXPECT_EQ(short_duration(35.0), "35 s");
  EXPECT_EQ(short_duration(720.0), "12 min");
  EXPECT_EQ(short_duration(12240.0), "3.4 h");
  EXPECT_EQ(short_duration(259200.0), "3.0 d");
}

}  // namespace
}  // namespace creepctl
