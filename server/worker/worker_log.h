// worker.log: what an attempt did, for people. The one place, with stderr, where the wall clock is written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/folder/file_descriptor.h"

namespace creepd {

class WorkerLog {
 public:
  static absl::StatusOr<WorkerLog> open(const std::filesystem::path& path, std::int64_t attempt);

  /// One line. A log that cannot be written (full disk) stops nothing: the same fault shows where it matters.
  void line(std::string_view text);

  /// One line here and, unless stderr leads to this very file, on stderr.
  void trouble(std::string_view text);

 private:
  WorkerLog(creep::FileDescriptor file, std::int64_t attempt) : file_(std::move(file)), attempt_(attempt) {}

  creep::FileDescriptor file_;
  std::int64_t attempt_;
};

}  // namespace creepd
