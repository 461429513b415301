#include "core/folder/checkpoint_store.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/folder/durable_file.h"
#include "tests/server/file_size_limit.h"
#include "tests/server/temporary_directory.h"

namespace creepd {
namespace {

// A checkpoint of these tests: "good", then the next sequence as one digit, then anything. What the store
// does does not depend on what a checkpoint is, only on whether it verifies.
absl::StatusOr<creep::CheckpointInfo> verify(std::string_view bytes) {
  if (bytes.starts_with("newer")) return absl::FailedPreconditionError("made by a newer program");
  if (bytes.size() < 5 || !bytes.starts_with("good"))
    return absl::DataLossError("checksum of section particles");
  creep::CheckpointInfo info;
  info.next_sequence = static_cast<std::uint64_t>(bytes[4] - '0');
  return info;
}

absl::Status any(const creep::CheckpointInfo&) { return absl::OkStatus(); }

using Generations = std::vector<std::uint64_t>;

TEST(CheckpointStore, KeepsThreeGenerations) {
  const TemporaryDirectory directory;
  const auto folder = directory.path() / "checkpoints";
  auto store = creep::CheckpointStore::open(folder, &verify);
  ASSERT_TRUE(store.ok());
  for (std::uint64_t i = 1; i <= 5; ++i) EXPECT_EQ(store->add("good" + std::to_string(i)).value(), i);
  EXPECT_EQ(store->generations(), (Generations{3, 4, 5}));
  EXPECT_EQ(creep::numbered_files(folder, "ck").value(), (Generations{3, 4, 5}));
}

TEST(CheckpointStore, LoadsTheNewestAfterAReopening) {
  const TemporaryDirectory directory;
  ASSERT_TRUE(creep::CheckpointStore::open(directory.path(), &verify)->add("good1 a").ok());
  ASSERT_TRUE(creep::CheckpointStore::open(directory.path(), &verify)->add("good2 b").ok());
  auto store = creep::CheckpointStore::open(directory.path(), &verify);
  const auto newest = store->load_newest(any);
  ASSERT_TRUE(newest->loaded);
  EXPECT_EQ(newest->loaded->bytes, "good2 b");
  EXPECT_EQ(newest->loaded->info.next_sequence, 2u);
  EXPECT_TRUE(newest->rejected.empty());
}

TEST(CheckpointStore, FallsBackBehindADamagedOneAndSaysSo) {
  const TemporaryDirectory directory;
  auto store = creep::CheckpointStore::open(directory.path(), &verify);
  for (int i = 1; i <= 3; ++i) ASSERT_TRUE(store->add("good" + std::to_string(i)).ok());
  ASSERT_TRUE(creep::write_durably(directory.path() / "ck.3", "gone3").ok());
  ASSERT_TRUE(creep::write_durably(directory.path() / "ck.2", "").ok());

  store = creep::CheckpointStore::open(directory.path(), &verify);
  const auto newest = store->load_newest(any);
  ASSERT_TRUE(newest->loaded);
  EXPECT_EQ(newest->loaded->generation, 1u);
  ASSERT_EQ(newest->rejected.size(), 2u);
  EXPECT_EQ(newest->rejected[0].generation, 3u);
  EXPECT_EQ(newest->rejected[0].reason, "checksum of section particles");
  EXPECT_EQ(creep::numbered_files(directory.path(), "bad").value(), (Generations{2, 3}));
  // Numbers are not used again, and damaged files do not push out good ones.
  EXPECT_EQ(store->add("good4").value(), 4u);
  EXPECT_EQ(store->generations(), (Generations{1, 4}));
  EXPECT_EQ(creep::CheckpointStore::open(directory.path(), &verify)->generations(), (Generations{1, 4}));
}

TEST(CheckpointStore, LeavesTheFilesOfANewerProgramAlone) {
  const TemporaryDirectory directory;
  auto store = creep::CheckpointStore::open(directory.path(), &verify);
  for (int i = 1; i <= 2; ++i) ASSERT_TRUE(store->add("good" + std::to_string(i)).ok());
  ASSERT_TRUE(creep::write_durably(directory.path() / "ck.3", "newer").ok());
  ASSERT_TRUE(creep::replace_file(directory.path() / "ck.4.tmp", "newer").ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(creep::CheckpointStore::open(directory.path(), &verify).status()));
  // Written while the store was open, behind one that is damaged.
  ASSERT_TRUE(creep::write_durably(directory.path() / "ck.4", "damaged").ok());
  store = creep::CheckpointStore::open(directory.path(), &verify);
  EXPECT_TRUE(absl::IsFailedPrecondition(store->load_newest(any).status()));
  EXPECT_EQ(creep::numbered_files(directory.path(), "ck").value(), (Generations{1, 2, 3}));
  EXPECT_EQ(creep::read_file(directory.path() / "ck.3").value(), "newer");
}

TEST(CheckpointStore, PassesOverOneThatTheCallerCannotUse) {
  const TemporaryDirectory directory;
  auto store = creep::CheckpointStore::open(directory.path(), &verify);
  for (int i = 1; i <= 3; ++i) ASSERT_TRUE(store->add("good" + std::to_string(i)).ok());
  const auto newest = store->load_newest([](const creep::CheckpointInfo& info) {
    return info.next_sequence <= 2 ? absl::OkStatus() : absl::DataLossError("ahead of the log");
  });
  EXPECT_EQ(newest->loaded->generation, 2u);
  EXPECT_EQ(newest->rejected.at(0).reason, "ahead of the log");
}

TEST(CheckpointStore, ReportsThatNoneIsGood) {
  const TemporaryDirectory directory;
  ASSERT_TRUE(creep::write_durably(directory.path() / "ck.1", "x").ok());
  auto store = creep::CheckpointStore::open(directory.path(), &verify);
  const auto newest = store->load_newest(any);
  EXPECT_FALSE(newest->loaded);
  EXPECT_EQ(newest->rejected.size(), 1u);
}

TEST(CheckpointStore, RemovesWhatAKilledWriterLeft) {
  const TemporaryDirectory directory;
  ASSERT_TRUE(creep::write_durably(directory.path() / "ck.4.tmp", "half a check").ok());
  auto store = creep::CheckpointStore::open(directory.path(), &verify);
  EXPECT_FALSE(std::filesystem::exists(directory.path() / "ck.4.tmp"));
  EXPECT_FALSE(store->load_newest(any)->loaded);
}

TEST(CheckpointStore, KeepsTheOldOnesWhenThereIsNoRoom) {
  const TemporaryDirectory directory;
  auto store = creep::CheckpointStore::open(directory.path(), &verify);
  for (int i = 1; i <= 3; ++i) ASSERT_TRUE(store->add("good" + std::to_string(i)).ok());
  {
    const FileSizeLimit limit(100);
    EXPECT_EQ(store->add("good4" + std::string(1000, 'x')).status().code(),
              absl::StatusCode::kResourceExhausted);
  }
  EXPECT_EQ(creep::numbered_files(directory.path(), "ck").value(), (Generations{1, 2, 3}));
  EXPECT_EQ(store->load_newest(any)->loaded->generation, 3u);
  EXPECT_EQ(store->add("good4").value(), 4u);
}

TEST(CheckpointStore, DoesNotCountOneThatDoesNotReadBack) {
  const TemporaryDirectory directory;
  auto store = creep::CheckpointStore::open(directory.path(), &verify);
  for (int i = 1; i <= 3; ++i) ASSERT_TRUE(store->add("good" + std::to_string(i)).ok());
  EXPECT_EQ(store->add("not a checkpoint").status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(creep::numbered_files(directory.path(), "ck").value(), (Generations{1, 2, 3}));
}

}  // namespace
}  // namespace creepd
