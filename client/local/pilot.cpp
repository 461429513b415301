#include "client/local/pilot.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "absl/strings/str_cat.h"
#include "client/local/run_folder.h"
#include "client/local/worker_process.h"

namespace creepctl {
namespace {

namespace fs = std::filesystem;

/// Removed with all that is in it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::error_code error;
    std::string pattern = (fs::temp_directory_path(error) / "creepctl-plan-XXXXXX").string();
    if (!error && ::mkdtemp(pattern.data()) != nullptr) path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// Computes what is in the folder; how it ended. Error: Unavailable, Aborted.
absl::StatusOr<std::string> compute(const fs::path& folder, int threads) {
  auto worker =
      WorkerProcess::start({folder.string(), "--threads", std::to_string(threads)}, folder / "worker.log");
  if (!worker.ok()) return worker.status();
  std::optional<WorkerEnd> end;
  while (!(end = worker->wait(std::chrono::milliseconds(100)))) {
  }
  std::ifstream file(folder / "verdict.json");
  const auto verdict = nlohmann::ordered_json::parse(file, nullptr, false);
  const std::string reason = verdict.is_object() ? verdict.value("reason", std::string())
                                                 : absl::StrCat("exit code ", end->exit_code);
  if (worker->stopping()) return absl::AbortedError("stopped");
  if (end->signal != 0 || end->exit_code != 0)
    return absl::AbortedError(absl::StrCat("a small specimen of this job was stopped: ", reason));
  return reason;
}

}  // namespace

absl::StatusOr<creep::Pilot> run_pilot(const JobFile& job, int threads) {
  const auto text = creep::pilot_text(job.text, *job.experiment);
  if (!text.ok()) return text.status();
  const TemporaryFolder temporary;
  if (temporary.path().empty()) return absl::UnavailableError("cannot make a temporary folder");
  const fs::path folder = temporary.path() / "pilot";
  if (auto begun = begin_run_folder(folder, *text); !begun.ok()) return begun;
  const auto reason = compute(folder, threads);
  if (!reason.ok()) return reason.status();
  return creep::read_pilot(
      {*text, read_text(folder / "stages.csv"), read_text(folder / "stage_timings.csv"), *reason});
}

}  // namespace creepctl
