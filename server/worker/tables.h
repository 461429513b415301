// samples.csv, stages.csv, breakages.csv, gsd.csv: renderings of the sample log for people and other
// programs.
//
// Made anew from the log when an attempt begins, then continued line by line. So they need no checksum and no
// fsync, and are byte for byte those of an undisturbed run; only stages.csv ends in two columns of cost that
// are not.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/folder/file_descriptor.h"
#include "core/folder/sample_log.h"
#include "core/output/record.h"
#include "server/worker/stage_timings.h"

namespace creepd {

/// "samples.csv", ...
std::string table_name(creep::RecordKind kind);

class Tables {
 public:
  /// Writes all tables of a job directory from the log.
  static absl::StatusOr<Tables> render(const std::filesystem::path& directory, const creep::SampleLog& log,
                                       const StageTimings& timings);

  /// Adds the rows of records that are new in the log.
  absl::Status append(std::span<const creep::Record> records, const StageTimings& timings);

  /// Makes all rows durable. The names are with the next fsync of the directory.
  absl::Status sync() const;

  std::int64_t stage_rows() const { return stage_rows_; }  ///< in stages.csv

 private:
  using Texts = std::map<creep::RecordKind, std::string>;

  void render_row(const creep::Record& record, const StageTimings& timings, Texts& texts);

  std::filesystem::path directory_;
  std::map<creep::RecordKind, creep::FileDescriptor> files_;
  std::int64_t stage_rows_ = 0;
};

}  // namespace creepd
