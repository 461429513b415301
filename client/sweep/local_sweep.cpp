#include "client/sweep/local_sweep.h"

#include <algorithm>
#include <chrono>
#include <list>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/local/run_end.h"
#include "client/local/run_folder.h"
#include "client/local/start_checkpoint.h"
#include "client/local/worker_process.h"
#include "core/experiment/job_text.h"

namespace creepctl {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

struct RunningJob {
  std::size_t index = 0;
  WorkerProcess worker;
};

/// Two job files that differ at most in where the source of [start] lies: a sweep's folder may be moved.
bool same_but_for_the_source(const std::string& one, const std::string& other) {
  const auto plain = creep::with_overrides(one, {{"start.job", "source"}});
  const auto other_plain = creep::with_overrides(other, {{"start.job", "source"}});
  return plain.ok() && other_plain.ok() && *plain == *other_plain;
}

class LocalSweep {
 public:
  LocalSweep(const std::vector<SweepJob>& jobs, const LocalSweepOptions& options,
             const std::function<void(const std::string&)>& say)
      : jobs_(jobs), options_(options), say_(say), ends_(jobs.size()) {
    for (std::size_t i = 0; i < jobs.size(); ++i) {
      ends_[i].name = jobs[i].name;
      ends_[i].place = folder(i).string();
      ends_[i].exit_code = kRunAgain;
      ends_[i].message = "not begun";
    }
  }

  std::vector<SweepEnd> run() {
    // Where all workers ended since, a trunk may have kept what a branch waits for: looked at once more.
    while (begin_what_can() || !running_.empty()) watch();
    return std::move(ends_);
  }

 private:
  fs::path folder(std::size_t index) const { return options_.out / jobs_[index].name; }

  void end(std::size_t index, int exit_code, const std::string& message) {
    ends_[index].ended = exit_code != kRunAgain;
    ends_[index].exit_code = exit_code;
    ends_[index].message = message;
    begun_[index] = true;
    say_(absl::StrCat(jobs_[index].name, ": ", message));
  }

  bool kept(std::size_t branch) const {
    std::error_code error;
    return fs::is_regular_file(
        folder(*jobs_[branch].trunk) / "checkpoints" / ("keep." + jobs_[branch].checkpoint), error);
  }

  /// Whether a job may begin. A branch whose trunk ended without its checkpoint ends here.
  bool can_begin(std::size_t index) {
    if (begun_[index]) return false;
    const SweepJob& job = jobs_[index];
    if (!job.trunk || kept(index)) return true;
    std::error_code error;
    if (fs::is_regular_file(folder(index) / "checkpoints" / "start", error)) return true;
    const SweepEnd& trunk = ends_[*job.trunk];
    if (trunk.ended)
      end(index, kFailed,
          absl::StrCat(trunk.name, " ended without the checkpoint ", job.checkpoint, " (", trunk.message,
                       ")"));
    return false;
  }

  /// Begins jobs until enough run; whether anything was begun or ended.
  bool begin_what_can() {
    bool changed = false;
    for (std::size_t i = 0; i < jobs_.size() && !stopping_; ++i) {
      if (running_.size() >= static_cast<std::size_t>(options_.at_once)) break;
      const bool before = begun_[i];
      if (can_begin(i)) begin(i);
      changed = changed || begun_[i] != before;
    }
    return changed;
  }

  void begin(std::size_t index) {
    begun_[index] = true;
    const auto state = prepare(index);
    if (!state.ok()) {
      const bool input =
          absl::IsFailedPrecondition(state.status()) || absl::IsInvalidArgument(state.status());
      return end(index, input ? kInvalidInput : kIoError, std::string(state.status().message()));
    }
    if (*state == RunFolderState::kFinished)
      return end(index, kOk, absl::StrCat("done before: ", outcome_sentence(folder(index))));
    if (!wait_for_orphan(folder(index)))
      return end(index, kFailed, absl::StrCat(folder(index).string(), " is in use by another run"));
    auto worker =
        WorkerProcess::start({folder(index).string(), "--threads", std::to_string(options_.threads)},
                             folder(index) / "worker.log");
    if (!worker.ok()) return end(index, kFailed, std::string(worker.status().message()));
    running_.push_back({index, *std::move(worker)});
    say_(absl::StrCat(jobs_[index].name, ": ", *state == RunFolderState::kNew ? "begins" : "goes on"));
  }

  /// The folder with all that a worker needs in it.
  absl::StatusOr<RunFolderState> prepare(std::size_t index) {
    JobFile file;
    file.path = folder(index).string() + ".toml";
    file.text = jobs_[index].text;
    std::string start;
    if (jobs_[index].trunk) {
      auto taken = prepare_branch(index, file);
      if (!taken.ok()) return taken.status();
      start = *std::move(taken);
    }
    const auto state = look_at_run_folder(folder(index), file.text, options_.job_path);
    if (!state.ok()) return state;
    if (*state == RunFolderState::kNew) {
      if (auto begun = begin_run_folder(folder(index), file.text); !begun.ok()) return begun;
    }
    if (!start.empty() && *state != RunFolderState::kFinished) {
      if (auto written = write_start(folder(index), start); !written.ok()) return written;
    }
    return state;
  }

  /// Completes the job file of a branch; its checkpoint, "" if that is in its folder already.
  absl::StatusOr<std::string> prepare_branch(std::size_t index, JobFile& file) {
    std::error_code error;
    const fs::path trunk = fs::absolute(folder(*jobs_[index].trunk), error).lexically_normal();
    auto text = started_from(jobs_[index], trunk.string());
    if (!text.ok()) return text.status();
    file.text = *std::move(text);
    const std::string there = read_text(folder(index) / "job.toml");
    const bool has_start = fs::is_regular_file(folder(index) / "checkpoints" / "start", error);
    if (has_start && same_but_for_the_source(there, file.text)) {
      file.text = there;
      return "";
    }
    file.experiment = creep::parse_experiment(file.text).experiment;
    if (!file.experiment) return absl::InvalidArgumentError("its job file cannot be read");
    return take_start(file);
  }

  void watch() {
    const milliseconds patience(std::max<std::size_t>(1, 100 / std::max<std::size_t>(1, running_.size())));
    for (auto job = running_.begin(); job != running_.end();) {
      const auto ended = job->worker.wait(patience);
      if (job->worker.stopping() && !std::exchange(stopping_, true)) {
        for (RunningJob& other : running_) other.worker.stop();
      }
      if (!ended) {
        ++job;
        continue;
      }
      const int exit_code = exit_code_of(*ended);
      end(job->index, exit_code,
          exit_code == kOk ? absl::StrCat("done: ", outcome_sentence(folder(job->index)))
                           : absl::StrJoin(explanation(*ended, folder(job->index)), "; "));
      job = running_.erase(job);
    }
  }

  const std::vector<SweepJob>& jobs_;
  const LocalSweepOptions& options_;
  const std::function<void(const std::string&)>& say_;
  std::vector<SweepEnd> ends_;
  std::vector<bool> begun_ = std::vector<bool>(jobs_.size());
  std::list<RunningJob> running_;
  bool stopping_ = false;
};

}  // namespace

absl::Status check_sweep_folder(const std::vector<SweepJob>& jobs, const LocalSweepOptions& options) {
  std::error_code error;
  if (fs::exists(options.out / "job.toml", error)) {
    return absl::FailedPreconditionError(absl::StrCat(
        options.out.string(), " is the folder of a run, which holds no sweep; give another --out"));
  }
  for (const SweepJob& job : jobs) {
    const fs::path folder = options.out / job.name;
    std::string text = job.text;
    if (job.trunk) {
      const std::string there = read_text(folder / "job.toml");
      const auto started = started_from(job, "source");
      if (!started.ok()) return started.status();
      text = same_but_for_the_source(there, *started) ? there : *started;
    }
    if (const auto state = look_at_run_folder(folder, text, options.job_path); !state.ok())
      return state.status();
  }
  return absl::OkStatus();
}

std::vector<SweepEnd> sweep_locally(const std::vector<SweepJob>& jobs, const LocalSweepOptions& options,
                                    const std::function<void(const std::string&)>& say) {
  return LocalSweep(jobs, options, say).run();
}

}  // namespace creepctl
