// Sample logs: opening one only ever shortens it to its intact records, keeps what it cuts if that may
// matter, and everybody who reads it sees the same records.
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/arithmetic/check.h"
#include "core/arithmetic/digest.h"
#include "core/folder/durable_file.h"
#include "core/folder/sample_log.h"
#include "core/output/record.h"
#include "tests/fuzz/target.h"
#include "tests/server/temporary_directory.h"

namespace creep::fuzz {
namespace {

using creep::SampleLog;
using creep::SampleLogReader;

constexpr std::size_t kChecksum = 16;
constexpr std::size_t kFrameHead = 4 + kChecksum;
constexpr std::size_t kMostPayload = 4096;
constexpr std::size_t kMostFrames = 64;

std::string little_endian(std::uint64_t value, std::size_t bytes) {
  std::string out(8, '\0');
  put_number(out, 0, value);
  return out.substr(0, bytes);
}

std::string frame(std::string_view payload) {
  const std::string length = little_endian(payload.size(), 4);
  std::string covered = length;
  covered += payload;
  return length + sha256_hex(covered).substr(0, kChecksum) + std::string(payload);
}

std::string head() { return "CREEPLOG" + little_endian(1, 4) + little_endian(0, 4); }

Record record(RecordKind kind, std::uint64_t sequence) {
  return {kind, sequence, std::vector<double>(columns(kind).size(), 0.5 * static_cast<double>(sequence))};
}

std::string payload_of(const Record& record) { return absl::StrCat("R", encode(record)); }

std::string superseding(std::uint64_t from) {
  return absl::StrCat("S", little_endian(from, 8), "allowed to be inexact");
}

struct Frames {
  std::vector<std::string> payloads;
  std::string rest;  ///< from the first frame on that is not whole
};

std::optional<Frames> split(std::string_view bytes) {
  if (!bytes.starts_with(head())) return std::nullopt;
  bytes.remove_prefix(head().size());
  Frames frames;
  while (bytes.size() >= kFrameHead) {
    std::size_t length = 0;
    for (std::size_t i = 4; i-- > 0;) length = length << 8 | static_cast<unsigned char>(bytes[i]);
    if (length > bytes.size() - kFrameHead) break;
    frames.payloads.emplace_back(bytes.substr(kFrameHead, length));
    bytes.remove_prefix(kFrameHead + length);
  }
  frames.rest = bytes;
  return frames;
}

void alter(Frames& frames, Random& random) {
  std::vector<std::string>& payloads = frames.payloads;
  const std::size_t at = random() % payloads.size();
  std::string& payload = payloads[at];
  switch (random() % 8) {
    case 0:
      payloads.erase(payloads.begin() + static_cast<std::ptrdiff_t>(at));
      break;
    case 1:
      if (payloads.size() < kMostFrames) payloads.push_back(payload);
      break;
    case 2:
      std::swap(payload, payloads[random() % payloads.size()]);
      break;
    case 3:
      if (payloads.size() < kMostFrames) payloads.push_back(superseding(random() % 8));
      break;
    case 4:
      if (payloads.size() < kMostFrames) {
        const RecordKind kind = kRecordKinds[random() % std::size(kRecordKinds)];
        payloads.push_back(payload_of(record(kind, random() % 8)));
      }
      break;
    case 5:
      payload = mutated(payload, kMostPayload + 1);
      break;
    case 6:
      frames.rest = mutated(frames.rest, 2 * kFrameHead);
      break;
    default: {
      // What is superseded; of a record the sequence, or the last value.
      if (payload.size() < 14) break;
      const std::size_t number = payload[0] == 'S' ? 1 : random() % 2 == 0 ? 2 : payload.size() - 8;
      put_number(payload, number, awkward_number(random));
    }
  }
}

/// The records a reader sees, those that were superseded left out.
std::vector<std::string> read_all(const std::filesystem::path& path) {
  std::vector<std::string> records;
  auto reader = creep::SampleLogReader::open(path);
  CREEP_CHECK(reader.ok(), "a file that is there cannot be opened");
  for (auto next = reader->next(); next.ok() && *next; next = reader->next()) {
    const creep::LogFrame& one = **next;
    if (!one.record) {
      records.resize(std::min<std::uint64_t>(records.size(), one.superseded_from));
    } else if (one.record->sequence == records.size()) {
      static_cast<void>(csv_row(*one.record));
      records.push_back(encode(*one.record));
    } else {
      break;  // a gap: the writer calls it damage
    }
  }
  return records;
}

std::string bytes_of(const std::filesystem::path& path) {
  auto bytes = creep::read_file(path);
  CREEP_CHECK(bytes.ok(), "a file that is there cannot be read");
  return *std::move(bytes);
}

void check_repair(std::string_view before, const std::string& after, const creep::SampleLog& log,
                  const std::filesystem::path& path) {
  if (before.size() < head().size()) {
    CREEP_CHECK(after == head() && log.size() == 0, "a log torn in its head does not start over");
    return;
  }
  CREEP_CHECK(before.starts_with(after), "opening a log did more than shorten it");
  CREEP_CHECK((after.size() < before.size()) == !log.repair().empty(), "a repair was not told");
  const std::filesystem::path aside = path.string() + ".damaged-" + std::to_string(after.size());
  if (std::filesystem::exists(aside)) {
    CREEP_CHECK(bytes_of(aside) == before.substr(after.size()), "what was set aside is not what was cut");
  } else {
    CREEP_CHECK(before.size() - after.size() < kFrameHead + kMostPayload, "more than a torn record was lost");
  }
}

void check_goes_on(const std::filesystem::path& path, const std::vector<std::string>& records) {
  auto log = creep::SampleLog::open(path);
  CREEP_CHECK(log.ok() && log->repair().empty(), "a repaired log is repaired again");
  CREEP_CHECK(log->size() == records.size(), "reader and writer see different records");
  std::vector<Record> again;
  for (std::uint64_t i = 0; i < records.size(); ++i) {
    const auto one = log->read(i);
    CREEP_CHECK(one.ok() && encode(*one) == records[i], "reader and writer see different records");
    again.push_back(*one);
  }
  const std::string before = bytes_of(path);
  log->rewind(0);
  const auto repeated = log->append(again);
  CREEP_CHECK(repeated.ok() && repeated->repeated == records.size(), "repeated records are not recognised");
  CREEP_CHECK(bytes_of(path) == before, "repeating records changed the log");
  CREEP_CHECK(log->append(std::vector<Record>{record(RecordKind::kSample, records.size())}).ok(),
              "a repaired log takes no new record");
  CREEP_CHECK(read_all(path).size() == records.size() + 1, "a new record is not read");
}

}  // namespace

std::vector<std::string> seeds() {
  std::string log = head();
  std::vector<std::string> all = {log};
  for (std::uint64_t i = 0; i < 4; ++i) log += frame(payload_of(record(kRecordKinds[i], i)));
  all.push_back(log);
  all.push_back(log + frame(superseding(2)) + frame(payload_of(record(RecordKind::kSample, 2))));
  all.push_back(log.substr(0, log.size() - 3));
  return all;
}

void try_input(std::string_view bytes) {
  static const creepd::TemporaryDirectory kDirectory;
  const std::filesystem::path path = kDirectory.path() / "samples.log";
  CREEP_CHECK(creep::replace_file(path, bytes).ok(), "no room for the log");
  const std::vector<std::string> records = read_all(path);
  auto log = creep::SampleLog::open(path);
  if (log.ok()) {
    check_repair(bytes, bytes_of(path), *log, path);
    check_goes_on(path, records);
  } else {
    CREEP_CHECK(absl::IsDataLoss(log.status()) || absl::IsFailedPrecondition(log.status()),
                "refused for another reason");
    CREEP_CHECK(bytes_of(path) == bytes && records.empty(), "a refused log was changed or read");
  }
  for (const auto& entry : std::filesystem::directory_iterator(kDirectory.path())) {
    ::unlink(entry.path().c_str());
  }
}

std::string altered(std::string_view bytes, Random& random) {
  auto frames = split(bytes);
  if (!frames || frames->payloads.empty() || random() % 16 == 0) return mutated(bytes, 2 * kMostPayload);
  alter(*frames, random);
  std::string out = head();
  for (const std::string& payload : frames->payloads) out += frame(payload);
  return out + frames->rest;
}

}  // namespace creep::fuzz
