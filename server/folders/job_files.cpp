#include "server/folders/job_files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <optional>
#include <system_error>

#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "core/folder/checkpoint_store.h"
#include "core/folder/durable_file.h"
#include "core/folder/job_directory.h"
#include "core/folder/sample_log.h"
#include "core/run/run.h"
#include "server/rules/refusal.h"

namespace creepd {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kKept = "keep.";

bool is_given_out(std::string_view folder, std::string_view name) {
  if (name.ends_with(".tmp")) return false;
  if (folder == "checkpoints") {
    return name.starts_with("ck.") || name.starts_with("bad.") || name.starts_with(kKept) || name == "start";
  }
  if (folder == "snapshots") return name.ends_with(".vtp") || name.ends_with(".pvd");
  constexpr std::array kFiles = {"job.toml",     "samples.log",   "samples.csv",   "stages.csv",
                                 "gsd.csv",      "breakages.csv", "progress.json", "stage_timings.csv",
                                 "verdict.json", "summary.json",  "worker.log"};
  return std::find(kFiles.begin(), kFiles.end(), name) != kFiles.end() ||
         name.starts_with("samples.log.damaged-");
}

std::optional<Artifact> look_at(int directory, const char* path, std::string name) {
  struct statx about {};
  if (::statx(directory, path, AT_SYMLINK_NOFOLLOW | (*path == '\0' ? AT_EMPTY_PATH : 0),
              STATX_BASIC_STATS | STATX_BTIME, &about) != 0 ||
      !S_ISREG(about.stx_mode)) {
    return std::nullopt;
  }
  Artifact artifact;
  artifact.name = std::move(name);
  artifact.size = about.stx_size;
  artifact.modified = about.stx_mtime.tv_sec * 1'000'000 + about.stx_mtime.tv_nsec / 1000;
  artifact.etag = absl::StrCat(absl::Hex(about.stx_ino), "-", absl::Hex(about.stx_btime.tv_sec), "-",
                               absl::Hex(about.stx_btime.tv_nsec));
  return artifact;
}

absl::Status checkpoint_damaged(std::string_view why) {
  return refuse(absl::StatusCode::kDataLoss, why, {"CHECKPOINT_DAMAGED", {}, {}, {}});
}

absl::StatusOr<ChosenCheckpoint> read_checkpoint(const fs::path& path, CheckpointChoice choice) {
  auto bytes = creep::read_file(path);
  if (!bytes.ok()) return bytes.status();
  auto info = creep::read_checkpoint_info(*bytes);
  if (info.ok()) return ChosenCheckpoint{std::move(choice), *std::move(bytes), *std::move(info)};
  return checkpoint_damaged(absl::StrCat("checkpoint ", path.filename().string(),
                                         " is damaged: ", std::string(info.status().message())));
}

absl::StatusOr<ChosenCheckpoint> choose_kept(const fs::path& folder, const std::string& name) {
  std::vector<std::string> names;
  for (const Artifact& artifact : list_artifacts(folder)) {
    const std::string prefix = absl::StrCat("checkpoints/", std::string(kKept));
    if (!artifact.name.starts_with(prefix)) continue;
    names.push_back(artifact.name.substr(prefix.size()));
    if (names.back() == name) return read_checkpoint(folder / artifact.name, {0, name});
  }
  return refuse(absl::StatusCode::kNotFound, "the job keeps no checkpoint of this name",
                {"CHECKPOINT_NOT_FOUND", {{"kept", absl::StrJoin(names, ",")}}, {}, {}});
}

/// The bytes of the log up to the record that the checkpoint goes on with.
absl::StatusOr<std::string> records_before(const fs::path& log, std::uint64_t next_sequence) {
  auto reader = creep::SampleLogReader::open(log);
  if (!reader.ok()) return reader.status();
  std::uint64_t end = creep::kFirstFrame;
  for (std::uint64_t sequence = 0; sequence < next_sequence;) {
    const auto frame = reader->next();
    if (!frame.ok() || !*frame) return checkpoint_damaged("the records before the checkpoint cannot be read");
    sequence = (*frame)->record ? (*frame)->record->sequence + 1 : (*frame)->superseded_from;
    end = reader->offset();
  }
  auto bytes = creep::read_file(log);
  if (bytes.ok()) bytes->resize(std::min<std::size_t>(bytes->size(), end));
  return bytes;
}

}  // namespace

absl::Status make_job_folder(const fs::path& folder, std::string_view spec) {
  if (::mkdir(folder.c_str(), 0755) != 0)
    return creep::errno_status(absl::StrCat("mkdir ", folder.string()), errno);
  absl::Status status = creep::replace_file(creep::JobDirectory(folder).job_file(), spec);
  if (!status.ok()) {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
  return status;
}

absl::Status secure_job_folder(const fs::path& folder, std::string_view spec) {
  if (::mkdir(folder.c_str(), 0755) != 0 && errno != EEXIST) {
    return creep::errno_status(absl::StrCat("mkdir ", folder.string()), errno);
  }
  if (auto status = creep::write_durably(creep::JobDirectory(folder).job_file(), spec); !status.ok())
    return status;
  return creep::sync_directory(folder.parent_path());
}

std::vector<Artifact> list_artifacts(const fs::path& folder) {
  std::vector<Artifact> artifacts;
  for (const std::string sub : {"", "checkpoints", "snapshots"}) {
    std::error_code error;
    for (fs::directory_iterator entry(folder / sub, error), end; !error && entry != end;
         entry.increment(error)) {
      const std::string name = entry->path().filename().string();
      if (!is_given_out(sub, name)) continue;
      if (auto artifact =
              look_at(AT_FDCWD, entry->path().c_str(), sub.empty() ? name : absl::StrCat(sub, "/", name))) {
        artifacts.push_back(*std::move(artifact));
      }
    }
  }
  std::sort(artifacts.begin(), artifacts.end(),
            [](const Artifact& left, const Artifact& right) { return left.name < right.name; });
  return artifacts;
}

absl::StatusOr<OpenArtifact> open_artifact(const fs::path& folder, std::string_view name) {
  const auto not_found = [&] {
    return refuse(absl::StatusCode::kNotFound, "there is no such artifact",
                  {"ARTIFACT_NOT_FOUND", {}, {}, {}});
  };
  for (const Artifact& listed : list_artifacts(folder)) {
    if (listed.name != name) continue;
    auto file = creep::open_file(folder / listed.name, O_RDONLY | O_NOFOLLOW);
    if (absl::IsNotFound(file.status())) return not_found();
    if (!file.ok()) return file.status();
    auto opened = look_at(file->get(), "", listed.name);
    if (!opened) return not_found();
    return OpenArtifact{*std::move(opened), *std::move(file)};
  }
  return not_found();
}

std::uint64_t newest_checkpoint(const fs::path& folder) {
  const auto generations = creep::numbered_files(creep::JobDirectory(folder).checkpoints(), "ck");
  return generations.ok() && !generations->empty() ? generations->back() : 0;
}

std::string log_tail(const fs::path& folder) {
  constexpr std::size_t kMostBytes = 4096;
  const auto text = creep::read_file(creep::JobDirectory(folder).worker_log(), std::uint64_t{1} << 28);
  if (!text.ok()) return "";
  std::string tail = text->substr(text->size() - std::min(text->size(), kMostBytes));
  if (tail.size() < text->size()) tail.erase(0, tail.find('\n') + 1);
  return tail;
}

std::string state_digest(const fs::path& folder) {
  const auto text = creep::read_file(creep::JobDirectory(folder).summary(), 1 << 20);
  if (!text.ok()) return "";
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  const auto digest = json.is_object() ? json.find("state_digest") : json.end();
  return digest != json.end() && digest->is_string() ? digest->get<std::string>() : "";
}

std::optional<std::int64_t> verdict_attempt(const fs::path& folder) {
  const auto text = creep::read_file(creep::JobDirectory(folder).verdict(), 1 << 20);
  if (!text.ok()) return std::nullopt;
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  const auto attempt = json.is_object() ? json.find("attempt") : json.end();
  if (attempt == json.end() || !attempt->is_number_integer()) return std::nullopt;
  return attempt->get<std::int64_t>();
}

std::optional<std::int64_t> lease_attempt(const fs::path& folder) {
  const auto text = creep::read_file(creep::JobDirectory(folder).lease(), 4096);
  long long attempt = 0;
  if (!text.ok() || std::sscanf(text->c_str(), "attempt %lld", &attempt) != 1) return std::nullopt;
  return attempt;
}

std::string lease_holder(const fs::path& folder) {
  const auto text = creep::read_file(creep::JobDirectory(folder).lease(), 4096);
  long long process = 0;
  if (!text.ok() || std::sscanf(text->c_str(), "attempt %*d process %lld", &process) != 1) return "a process";
  return absl::StrCat("process ", process);
}

bool lease_is_held(const fs::path& folder) {
  const auto file = creep::open_file(creep::JobDirectory(folder).lease(), O_RDWR);
  if (!file.ok()) return false;
  return ::flock(file->get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

std::uint64_t free_bytes(const fs::path& path) {
  struct statvfs about {};
  if (::statvfs(path.c_str(), &about) != 0) return 0;
  return static_cast<std::uint64_t>(about.f_bavail) * about.f_frsize;
}

std::uint64_t needed_bytes(const fs::path& folder) {
  constexpr std::uint64_t kLeast = 1 << 20;
  std::error_code error;
  const auto newest = newest_checkpoint(folder);
  const auto size =
      fs::file_size(creep::JobDirectory(folder).checkpoints() / absl::StrCat("ck.", newest), error);
  return error ? kLeast : std::max<std::uint64_t>(kLeast, 3 * size);
}

absl::StatusOr<ChosenCheckpoint> choose_checkpoint(const fs::path& folder, const CheckpointChoice& choice) {
  if (!choice.kept.empty()) return choose_kept(folder, choice.kept);
  const fs::path checkpoints = creep::JobDirectory(folder).checkpoints();
  auto generations = creep::numbered_files(checkpoints, "ck");
  if (!generations.ok() && !absl::IsNotFound(generations.status())) return generations.status();
  const std::vector<std::uint64_t> all = generations.ok() ? *generations : std::vector<std::uint64_t>();
  const std::uint64_t generation = choice.generation;
  const bool there =
      generation == 0 ? !all.empty() : std::find(all.begin(), all.end(), generation) != all.end();
  if (!there) {
    return refuse(absl::StatusCode::kNotFound,
                  generation == 0 ? "the job has no checkpoint yet"
                                  : absl::StrCat("the job has no checkpoint ", generation),
                  {"CHECKPOINT_NOT_FOUND", {{"generations", absl::StrJoin(all, ",")}}, {}, {}});
  }
  absl::Status trouble;
  for (auto candidate = all.rbegin(); candidate != all.rend(); ++candidate) {
    if (generation != 0 && *candidate != generation) continue;
    auto chosen = read_checkpoint(checkpoints / absl::StrCat("ck.", *candidate), {*candidate, ""});
    if (chosen.ok() || !absl::IsDataLoss(chosen.status())) return chosen;
    trouble = chosen.status();
  }
  return trouble;
}

absl::Status continue_from(const fs::path& source, const ChosenCheckpoint& checkpoint,
                           const fs::path& target) {
  const creep::JobDirectory to(target);
  const auto records =
      records_before(creep::JobDirectory(source).sample_log(), checkpoint.info.next_sequence);
  if (!records.ok()) return records.status();
  if (auto status = creep::write_durably(to.sample_log(), *records); !status.ok()) return status;
  if (::mkdir(to.checkpoints().c_str(), 0755) != 0) {
    return creep::errno_status(absl::StrCat("mkdir ", to.checkpoints().string()), errno);
  }
  if (auto status = creep::write_durably(to.checkpoints() / "ck.1", checkpoint.bytes); !status.ok())
    return status;
  return creep::sync_directory(target);
}

absl::Status start_from(const ChosenCheckpoint& checkpoint, const fs::path& target) {
  const creep::JobDirectory to(target);
  if (::mkdir(to.checkpoints().c_str(), 0755) != 0) {
    return creep::errno_status(absl::StrCat("mkdir ", to.checkpoints().string()), errno);
  }
  if (auto status = creep::write_durably(to.start_checkpoint(), checkpoint.bytes); !status.ok())
    return status;
  return creep::sync_directory(target);
}

}  // namespace creepd
