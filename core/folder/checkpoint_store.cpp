#include "core/folder/checkpoint_store.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "core/folder/durable_file.h"

namespace creep {
namespace {

absl::Status status_of(std::string_view what, const std::error_code& error) {
  return errno_status(what, error.value());
}

absl::Status remove_leftovers(const std::filesystem::path& directory) {
  std::error_code error;
  std::vector<std::filesystem::path> leftovers;
  for (std::filesystem::directory_iterator entry(directory, error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path().extension() == ".tmp") leftovers.push_back(entry->path());
  }
  for (const auto& path : leftovers) std::filesystem::remove(path, error);
  return error ? status_of(absl::StrCat("clean ", directory.string()), error) : absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<std::uint64_t>> numbered_files(const std::filesystem::path& directory,
                                                          std::string_view prefix) {
  const std::string start = absl::StrCat(std::string(prefix), ".");
  std::vector<std::uint64_t> numbers;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(directory, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with(start)) continue;
    std::uint64_t number = 0;
    const char* const last = name.data() + name.size();
    const auto parsed = std::from_chars(name.data() + start.size(), last, number);
    if (parsed.ec == std::errc() && parsed.ptr == last) numbers.push_back(number);
  }
  if (error) return status_of(absl::StrCat("list ", directory.string()), error);
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

absl::StatusOr<CheckpointStore> CheckpointStore::open(const std::filesystem::path& directory, Verify verify) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) return status_of(absl::StrCat("create ", directory.string()), error);
  CheckpointStore store(directory, verify);
  auto good = numbered_files(directory, "ck");
  if (!good.ok()) return good.status();
  if (!good->empty()) {
    const auto newest = read_file(store.file_of(good->back()));
    if (!newest.ok()) return newest.status();
    const auto info = verify(*newest);
    if (absl::IsFailedPrecondition(info.status())) return info.status();
  }
  if (auto synced = sync_directory(directory.parent_path()); !synced.ok()) return synced;
  if (auto cleaned = remove_leftovers(directory); !cleaned.ok()) return cleaned;
  const auto bad = numbered_files(directory, "bad");
  if (!bad.ok()) return bad.status();
  store.generations_ = *std::move(good);
  if (!store.generations_.empty()) store.last_number_ = store.generations_.back();
  if (!bad->empty()) store.last_number_ = std::max(store.last_number_, bad->back());
  return store;
}

absl::StatusOr<CheckpointStore::Newest> CheckpointStore::load_newest(
    const std::function<absl::Status(const CheckpointInfo&)>& usable) {
  Newest newest;
  while (!generations_.empty() && !newest.loaded) {
    const std::uint64_t generation = generations_.back();
    auto bytes = read_file(file_of(generation));
    if (!bytes.ok()) return bytes.status();
    auto info = verify_(*bytes);
    if (absl::IsFailedPrecondition(info.status())) return info.status();
    const absl::Status verdict = info.ok() ? usable(*info) : info.status();
    if (verdict.ok()) {
      newest.loaded = Loaded{generation, *std::move(bytes), *std::move(info)};
      break;
    }
    newest.rejected.push_back({generation, std::string(verdict.message())});
    std::error_code error;
    std::filesystem::rename(file_of(generation), directory_ / absl::StrCat("bad.", generation), error);
    if (error) return status_of(absl::StrCat("set aside ", file_of(generation).string()), error);
    generations_.pop_back();
  }
  return newest;
}

absl::Status CheckpointStore::keep(std::string_view name, std::string_view bytes) const {
  return write_durably(directory_ / absl::StrCat("keep.", std::string(name)), bytes);
}

absl::StatusOr<std::uint64_t> CheckpointStore::add(std::string_view bytes) {
  const std::uint64_t generation = last_number_ + 1;
  const auto path = file_of(generation);
  if (auto written = write_durably(path, bytes); !written.ok()) return written;
  const auto again = read_file(path);
  if (!again.ok()) return again.status();
  const auto info = verify_(*again);
  if (!info.ok() || *again != bytes) {
    std::error_code ignored;  // the damage is what is reported
    std::filesystem::remove(path, ignored);
    return absl::DataLossError(
        absl::StrCat(path.string(), " does not read back as written: ",
                     info.ok() ? "other bytes" : std::string(info.status().message())));
  }
  last_number_ = generation;
  generations_.push_back(generation);
  while (generations_.size() > kGenerations) {
    std::error_code error;
    std::filesystem::remove(file_of(generations_.front()), error);
    if (error) return status_of(absl::StrCat("remove ", file_of(generations_.front()).string()), error);
    generations_.erase(generations_.begin());
  }
  return generation;
}

std::filesystem::path CheckpointStore::file_of(std::uint64_t generation) const {
  return directory_ / absl::StrCat("ck.", generation);
}

}  // namespace creep
