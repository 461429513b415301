// The samples of one job by index: 0, 1, 2, ... over the sample records of its log, which may still grow.
#pragma once

#include <cstdint>
#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/folder/sample_log.h"
#include "core/output/record.h"

namespace creepd {

/// Safe from several threads.
class SampleIndex {
 public:
  explicit SampleIndex(std::filesystem::path log) : path_(std::move(log)) {}

  /// Reads on to the present end of the log; a log that is not there yet is empty. Returns how many samples
  /// there are. Errors: DataLoss, or of the file system; what was read before stays.
  absl::StatusOr<std::uint64_t> poll();

  std::uint64_t size() const;

  /// Sample `index`, < size().
  absl::StatusOr<creep::Record> read(std::uint64_t index);

 private:
  absl::Status open();

  std::filesystem::path path_;
  mutable std::mutex mutex_;
  std::optional<creep::SampleLogReader> reader_;
  std::uint64_t end_ = 0;  ///< of what was read [bytes]
  struct Place {
    std::uint64_t sequence;
    std::uint64_t offset;
  };
  std::vector<Place> samples_;
};

/// The indices in use, and a few that were; each is made by reading its log once. Safe from several threads.
class SampleLibrary {
 public:
  explicit SampleLibrary(std::filesystem::path jobs) : jobs_(std::move(jobs)) {}

  std::shared_ptr<SampleIndex> of(const std::string& job);
  void forget(const std::string& job);

 private:
  static constexpr std::size_t kKept = 64;

  std::filesystem::path jobs_;
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<SampleIndex>> known_;
  std::list<std::pair<std::string, std::shared_ptr<SampleIndex>>> recent_;  ///< newest first
};

}  // namespace creepd
