#include "core/folder/durable_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <string>

#include "tests/server/file_size_limit.h"
#include "tests/server/temporary_directory.h"

namespace creepd {
namespace {

TEST(DurableFile, ReplacesAFileWholeAndLeavesNoTemporary) {
  const TemporaryDirectory directory;
  const auto path = directory.path() / "verdict.json";
  ASSERT_TRUE(creep::write_durably(path, "old").ok());
  ASSERT_TRUE(creep::write_durably(path, "new and longer").ok());
  EXPECT_EQ(creep::read_file(path).value(), "new and longer");
  EXPECT_FALSE(std::filesystem::exists(directory.path() / "verdict.json.tmp"));
}

TEST(DurableFile, KeepsTheOldBytesWhenThereIsNoRoom) {
  const TemporaryDirectory directory;
  const auto path = directory.path() / "summary.json";
  ASSERT_TRUE(creep::write_durably(path, "old").ok());
  {
    const FileSizeLimit limit(100);
    const auto status = creep::write_durably(path, std::string(1000, 'x'));
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
  }
  EXPECT_EQ(creep::read_file(path).value(), "old");
  EXPECT_FALSE(std::filesystem::exists(directory.path() / "summary.json.tmp"));
}

TEST(DurableFile, SaysThatTheDeviceIsFull) {
  const auto full = creep::open_file("/dev/full", O_WRONLY);
  ASSERT_TRUE(full.ok());
  const auto status = creep::write_all(full->get(), "x", "/dev/full");
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(std::string(status.message()), "write /dev/full: No space left on device");
}

TEST(DurableFile, TellsRoomFromRightsFromBrokenStorage) {
  EXPECT_EQ(creep::errno_status("x", ENOSPC).code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(creep::errno_status("x", EDQUOT).code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(creep::errno_status("x", EIO).code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(creep::errno_status("x", EROFS).code(), absl::StatusCode::kPermissionDenied);
  EXPECT_EQ(creep::errno_status("x", ENOENT).code(), absl::StatusCode::kNotFound);
}

TEST(DurableFile, RefusesALongFileBeforeTakingMemory) {
  const TemporaryDirectory directory;
  const auto path = directory.path() / "big";
  ASSERT_TRUE(creep::write_durably(path, "").ok());
  std::filesystem::resize_file(path, std::uintmax_t{1} << 40);  // sparse
  EXPECT_EQ(creep::read_file(path).status().code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace creepd
