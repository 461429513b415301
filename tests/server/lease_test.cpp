#include "core/folder/lease.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "core/folder/durable_file.h"
#include "tests/server/file_size_limit.h"
#include "tests/server/temporary_directory.h"

namespace creepd {
namespace {

TEST(Lease, RefusesASecondHolderAndNamesTheFirst) {
  const TemporaryDirectory directory;
  const auto path = directory.path() / "lease";
  const auto first = creep::Lease::take(path, std::nullopt);
  ASSERT_TRUE(first.ok());
  const auto second = creep::Lease::take(path, std::nullopt);
  EXPECT_EQ(second.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_NE(std::string(second.status().message()).find("attempt 1, process " + std::to_string(::getpid())),
            std::string::npos)
      << second.status();
}

TEST(Lease, CountsAttemptsFromOne) {
  const TemporaryDirectory directory;
  const auto path = directory.path() / "lease";
  for (std::int64_t attempt = 1; attempt <= 3; ++attempt) {
    const auto lease = creep::Lease::take(path, std::nullopt);
    ASSERT_TRUE(lease.ok());
    EXPECT_EQ(lease->attempt(), attempt);
  }
}

TEST(Lease, ALateAttemptStepsBackBehindANewerOne) {
  const TemporaryDirectory directory;
  const auto path = directory.path() / "lease";
  ASSERT_TRUE(creep::Lease::take(path, 7).ok());
  EXPECT_EQ(creep::Lease::take(path, 6).status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(creep::Lease::take(path, 7)->attempt(), 7);
  EXPECT_EQ(creep::Lease::take(path, std::nullopt)->attempt(), 8);
}

TEST(Lease, KeepsTheNumberWhenTheDiskIsFull) {
  const TemporaryDirectory directory;
  const auto path = directory.path() / "lease";
  ASSERT_TRUE(creep::Lease::take(path, 4).ok());
  const FileSizeLimit limit(std::filesystem::file_size(path));
  EXPECT_EQ(creep::Lease::take(path, std::nullopt)->attempt(), 5);
}

TEST(Lease, StartsAnewFromAFileItCannotRead) {
  const TemporaryDirectory directory;
  const auto path = directory.path() / "lease";
  ASSERT_TRUE(creep::write_durably(path, "\x01garbage").ok());
  EXPECT_EQ(creep::Lease::take(path, std::nullopt)->attempt(), 1);
}

}  // namespace
}  // namespace creepd
