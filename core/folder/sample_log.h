// samples.log: every record of a run, in sequence, each with its checksum; the only output that counts as
// truth.
//
//   file  = "CREEPLOG", version (4 bytes), 0 (4 bytes), frame*
//   frame = length of payload (4 bytes), first 16 hex digits of SHA-256 over (length, payload), payload
//   payload = 'R', encode(record)                 one record
//           | 'S', first sequence (8 bytes), note (text)  earlier records from this sequence on no longer
//           hold
// All numbers little-endian.
//
// The log is never cut, save behind its last intact frame: what stands there was being written when a process
// or the machine went down. More than one torn frame is set aside as samples.log.damaged-N first. A resumed
// run repeats records that are there: append() compares them byte for byte, and adds only what is new.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/folder/file_descriptor.h"
#include "core/output/record.h"

namespace creep {

struct LogFrame {
  std::optional<Record> record;       ///< or, without one:
  std::uint64_t superseded_from = 0;  ///< records from this sequence on, read so far, no longer hold
  std::string note;                   ///< why
};

/// Where the first frame begins in the file [bytes].
/// Format of the file; older ones are read, newer ones refused by name.
inline constexpr std::uint64_t kSampleLogVersion = 1;

inline constexpr std::uint64_t kFirstFrame = 16;

/// Reads a log that may still grow. Any number of readers beside the one writer.
class SampleLogReader {
 public:
  /// Errors: NotFound, or of the file system. What the file begins with is judged by next().
  static absl::StatusOr<SampleLogReader> open(const std::filesystem::path& path);

  /// The next whole frame; nothing at the end or before a frame still being written (ask again later).
  /// Errors: DataLoss (no log, or damage that frames follow), FailedPrecondition (of a newer program).
  absl::StatusOr<std::optional<LogFrame>> next();

  /// The same of a frame that next() has found whole before: its checksum is not looked at again, only
  /// whether it can be read.
  absl::StatusOr<std::optional<LogFrame>> again();

  std::uint64_t offset() const { return offset_; }  ///< of the next frame in the file [bytes]

  /// Goes on at a frame whose offset() was noted before.
  void seek(std::uint64_t offset) { offset_ = offset; }

 private:
  SampleLogReader(FileDescriptor file, std::filesystem::path path)
      : file_(std::move(file)), path_(std::move(path)) {}

  absl::StatusOr<std::string_view> bytes_at_offset();
  absl::StatusOr<std::optional<LogFrame>> read(bool checked);

  FileDescriptor file_;
  std::filesystem::path path_;
  std::uint64_t offset_ = 0;
  std::string buffer_;           ///< bytes of the file, as they were when they were read,
  std::uint64_t buffer_at_ = 0;  ///< from here on
};

/// The one writer. Records 0 .. size() - 1 are in it.
class SampleLog {
 public:
  /// Opens or makes it. Errors: DataLoss (no log), FailedPrecondition (of a newer program), or of files.
  static absl::StatusOr<SampleLog> open(const std::filesystem::path& path);

  std::uint64_t size() const { return frames_.size(); }

  /// What had to be cut or set aside when it was opened; "" if nothing.
  const std::string& repair() const { return repair_; }

  /// The record with this sequence, < size().
  absl::StatusOr<Record> read(std::uint64_t sequence) const;

  /// The run continues at `sequence`, <= size(): the records from there on are going to be repeated.
  void rewind(std::uint64_t sequence);

  struct Appended {
    std::size_t repeated = 0;  ///< how many of the records were there already; the rest is new
    bool superseded = false;   ///< records that no longer hold were replaced
  };
  /// Continues with these records. A record that differs from the one there: Aborted with both values or, if
  /// a note is given, it supersedes that one and all behind. Other errors are of the file system.
  absl::StatusOr<Appended> append(std::span<const Record> records,
                                  const std::optional<std::string>& superseding_note = std::nullopt);

  /// Makes everything appended durable.
  absl::Status sync();

 private:
  SampleLog(FileDescriptor file, std::filesystem::path path)
      : file_(std::move(file)), path_(std::move(path)) {}

  absl::Status start_file();
  absl::Status scan();
  absl::Status cut_tail(std::uint64_t from, std::uint64_t file_size);

  FileDescriptor file_;
  std::filesystem::path path_;
  std::vector<std::uint64_t> frames_;  ///< place in the file of the frame of each sequence
  std::uint64_t cursor_ = 0;           ///< sequence that append() expects next
  std::uint64_t end_ = 0;              ///< of the file
  std::string repair_;
};

}  // namespace creep
