#include "server/folders/sample_index.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "core/arithmetic/check.h"
#include "core/folder/job_directory.h"

namespace creepd {

using creep::RecordKind;

namespace {

constexpr std::uint64_t kPortion = 2000;  // rows that are read before others may

}  // namespace

absl::Status SampleIndex::open() {
  if (reader_) return absl::OkStatus();
  auto reader = creep::SampleLogReader::open(path_);
  if (!reader.ok()) return reader.status();
  reader_.emplace(*std::move(reader));
  return absl::OkStatus();
}

absl::StatusOr<std::uint64_t> SampleIndex::poll() {
  const std::lock_guard lock(mutex_);
  if (auto status = open(); !status.ok()) {
    if (absl::IsNotFound(status)) return places(RecordKind::kSample).size();
    return status;
  }
  reader_->seek(end_);
  for (;;) {
    const std::uint64_t before = reader_->offset();
    const auto frame = reader_->next();
    if (!frame.ok()) return frame.status();
    if (!*frame) return places(RecordKind::kSample).size();
    // The first frame begins behind the head of the file, which next() passes over.
    const std::uint64_t offset = before == 0 ? creep::kFirstFrame : before;
    end_ = reader_->offset();
    if ((*frame)->record) {
      places((*frame)->record->kind).push_back({(*frame)->record->sequence, offset});
      continue;
    }
    for (Places& rows : places_) {
      while (!rows.empty() && rows.back().sequence >= (*frame)->superseded_from) rows.pop_back();
    }
  }
}

std::uint64_t SampleIndex::size(RecordKind kind) const {
  const std::lock_guard lock(mutex_);
  return places(kind).size();
}

std::uint64_t SampleIndex::rows_at(RecordKind kind, std::uint64_t samples) const {
  const std::lock_guard lock(mutex_);
  const Places& rows = places(kind);
  const Places& told = places(RecordKind::kSample);
  if (samples >= told.size()) return rows.size();
  const auto later = [&](const Place& row) { return row.sequence < told[samples].sequence; };
  return static_cast<std::uint64_t>(std::partition_point(rows.begin(), rows.end(), later) - rows.begin());
}

absl::StatusOr<creep::Record> SampleIndex::record_at(const Place& place, RecordKind kind) {
  if (auto status = open(); !status.ok()) return status;
  reader_->seek(place.offset);
  auto frame = reader_->again();
  if (!frame.ok()) return frame.status();
  if (!*frame || !(*frame)->record || (*frame)->record->kind != kind ||
      (*frame)->record->sequence != place.sequence) {
    return absl::DataLossError(absl::StrCat(path_.string(), ": record ", place.sequence, " is gone"));
  }
  return *std::move((*frame)->record);
}

absl::StatusOr<creep::Record> SampleIndex::read(std::uint64_t index) {
  const std::lock_guard lock(mutex_);
  CREEP_CHECK(index < places(RecordKind::kSample).size(), "reads only samples that are there");
  return record_at(places(RecordKind::kSample)[index], RecordKind::kSample);
}

absl::Status SampleIndex::visit(RecordKind kind, std::uint64_t first, std::uint64_t end,
                                const std::function<bool(std::uint64_t, const creep::Record&)>& take) {
  while (first < end) {
    const std::lock_guard lock(mutex_);
    for (const std::uint64_t portion = std::min(end, first + kPortion); first < portion; ++first) {
      // Rows may have become fewer since, superseded by others.
      if (first >= places(kind).size()) return absl::OkStatus();
      const auto record = record_at(places(kind)[first], kind);
      if (!record.ok()) return record.status();
      if (!take(first, *record)) return absl::OkStatus();
    }
  }
  return absl::OkStatus();
}

std::shared_ptr<SampleIndex> SampleLibrary::of(const std::string& job) {
  const std::lock_guard lock(mutex_);
  std::shared_ptr<SampleIndex> index = known_[job].lock();
  if (!index) {
    index = std::make_shared<SampleIndex>(creep::JobDirectory(jobs_ / job).sample_log());
    known_[job] = index;
  }
  recent_.remove_if([&](const auto& entry) { return entry.first == job; });
  recent_.emplace_front(job, index);
  if (recent_.size() > kKept) recent_.pop_back();
  std::erase_if(known_, [](const auto& entry) { return entry.second.expired(); });
  return index;
}

void SampleLibrary::forget(const std::string& job) {
  const std::lock_guard lock(mutex_);
  known_.erase(job);
  recent_.remove_if([&](const auto& entry) { return entry.first == job; });
}

}  // namespace creepd
