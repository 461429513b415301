// The rows of one job's tables by index: 0, 1, 2, ... over the records of a kind in its log, which may still
// grow.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iterator>
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

  std::uint64_t size(creep::RecordKind kind = creep::RecordKind::kSample) const;

  /// Sample `index`, < size().
  absl::StatusOr<creep::Record> read(std::uint64_t index);

  /// How many rows of a kind the run had when it had made this many samples.
  std::uint64_t rows_at(creep::RecordKind kind, std::uint64_t samples) const;

  /// Row after row from `first` to before `end`, at most size(), until `take` returns false. Others may read
  /// between two portions.
  absl::Status visit(creep::RecordKind kind, std::uint64_t first, std::uint64_t end,
                     const std::function<bool(std::uint64_t index, const creep::Record&)>& take);

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
  using Places = std::vector<Place>;
  Places& places(creep::RecordKind kind) { return places_[static_cast<std::size_t>(kind)]; }
  const Places& places(creep::RecordKind kind) const { return places_[static_cast<std::size_t>(kind)]; }
  absl::StatusOr<creep::Record> record_at(const Place& place, creep::RecordKind kind);

  std::array<Places, std::size(creep::kRecordKinds) + 1> places_;  ///< by RecordKind, which begins at 1
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
