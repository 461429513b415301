#include "core/folder/sample_log.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/folder/durable_file.h"
#include "tests/server/file_size_limit.h"
#include "tests/server/temporary_directory.h"

namespace creepd {
namespace {

using creep::Record;
using creep::RecordKind;

Record record(std::uint64_t sequence, double value) {
  const RecordKind kind = sequence % 5 == 4 ? RecordKind::kStage : RecordKind::kSample;
  return {kind, sequence, std::vector<double>(creep::columns(kind).size(), value)};
}

std::vector<Record> records(std::uint64_t from, std::uint64_t to, double offset = 0.0) {
  std::vector<Record> all;
  for (std::uint64_t i = from; i < to; ++i) all.push_back(record(i, static_cast<double>(i) + offset));
  return all;
}

class SampleLogTest : public testing::Test {
 protected:
  creep::SampleLog open() {
    auto log = creep::SampleLog::open(path_);
    EXPECT_TRUE(log.ok()) << log.status();
    return *std::move(log);
  }

  std::string bytes() const { return creep::read_file(path_).value(); }
  void put(const std::string& text) const { ASSERT_TRUE(creep::replace_file(path_, text).ok()); }

  TemporaryDirectory directory_;
  std::filesystem::path path_ = directory_.path() / "samples.log";
};

TEST_F(SampleLogTest, GivesBackWhatWasAppended) {
  ASSERT_TRUE(open().append(records(0, 7)).ok());
  const creep::SampleLog log = open();
  ASSERT_EQ(log.size(), 7u);
  EXPECT_EQ(log.repair(), "");
  EXPECT_EQ(creep::encode(log.read(4).value()), creep::encode(record(4, 4.0)));
}

TEST_F(SampleLogTest, CutsATornLastRecordAtEveryLength) {
  ASSERT_TRUE(open().append(records(0, 2)).ok());
  const std::string two = bytes();
  ASSERT_TRUE(open().append(records(2, 3)).ok());
  const std::string three = bytes();
  for (std::size_t size = two.size() + 1; size < three.size(); ++size) {
    put(three.substr(0, size));
    creep::SampleLog log = open();
    ASSERT_EQ(log.size(), 2u) << size;
    EXPECT_NE(log.repair(), "");
    ASSERT_TRUE(log.append(records(2, 3)).ok());
    ASSERT_EQ(bytes(), three) << size;
  }
}

TEST_F(SampleLogTest, StartsOverWhenItsWriterWasStoppedInTheFirstBytes) {
  static_cast<void>(open());
  const std::string head = bytes();
  for (std::size_t size = 0; size < head.size(); ++size) {
    put(head.substr(0, size));
    ASSERT_EQ(open().size(), 0u);
    ASSERT_EQ(bytes(), head);
  }
}

TEST_F(SampleLogTest, NeverTakesAFlippedBitForARecord) {
  ASSERT_TRUE(open().append(records(0, 4)).ok());
  const std::string whole = bytes();
  for (std::size_t at = 16; at < whole.size(); ++at) {
    std::string flipped = whole;
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << (at % 8)));
    put(flipped);
    creep::SampleLog log = open();
    ASSERT_LT(log.size(), 4u) << at;
    for (std::uint64_t i = 0; i < log.size(); ++i) {
      ASSERT_EQ(creep::encode(log.read(i).value()), creep::encode(record(i, static_cast<double>(i))));
    }
    ASSERT_NE(log.repair(), "") << at;
  }
}

TEST_F(SampleLogTest, SetsADamagedTailAsideBeforeCuttingIt) {
  ASSERT_TRUE(open().append(records(0, 2)).ok());
  const std::size_t good = bytes().size();
  ASSERT_TRUE(open().append(records(2, 40)).ok());
  std::string damaged = bytes();
  damaged[good + 40] = static_cast<char>(damaged[good + 40] ^ 1);
  put(damaged);
  EXPECT_EQ(open().size(), 2u);
  EXPECT_EQ(creep::read_file(path_.string() + ".damaged-" + std::to_string(good)).value(),
            damaged.substr(good));
}

TEST_F(SampleLogTest, RefusesAFileThatIsNoLog) {
  put("sequence,stage\n0,1\n");
  EXPECT_EQ(creep::SampleLog::open(path_).status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(bytes(), "sequence,stage\n0,1\n");
}

TEST_F(SampleLogTest, LeavesTheLogOfANewerProgramAlone) {
  std::string newer = "CREEPLOG";
  newer += {2, 0, 0, 0, 0, 0, 0, 0};
  newer += "whatever a newer program keeps here";
  ASSERT_TRUE(creep::write_durably(path_, newer).ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(creep::SampleLog::open(path_).status()));
  EXPECT_TRUE(absl::IsFailedPrecondition(creep::SampleLogReader::open(path_)->next().status()));
  EXPECT_EQ(creep::read_file(path_).value(), newer);
}

TEST_F(SampleLogTest, ComparesRepeatedRecordsAndAddsOnlyNewOnes) {
  ASSERT_TRUE(open().append(records(0, 6)).ok());
  const std::string before = bytes();
  creep::SampleLog log = open();
  log.rewind(2);
  EXPECT_EQ(log.append(records(2, 4)).value().repeated, 2u);
  EXPECT_EQ(bytes(), before);
  const auto appended = log.append(records(4, 8));
  EXPECT_EQ(appended.value().repeated, 2u);
  EXPECT_FALSE(appended->superseded);
  EXPECT_EQ(log.size(), 8u);
  EXPECT_EQ(open().size(), 8u);
}

TEST_F(SampleLogTest, ADifferenceInTheLastBitIsLoud) {
  ASSERT_TRUE(open().append(records(0, 4)).ok());
  const std::string before = bytes();
  creep::SampleLog log = open();
  log.rewind(1);
  auto repeated = records(1, 3);
  double& strain = repeated[1].values[creep::column_index(RecordKind::kSample, "axial_strain")];
  strain = std::nextafter(strain, std::numeric_limits<double>::infinity());
  const auto appended = log.append(repeated);
  EXPECT_EQ(appended.status().code(), absl::StatusCode::kAborted);
  EXPECT_EQ(
      std::string(appended.status().message()),
      "record 2 differs from the one in samples.log: axial_strain 2 there, 2.0000000000000004 recomputed");
  EXPECT_EQ(bytes(), before);
}

TEST_F(SampleLogTest, ToldSoADifferenceSupersedesAllBehindIt) {
  ASSERT_TRUE(open().append(records(0, 6)).ok());
  creep::SampleLog log = open();
  log.rewind(2);
  const auto appended = log.append(records(2, 4, 0.5), "attempt 2 was allowed to be inexact");
  ASSERT_TRUE(appended.ok());
  EXPECT_TRUE(appended->superseded);
  EXPECT_EQ(log.size(), 4u);
  ASSERT_TRUE(log.append(records(4, 5, 0.5), "").ok());

  const creep::SampleLog again = open();
  ASSERT_EQ(again.size(), 5u);
  EXPECT_EQ(again.read(1)->values[0], 1.0);
  EXPECT_EQ(again.read(2)->values[0], 2.5);

  auto reader = creep::SampleLogReader::open(path_);
  std::vector<double> seen;
  std::string note;
  for (auto frame = reader->next(); frame.ok() && *frame; frame = reader->next()) {
    if ((*frame)->record) {
      seen.push_back((*frame)->record->values[0]);
    } else {
      seen.resize((*frame)->superseded_from);
      note = (*frame)->note;
    }
  }
  EXPECT_EQ(seen, (std::vector<double>{0.0, 1.0, 2.5, 3.5, 4.5}));
  EXPECT_TRUE(note.starts_with("attempt 2 was allowed to be inexact; record 2 differs")) << note;
}

TEST_F(SampleLogTest, AFollowerSeesAFrameOnceItIsWhole) {
  ASSERT_TRUE(open().append(records(0, 2)).ok());
  const std::string two = bytes();
  put(two.substr(0, two.size() - 1));
  auto reader = creep::SampleLogReader::open(path_);
  EXPECT_EQ(reader->next().value()->record->sequence, 0u);
  // Torn by a kill, then cut and written again by the next attempt, in the same file.
  EXPECT_FALSE(reader->next().value());
  ASSERT_TRUE(open().append(records(1, 3)).ok());
  EXPECT_EQ(reader->next().value()->record->sequence, 1u);
  EXPECT_EQ(reader->next().value()->record->sequence, 2u);
  EXPECT_FALSE(reader->next().value());
}

TEST_F(SampleLogTest, AFollowerReportsDamageInTheMiddle) {
  ASSERT_TRUE(open().append(records(0, 30)).ok());
  std::string damaged = bytes();
  damaged[60] = static_cast<char>(damaged[60] ^ 1);
  put(damaged);
  EXPECT_EQ(creep::SampleLogReader::open(path_)->next().status().code(), absl::StatusCode::kDataLoss);
}

TEST_F(SampleLogTest, AFullDiskLosesNothingThatWasThere) {
  {
    creep::SampleLog log = open();
    ASSERT_TRUE(log.append(records(0, 3)).ok());
    const FileSizeLimit limit(bytes().size() + 100);
    EXPECT_EQ(log.append(records(3, 9)).status().code(), absl::StatusCode::kResourceExhausted);
  }
  creep::SampleLog log = open();
  EXPECT_EQ(log.size(), 3u);
  EXPECT_TRUE(log.append(records(3, 9)).ok());
  EXPECT_EQ(open().size(), 9u);
}

}  // namespace
}  // namespace creepd
