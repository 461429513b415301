#include "client/local/start_checkpoint.h"

#include <charconv>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "client/local/run_folder.h"
#include "core/experiment/job_text.h"
#include "core/experiment/wording.h"
#include "core/run/run.h"

namespace creepctl {
namespace {

namespace fs = std::filesystem;

/// checkpoints/keep.NAME, checkpoints/ck.N, or the newest good ck.N; "" if there is none.
fs::path file_of(const fs::path& folder, const std::string& checkpoint) {
  std::error_code error;
  const fs::path checkpoints = folder / "checkpoints";
  for (const char* prefix : {"keep.", "ck."}) {
    const fs::path file = checkpoints / absl::StrCat(prefix, checkpoint);
    if (!checkpoint.empty() && fs::is_regular_file(file, error)) return file;
  }
  if (!checkpoint.empty()) return {};
  fs::path newest;
  std::uint64_t highest = 0;
  for (fs::directory_iterator entry(checkpoints, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    std::uint64_t number = 0;
    if (!name.starts_with("ck.")) continue;
    const char* const end_of_name = name.data() + name.size();
    const auto parsed = std::from_chars(name.data() + 3, end_of_name, number);
    if (parsed.ec != std::errc() || parsed.ptr != end_of_name || number <= highest) continue;
    if (!creep::read_checkpoint_info(read_text(entry->path())).ok()) continue;
    highest = number;
    newest = entry->path();
  }
  return newest;
}

std::string first_error(const creep::ParseResult& parsed, const std::string& text_of) {
  const creep::Diagnostic& error = parsed.errors.front();
  return absl::StrCat(text_of, ":", error.line, ":", error.column, ": ", error.message);
}

}  // namespace

absl::StatusOr<std::string> take_start(JobFile& job) {
  const creep::Start start = *job.experiment->start;
  const fs::path folder = fs::absolute(fs::path(job.path).parent_path() / start.job).lexically_normal();
  std::error_code error;
  if (!fs::is_regular_file(folder / "job.toml", error)) {
    return absl::InvalidArgumentError(
        absl::StrCat("[start] job = ", creep::quoted(start.job), ": ", folder.string(),
                     " is not the folder of a run (a job of a daemon is started "
                     "from with creepctl submit)"));
  }
  const fs::path file = file_of(folder, start.checkpoint);
  if (file.empty()) {
    return absl::InvalidArgumentError(absl::StrCat("[start] checkpoint = ", creep::quoted(start.checkpoint),
                                                   ": ", (folder / "checkpoints").string(),
                                                   " has no such checkpoint"));
  }
  const auto whole = creep::with_sections_of(job.text, read_text(folder / "job.toml"));
  if (!whole.ok()) return whole.status();
  // The folder in full, so that the job file left in the run's folder says the same from anywhere.
  const auto text = creep::with_overrides(*whole, {{"start.job", absl::StrCat("\"", folder.string(), "\"")}});
  if (!text.ok()) return text.status();
  const creep::ParseResult parsed = creep::parse_experiment(*text);
  if (!parsed.experiment)
    return absl::InvalidArgumentError(first_error(parsed, "with the sections of the source"));
  std::string bytes = read_text(file);
  const auto info = creep::read_checkpoint_info(bytes);
  const absl::Status can =
      info.ok() ? creep::can_start_from(*info, creep::specimen_hash(*parsed.experiment)) : info.status();
  if (!can.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(file.string(), ": ", std::string(can.message())));
  }
  job.text = *text;
  job.experiment = parsed.experiment;
  return bytes;
}

absl::Status write_start(const fs::path& run_folder, const std::string& checkpoint) {
  std::error_code error;
  const fs::path folder = run_folder / "checkpoints";
  const fs::path file = folder / "start";
  if (fs::is_regular_file(file, error)) return absl::OkStatus();
  fs::create_directories(folder, error);
  if (error)
    return absl::UnavailableError(absl::StrCat("cannot make ", folder.string(), ": ", error.message()));
  return write_by_rename(file, checkpoint);
}

}  // namespace creepctl
