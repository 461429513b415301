#include "server/worker/tables.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/folder/durable_file.h"
#include "tests/server/temporary_directory.h"

namespace creepd {
namespace {

using creep::Record;
using creep::RecordKind;

std::vector<Record> one_of_each(std::uint64_t from) {
  std::vector<Record> all;
  for (const RecordKind kind : creep::kRecordKinds) {
    const std::uint64_t sequence = from + all.size();
    all.push_back({kind, sequence,
                   std::vector<double>(creep::columns(kind).size(), 0.1 * static_cast<double>(sequence))});
  }
  return all;
}

class TablesTest : public testing::Test {
 protected:
  creep::SampleLog log() { return creep::SampleLog::open(directory_.path() / "samples.log").value(); }
  StageTimings timings() { return StageTimings::open(directory_.path() / "stage_timings.csv").value(); }
  std::string table(RecordKind kind) {
    return creep::read_file(directory_.path() / table_name(kind)).value();
  }

  TemporaryDirectory directory_;
};

TEST_F(TablesTest, ContinuedLineByLineTheyEqualARendering) {
  creep::SampleLog samples = log();
  StageTimings cost = timings();
  cost.add(0, {.rebuilds = 3, .wall_seconds = 0.25, .particle_steps = 100});
  auto tables = Tables::render(directory_.path(), samples, cost);
  for (std::uint64_t from = 0; from < 12; from += 4) {
    ASSERT_TRUE(samples.append(one_of_each(from)).ok());
    ASSERT_TRUE(tables->append(one_of_each(from), cost).ok());
  }
  std::vector<std::string> continued;
  for (const RecordKind kind : creep::kRecordKinds) continued.push_back(table(kind));
  ASSERT_TRUE(Tables::render(directory_.path(), samples, cost).ok());
  for (const RecordKind kind : creep::kRecordKinds) {
    EXPECT_EQ(table(kind), continued[static_cast<std::size_t>(kind) - 1]) << table_name(kind);
  }
}

TEST_F(TablesTest, ALineTornByAKillIsRenderedAnew) {
  creep::SampleLog samples = log();
  ASSERT_TRUE(samples.append(one_of_each(0)).ok());
  ASSERT_TRUE(Tables::render(directory_.path(), samples, timings()).ok());
  const std::string whole = table(RecordKind::kSample);
  ASSERT_TRUE(creep::replace_file(directory_.path() / "samples.csv", whole.substr(0, whole.size() - 5)).ok());
  ASSERT_TRUE(Tables::render(directory_.path(), samples, timings()).ok());
  EXPECT_EQ(table(RecordKind::kSample), whole);
}

TEST_F(TablesTest, OnlyStagesEndInColumnsOfCost) {
  creep::SampleLog samples = log();
  ASSERT_TRUE(samples.append(one_of_each(0)).ok());
  StageTimings cost = timings();
  cost.add(StageTimings::kPacking, {.rebuilds = 9, .wall_seconds = 9.0, .particle_steps = 9.0});
  cost.add(0, {.rebuilds = 3, .wall_seconds = 0.25, .particle_steps = 100.0});
  ASSERT_TRUE(Tables::render(directory_.path(), samples, cost).ok());
  EXPECT_TRUE(table(RecordKind::kStage).ends_with(",3,0.250\n")) << table(RecordKind::kStage);
  EXPECT_TRUE(table(RecordKind::kStage)
                  .starts_with(creep::csv_header(RecordKind::kStage) + ",rebuilds,wall_seconds\n"));
  EXPECT_TRUE(table(RecordKind::kSample).starts_with(creep::csv_header(RecordKind::kSample) + "\n"));
}

TEST_F(TablesTest, CostIsSummedOverAttempts) {
  StageTimings first = timings();
  first.add(0, {.rebuilds = 3, .wall_seconds = 0.25, .particle_steps = 100.0});
  ASSERT_TRUE(first.write().ok());
  StageTimings second = timings();
  second.add(0, {.rebuilds = 1, .wall_seconds = 0.5, .particle_steps = 50.0});
  second.add(1, {.rebuilds = 1, .wall_seconds = 1.0, .particle_steps = 10.0});
  EXPECT_EQ(second.of(0).rebuilds, 4);
  EXPECT_EQ(second.total().wall_seconds, 1.75);  // sums of powers of two: exact
  EXPECT_EQ(second.total().particle_steps, 160.0);
}

}  // namespace
}  // namespace creepd
