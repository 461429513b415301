#include "core/folder/sample_log.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>

#include "absl/strings/str_cat.h"
#include "core/arithmetic/check.h"
#include "core/arithmetic/digest.h"
#include "core/folder/durable_file.h"

namespace creep {
namespace {

constexpr std::string_view kMagic = "CREEPLOG";
constexpr std::uint64_t kLastPossibleVersion = 0xffff;  // a number above it is damage
constexpr std::size_t kFileHead = kFirstFrame;
constexpr std::size_t kChecksum = 16;
constexpr std::size_t kFrameHead = 4 + kChecksum;
constexpr std::size_t kBuffer = 64 << 10;   // of a reader
constexpr std::size_t kMostPayload = 4096;  // the widest record has well under 100 columns

void put(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<char>((value >> (8 * i)) & 0xffu));
}

std::uint64_t get(std::string_view in, int bytes) {
  std::uint64_t value = 0;
  for (int i = bytes; i-- > 0;)
    value = value << 8 | static_cast<unsigned char>(in[static_cast<std::size_t>(i)]);
  return value;
}

std::string file_head() {
  std::string head(kMagic);
  put(head, kSampleLogVersion, 4);
  put(head, 0, 4);
  return head;
}

/// Why a file with this beginning is no log to go on with.
absl::Status not_ours(std::string_view head, const std::string& path) {
  const std::uint64_t version = head.size() == kFileHead ? get(head.substr(kMagic.size()), 4) : 0;
  if (head.starts_with(kMagic) && version > kSampleLogVersion && version <= kLastPossibleVersion) {
    return absl::FailedPreconditionError(absl::StrCat(path, ": sample log of version ", version,
                                                      ", made by a newer program; this one reads version ",
                                                      kSampleLogVersion));
  }
  return absl::DataLossError(absl::StrCat(path, ": not a sample log of version ", kSampleLogVersion));
}

std::string checksum(std::string_view length_bytes, std::string_view payload) {
  std::string covered(length_bytes);
  covered += payload;
  return sha256_hex(covered).substr(0, kChecksum);
}

std::string frame_of(std::string_view payload) {
  std::string frame;
  put(frame, payload.size(), 4);
  frame += checksum(frame, payload);
  frame += payload;
  return frame;
}

std::string record_frame(const Record& record) {
  std::string payload(1, 'R');
  payload += encode(record);
  return frame_of(payload);
}

std::string superseding_frame(std::uint64_t from, std::string_view note) {
  std::string payload = "S";
  put(payload, from, 8);
  payload += note.substr(0, kMostPayload - payload.size());
  return frame_of(payload);
}

enum class FrameState {
  kGood,
  kEnd,      // nothing follows
  kTorn,     // incomplete or wrong, and the last thing in the file
  kDamaged,  // wrong, and more follows
};

struct FrameRead {
  FrameState state = FrameState::kEnd;
  std::size_t size = 0;  // of the whole frame [bytes]
  LogFrame frame;
};

absl::StatusOr<std::string> read_at(int file, std::uint64_t offset, std::size_t most,
                                    const std::string& path) {
  std::string bytes(most, '\0');
  std::size_t have = 0;
  while (have < most) {
    const ssize_t got = ::pread(file, bytes.data() + have, most - have, static_cast<off_t>(offset + have));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return errno_status(absl::StrCat("read ", path), errno);
    if (got == 0) break;
    have += static_cast<std::size_t>(got);
  }
  bytes.resize(have);
  return bytes;
}

bool decode_payload(std::string_view payload, LogFrame& frame) {
  if (payload.starts_with('R')) {
    auto record = decode(payload.substr(1));
    if (record.ok()) frame.record = *std::move(record);
    return frame.record.has_value();
  }
  if (!payload.starts_with('S') || payload.size() < 9) return false;
  frame.superseded_from = get(payload.substr(1), 8);
  frame.note = payload.substr(9);
  return true;
}

// One byte more than the longest frame, to see whether anything follows it.
constexpr std::size_t kEnough = kFrameHead + kMostPayload + 1;

/// The frame that begins there; `all` are kEnough bytes, or fewer to the end of the file.
FrameRead frame_in(std::string_view all, bool checked) {
  FrameRead read;
  if (all.empty()) return read;
  read.state = FrameState::kTorn;
  if (all.size() < kFrameHead) return read;
  const std::uint64_t length = get(all, 4);
  if (length > kMostPayload) {
    read.state = FrameState::kDamaged;
    return read;
  }
  if (all.size() < kFrameHead + length) return read;
  read.size = kFrameHead + length;
  const std::string_view payload = all.substr(kFrameHead, length);
  const bool good = (!checked || checksum(all.substr(0, 4), payload) == all.substr(4, kChecksum)) &&
                    decode_payload(payload, read.frame);
  if (good) {
    read.state = FrameState::kGood;
  } else if (all.size() > read.size) {
    read.state = FrameState::kDamaged;
  }
  return read;
}

absl::StatusOr<FrameRead> read_frame(int file, std::uint64_t offset, const std::string& path) {
  const auto bytes = read_at(file, offset, kEnough, path);
  if (!bytes.ok()) return bytes.status();
  return frame_in(*bytes, true);
}

std::string difference(const Record& there, const Record& recomputed) {
  const std::string start = absl::StrCat("record ", there.sequence, " differs from the one in samples.log: ");
  if (there.kind != recomputed.kind) return start + "of another kind";
  const auto all = columns(there.kind);
  for (std::size_t i = 0; i < all.size(); ++i) {
    Record one = there;
    one.values[i] = recomputed.values[i];
    if (encode(one) == encode(there)) continue;
    char text[160];
    std::snprintf(text, sizeof text, " %.17g there, %.17g recomputed", there.values[i], recomputed.values[i]);
    return absl::StrCat(start, std::string(all[i].name), text);
  }
  return start + "in its head";
}

}  // namespace

absl::StatusOr<SampleLogReader> SampleLogReader::open(const std::filesystem::path& path) {
  auto file = open_file(path, O_RDONLY);
  if (!file.ok()) return file.status();
  return SampleLogReader(*std::move(file), path);
}

absl::StatusOr<std::optional<LogFrame>> SampleLogReader::next() {
  if (offset_ == 0) {
    const auto head = read_at(file_.get(), 0, kFileHead, path_.string());
    if (!head.ok()) return head.status();
    if (head->size() < kFileHead && file_head().starts_with(*head)) return std::optional<LogFrame>();
    if (*head != file_head()) return not_ours(*head, path_.string());
    offset_ = kFileHead;
  }
  return read(true);
}

absl::StatusOr<std::optional<LogFrame>> SampleLogReader::again() { return read(false); }

absl::StatusOr<std::string_view> SampleLogReader::bytes_at_offset() {
  const std::uint64_t end = buffer_at_ + buffer_.size();
  // What is not whole in the buffer may have grown since.
  if (offset_ < buffer_at_ || offset_ + kEnough > end) {
    auto bytes = read_at(file_.get(), offset_, kBuffer, path_.string());
    if (!bytes.ok()) return bytes.status();
    buffer_ = *std::move(bytes);
    buffer_at_ = offset_;
  }
  return std::string_view(buffer_).substr(offset_ - buffer_at_, kEnough);
}

absl::StatusOr<std::optional<LogFrame>> SampleLogReader::read(bool checked) {
  const auto bytes = bytes_at_offset();
  if (!bytes.ok()) return bytes.status();
  FrameRead read = frame_in(*bytes, checked);
  // Whoever repairs the log writes other bytes there.
  if (read.state != FrameState::kGood) buffer_.clear();
  if (read.state == FrameState::kDamaged) {
    return absl::DataLossError(absl::StrCat(path_.string(), ": damaged at byte ", offset_));
  }
  if (read.state != FrameState::kGood) return std::optional<LogFrame>();
  offset_ += read.size;
  return std::optional<LogFrame>(std::move(read.frame));
}

absl::StatusOr<SampleLog> SampleLog::open(const std::filesystem::path& path) {
  auto file = open_file(path, O_RDWR | O_CREAT);
  if (!file.ok()) return file.status();
  SampleLog log(*std::move(file), path);
  const auto head = read_at(log.file_.get(), 0, kFileHead, path.string());
  if (!head.ok()) return head.status();
  absl::Status status;
  if (*head == file_head()) {
    status = log.scan();
  } else if (file_head().starts_with(*head)) {  // new, or its writer was stopped within the first bytes
    status = log.start_file();
  } else {
    status = not_ours(*head, path.string());
  }
  if (!status.ok()) return status;
  return log;
}

absl::Status SampleLog::start_file() {
  if (::lseek(file_.get(), 0, SEEK_SET) < 0)
    return errno_status(absl::StrCat("seek ", path_.string()), errno);
  if (auto written = write_all(file_.get(), file_head(), path_); !written.ok()) return written;
  end_ = kFileHead;
  if (auto synced = sync(); !synced.ok()) return synced;
  return sync_directory(path_.parent_path());
}

absl::Status SampleLog::scan() {
  std::uint64_t offset = kFileHead;
  FrameState state = FrameState::kGood;
  while (state == FrameState::kGood) {
    auto read = read_frame(file_.get(), offset, path_.string());
    if (!read.ok()) return read.status();
    state = read->state;
    if (state != FrameState::kGood) break;
    if (!read->frame.record) {
      frames_.resize(std::min<std::uint64_t>(frames_.size(), read->frame.superseded_from));
    } else if (read->frame.record->sequence == frames_.size()) {
      frames_.push_back(offset);
    } else {
      state = FrameState::kDamaged;  // a gap or a repeat: intact bytes in the wrong place
      break;
    }
    offset += read->size;
  }
  struct stat about {};
  if (::fstat(file_.get(), &about) != 0) return errno_status(absl::StrCat("stat ", path_.string()), errno);
  const auto file_size = static_cast<std::uint64_t>(about.st_size);
  cursor_ = frames_.size();
  end_ = offset;
  if (state == FrameState::kDamaged) {
    const auto tail = read_at(file_.get(), offset, file_size - offset, path_.string());
    if (!tail.ok()) return tail.status();
    const std::string aside = absl::StrCat(path_.string(), ".damaged-", offset);
    if (auto kept = write_durably(aside, *tail); !kept.ok()) return kept;
    repair_ = absl::StrCat("samples.log was damaged at byte ", offset, ": the ", file_size - offset,
                           " bytes from there on were set aside in ", aside);
  } else if (state == FrameState::kTorn) {
    repair_ = absl::StrCat("samples.log ended in a torn record: ", file_size - offset, " bytes removed");
  }
  return repair_.empty() ? absl::OkStatus() : cut_tail(offset, file_size);
}

absl::Status SampleLog::cut_tail(std::uint64_t from, std::uint64_t file_size) {
  CREEP_CHECK(from <= file_size, "a log is never cut before its last intact frame");
  if (::ftruncate(file_.get(), static_cast<off_t>(from)) != 0) {
    return errno_status(absl::StrCat("truncate ", path_.string()), errno);
  }
  return sync();
}

absl::StatusOr<Record> SampleLog::read(std::uint64_t sequence) const {
  CREEP_CHECK(sequence < size(), "reads only records that are there");
  auto read = read_frame(file_.get(), frames_[sequence], path_.string());
  if (!read.ok()) return read.status();
  if (read->state != FrameState::kGood || !read->frame.record) {
    return absl::DataLossError(
        absl::StrCat(path_.string(), ": record ", sequence, " was damaged while in use"));
  }
  return *std::move(read->frame.record);
}

void SampleLog::rewind(std::uint64_t sequence) {
  CREEP_CHECK(sequence <= size(), "the log reaches the checkpoint that is resumed");
  cursor_ = sequence;
}

absl::StatusOr<SampleLog::Appended> SampleLog::append(std::span<const Record> records,
                                                      const std::optional<std::string>& superseding_note) {
  Appended appended;
  std::string bytes;
  std::vector<std::uint64_t> places;  // of the new frames
  for (const Record& record : records) {
    CREEP_CHECK(record.sequence == cursor_ + places.size(), "records come in sequence");
    if (record.sequence < size()) {
      const auto there = read(record.sequence);
      if (!there.ok()) return there.status();
      if (encode(*there) == encode(record)) {
        ++cursor_;
        ++appended.repeated;
        continue;
      }
      if (!superseding_note) return absl::AbortedError(difference(*there, record));
      bytes += superseding_frame(record.sequence,
                                 absl::StrCat(*superseding_note, "; ", difference(*there, record)));
      frames_.resize(record.sequence);
      appended.superseded = true;
    }
    places.push_back(end_ + bytes.size());
    bytes += record_frame(record);
  }
  if (::lseek(file_.get(), static_cast<off_t>(end_), SEEK_SET) < 0) {
    return errno_status(absl::StrCat("seek ", path_.string()), errno);
  }
  if (auto written = write_all(file_.get(), bytes, path_); !written.ok()) return written;
  end_ += bytes.size();
  frames_.insert(frames_.end(), places.begin(), places.end());
  cursor_ += places.size();
  return appended;
}

absl::Status SampleLog::sync() {
  if (::fdatasync(file_.get()) != 0) return errno_status(absl::StrCat("fsync ", path_.string()), errno);
  return absl::OkStatus();
}

}  // namespace creep
