#include "server/folders/sample_index.h"

#include "absl/strings/str_cat.h"
#include "core/arithmetic/check.h"
#include "core/folder/job_directory.h"

namespace creepd {

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
    if (absl::IsNotFound(status)) return samples_.size();
    return status;
  }
  reader_->seek(end_);
  for (;;) {
    const std::uint64_t before = reader_->offset();
    const auto frame = reader_->next();
    if (!frame.ok()) return frame.status();
    if (!*frame) return samples_.size();
    // The first frame begins behind the head of the file, which next() passes over.
    const std::uint64_t offset = before == 0 ? creep::kFirstFrame : before;
    end_ = reader_->offset();
    if (!(*frame)->record) {
      while (!samples_.empty() && samples_.back().sequence >= (*frame)->superseded_from) samples_.pop_back();
    } else if ((*frame)->record->kind == creep::RecordKind::kSample) {
      samples_.push_back({(*frame)->record->sequence, offset});
    }
  }
}

std::uint64_t SampleIndex::size() const {
  const std::lock_guard lock(mutex_);
  return samples_.size();
}

absl::StatusOr<creep::Record> SampleIndex::read(std::uint64_t index) {
  const std::lock_guard lock(mutex_);
  CREEP_CHECK(index < samples_.size(), "reads only samples that are there");
  if (auto status = open(); !status.ok()) return status;
  const Place place = samples_[index];
  reader_->seek(place.offset);
  auto frame = reader_->next();
  if (!frame.ok()) return frame.status();
  if (!*frame || !(*frame)->record || (*frame)->record->kind != creep::RecordKind::kSample ||
      (*frame)->record->sequence != place.sequence) {
    return absl::DataLossError(absl::StrCat(path_.string(), ": sample ", index, " is gone"));
  }
  return *std::move((*frame)->record);
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
