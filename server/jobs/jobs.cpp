#include "server/jobs/jobs.h"

#include <sys/random.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/arithmetic/digest.h"
#include "core/experiment/job_text.h"
#include "core/folder/durable_file.h"
#include "core/run/run.h"
#include "server/host/wall_clock.h"
#include "server/jobs/spec_check.h"
#include "server/rules/refusal.h"

namespace creepd {
namespace {

constexpr std::size_t kMostLabels = 32;
constexpr std::size_t kMostLabelValue = 256;
constexpr std::size_t kMostOverrides = 64;
constexpr std::size_t kMostRequestId = 128;
constexpr int kMostPriority = 100;

/// Ten characters that cannot be taken for each other, 49 random bits.
std::string new_id() {
  constexpr std::string_view kCharacters = "abcdefghjkmnpqrstuvwxyz23456789";
  std::array<unsigned char, 10> random{};
  while (::getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size())) {
  }
  std::string id;
  for (const unsigned char byte : random) id += kCharacters[byte % kCharacters.size()];
  return id;
}

bool is_label_key(const std::string& key) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '.' || c == '-';
  };
  return !key.empty() && key.size() <= 63 && key[0] >= 'a' && key[0] <= 'z' &&
         std::all_of(key.begin(), key.end(), allowed);
}

absl::Status check_fields(const Submission& submission) {
  std::vector<Violation> violations;
  if (submission.labels.size() > kMostLabels) {
    violations.push_back({"labels", absl::StrCat(submission.labels.size(), " given; at most ", kMostLabels)});
  }
  for (const auto& [key, value] : submission.labels) {
    if (!is_label_key(key))
      violations.push_back({absl::StrCat("labels[", key, "]"), "a key is [a-z][a-z0-9_.-]{0,62}"});
    if (value.size() > kMostLabelValue) {
      violations.push_back(
          {absl::StrCat("labels[", key, "]"), absl::StrCat("longer than ", kMostLabelValue, " bytes")});
    }
  }
  if (submission.priority < -kMostPriority || submission.priority > kMostPriority) {
    violations.push_back({"priority", absl::StrCat("must be from ", -kMostPriority, " to ", kMostPriority)});
  }
  const auto printable = [](char c) { return c > ' ' && c < 127; };
  if (submission.request_id.size() > kMostRequestId ||
      !std::all_of(submission.request_id.begin(), submission.request_id.end(), printable)) {
    violations.push_back(
        {"request_id", absl::StrCat("must be 1 to ", kMostRequestId, " printable characters")});
  }
  return violations.empty() ? absl::OkStatus() : bad_request(std::move(violations));
}

RequestKey key_of(const Submission& submission, const std::string& source, const CheckpointChoice& choice) {
  std::string content = absl::StrCat(source, "\n", choice.generation, "\n", submission.priority, "\n");
  if (!choice.kept.empty()) absl::StrAppend(&content, choice.kept.size(), " ", choice.kept, "\n");
  for (const auto& [key, value] : submission.overrides)
    absl::StrAppend(&content, key.size(), " ", key, " ", value.size(), " ", value, "\n");
  for (const auto& [key, value] : submission.labels)
    absl::StrAppend(&content, key, " ", value.size(), " ", value, "\n");
  content += submission.spec;
  return {submission.request_id, creep::sha256_hex(content)};
}

/// The choice that `checkpoint` of [start] makes.
CheckpointChoice choice_of(const std::string& checkpoint) {
  CheckpointChoice choice;
  const char* const end = checkpoint.data() + checkpoint.size();
  const auto [stop, error] = std::from_chars(checkpoint.data(), end, choice.generation);
  if (error == std::errc() && stop == end) return choice;
  return {0, checkpoint};
}

std::string name_of(const CheckpointChoice& choice) {
  return choice.kept.empty() ? absl::StrCat(choice.generation) : choice.kept;
}

std::string quoted(const std::string& text) { return absl::StrCat("\"", text, "\""); }

/// A job file with all keys of the overrides set; every one that cannot be is a violation.
absl::StatusOr<std::string> overridden(const std::string& spec,
                                       const std::map<std::string, std::string>& overrides) {
  if (overrides.empty()) return spec;
  if (overrides.size() > kMostOverrides) {
    return bad_request({{"overrides", absl::StrCat(overrides.size(), " given; at most ", kMostOverrides)}});
  }
  std::vector<creep::OverrideFault> faults;
  auto changed = creep::with_overrides(spec, {overrides.begin(), overrides.end()}, &faults);
  if (changed.ok()) return changed;
  if (faults.empty()) return spec;  // is no TOML: the check that follows says where
  std::vector<Violation> violations;
  for (const creep::OverrideFault& fault : faults)
    violations.push_back({absl::StrCat("overrides[", fault.key, "]"), fault.message});
  return bad_request(std::move(violations));
}

/// The job file of a derived job: that of its parent or its own, which takes over the sections that it leaves
/// out; then what is overridden.
absl::StatusOr<std::string> whole_spec(const Submission& submission, const std::string& parent) {
  if (submission.spec.empty()) return overridden(parent, submission.overrides);
  const auto whole = creep::with_sections_of(submission.spec, parent);
  if (!whole.ok()) return bad_request({{"spec", std::string(whole.status().message())}});
  return overridden(*whole, submission.overrides);
}

/// The same as a job that starts from a checkpoint of another.
absl::StatusOr<std::string> started_spec(const std::string& spec, const std::string& source,
                                         const CheckpointChoice& choice) {
  return creep::with_overrides(
      spec, {{"start.job", quoted(source)}, {"start.checkpoint", quoted(name_of(choice))}});
}

absl::Status can_start(const ChosenCheckpoint& checkpoint, const std::string& specimen_hash) {
  const absl::Status can = creep::can_start_from(checkpoint.info, specimen_hash);
  if (can.ok()) return absl::OkStatus();
  return refuse(absl::StatusCode::kFailedPrecondition, std::string(can.message()),
                {"OTHER_SPECIMEN", {}, {}, {}});
}

absl::Status wrong_state(const Job& job, std::string_view wish) {
  return refuse(absl::StatusCode::kFailedPrecondition,
                absl::StrCat("job ", job.id, " is ", state_name(job.state),
                             job.reason == StateReason::kCancelRequested ? " and about to be cancelled" : "",
                             ": it cannot be ", std::string(wish)),
                {"WRONG_STATE", {{"state", state_name(job.state)}}, {}, {}});
}

}  // namespace

Jobs::Jobs(std::filesystem::path jobs, JobLimits limits, JobStore& store, SampleLibrary& samples,
           std::function<void()> wake)
    : jobs_(std::move(jobs)), limits_(limits), store_(store), samples_(samples), wake_(std::move(wake)) {}

absl::StatusOr<Submission> Jobs::completed(Submission submission) {
  // A longer one is no job file, and is refused without being read.
  if (submission.spec.size() > kMostSpecBytes) submission.overrides.clear();
  auto spec = overridden(submission.spec, submission.overrides);
  if (!spec.ok()) return spec.status();
  submission.spec = *std::move(spec);
  submission.overrides.clear();
  return submission;
}

absl::StatusOr<Job> Jobs::check(const Caller& caller, const Submission& asked) const {
  const auto completed_one = completed(asked);
  if (!completed_one.ok()) return completed_one.status();
  const Submission& submission = *completed_one;
  auto checked = check_all(caller, submission);
  if (!checked.ok()) return checked.status();
  if (checked->start) {
    const std::string& source = checked->start->job;
    auto derived = check_derived(caller, source, choice_of(checked->start->checkpoint), submission);
    if (!derived.ok()) return derived.status();
    checked->job = std::move(derived->checked.job);
    checked->job.parent = source;
    checked->job.parent_generation = derived->checkpoint.choice.generation;
  }
  if (auto status = check_room(checked->job.memory_estimate); !status.ok()) return status;
  return std::move(checked->job);
}

absl::StatusOr<Jobs::Checked> Jobs::check_all(const Caller& caller, const Submission& submission) const {
  if (auto status = check_fields(submission); !status.ok()) return status;
  auto checked = check_spec(submission.spec);
  if (!checked.ok()) return checked.status();
  Job job;
  job.owner = caller.owner;
  job.name = checked->name;
  job.priority = submission.priority;
  job.labels = submission.labels;
  job.spec = submission.spec;
  job.warnings = checked->warnings;
  job.experiment_hash = checked->experiment_hash;
  job.memory_estimate = checked->memory_estimate;
  job.submitted = wall_clock();
  return Checked{std::move(job), checked->specimen_hash, checked->start};
}

absl::Status Jobs::check_room(std::uint64_t memory) const {
  if (memory > limits_.memory) {
    return refuse(absl::StatusCode::kResourceExhausted, "the job needs more memory than there is for jobs",
                  {"TOO_LARGE",
                   {{"needed_bytes", absl::StrCat(memory)}, {"limit_bytes", absl::StrCat(limits_.memory)}},
                   {},
                   {}});
  }
  const std::uint64_t free = free_bytes(jobs_);
  if (free >= limits_.least_free) return absl::OkStatus();
  return refuse(absl::StatusCode::kResourceExhausted, "there is too little free space to take a job",
                {"DISK_FULL", {{"free_bytes", absl::StrCat(free)}}, {}, 60});
}

absl::StatusOr<JobStore::Inserted> Jobs::insert(Job job, const RequestKey& key,
                                                const std::filesystem::path& folder) {
  auto inserted = store_.insert(std::move(job), key, limits_.most_unfinished);
  if (!inserted.ok() || inserted->already_existed) {
    std::error_code ignored;
    std::filesystem::remove_all(folder, ignored);
  }
  if (inserted.ok()) wake_();
  return inserted;
}

absl::StatusOr<JobStore::Inserted> Jobs::submit(const Caller& caller, const Submission& asked) {
  const RequestKey key = key_of(asked, "", {});
  if (auto earlier = store_.find_request(caller.owner, key); !earlier.ok() || *earlier) {
    if (!earlier.ok()) return earlier.status();
    return JobStore::Inserted{**std::move(earlier), true};
  }
  const auto completed_one = completed(asked);
  if (!completed_one.ok()) return completed_one.status();
  const Submission& submission = *completed_one;
  auto checked = check_all(caller, submission);
  if (!checked.ok()) return checked.status();
  if (checked->start) {
    return derive(caller, checked->start->job, choice_of(checked->start->checkpoint), submission, key);
  }
  Job& job = checked->job;
  if (auto status = check_room(job.memory_estimate); !status.ok()) return status;
  job.id = new_id();
  // The folder first; without a row it is removed at the next start of the daemon.
  const std::filesystem::path made = folder(job.id);
  if (auto status = make_job_folder(made, submission.spec); !status.ok()) return status;
  return insert(std::move(job), key, made);
}

absl::StatusOr<JobStore::Inserted> Jobs::fork(const Caller& caller, const std::string& source,
                                              const CheckpointChoice& choice, Submission submission) {
  if (auto parent = get(caller, source); !parent.ok()) return parent.status();
  const RequestKey key = key_of(submission, source, choice);
  if (auto earlier = store_.find_request(caller.owner, key); !earlier.ok() || *earlier) {
    if (!earlier.ok()) return earlier.status();
    return JobStore::Inserted{**std::move(earlier), true};
  }
  return derive(caller, source, choice, std::move(submission), key);
}

absl::Status Jobs::without_checkpoint(const Caller& caller, const std::string& source,
                                      const CheckpointChoice& choice, Submission submission,
                                      const std::string& parent_spec, const absl::Status& missing) const {
  auto spec = whole_spec(submission, parent_spec);
  if (spec.ok()) spec = started_spec(*spec, source, choice);
  absl::Status wrong = spec.status();
  if (spec.ok()) {
    submission.spec = *std::move(spec);
    wrong = check_all(caller, submission).status();
  }
  if (wrong.ok()) return missing;
  Refusal all = refusal_of(wrong);
  all.violations.push_back({"checkpoint", std::string(missing.message())});
  return refuse(wrong.code(), std::string(wrong.message()), all);
}

absl::StatusOr<Jobs::Derived> Jobs::check_derived(const Caller& caller, const std::string& source,
                                                  const CheckpointChoice& choice,
                                                  Submission submission) const {
  const auto parent = get(caller, source);
  if (!parent.ok()) return parent.status();
  auto checkpoint = choose_checkpoint(folder(source), choice);
  if (!checkpoint.ok()) {
    return without_checkpoint(caller, source, choice, std::move(submission), parent->spec,
                              checkpoint.status());
  }
  auto spec = whole_spec(submission, parent->spec);
  if (!spec.ok()) return spec.status();
  submission.spec = *std::move(spec);
  auto checked = check_all(caller, submission);
  // A program that is wrong for a new specimen, like one that begins with creep, can be right from a
  // checkpoint.
  const bool goes_on = checked.ok() && checked->job.experiment_hash == checkpoint->info.experiment_hash;
  if (!goes_on) {
    auto started = started_spec(submission.spec, source, checkpoint->choice);
    if (!started.ok()) return started.status();
    submission.spec = *std::move(started);
    checked = check_all(caller, submission);
    if (!checked.ok()) return checked.status();
    if (auto status = can_start(*checkpoint, checked->specimen_hash); !status.ok()) return status;
  } else if (checkpoint->info.finished) {
    return refuse(absl::StatusCode::kFailedPrecondition,
                  "the program of this checkpoint is carried out: give the new job another one",
                  {"NOTHING_LEFT", {}, {}, {}});
  }
  return Derived{*std::move(checked), *std::move(checkpoint), goes_on};
}

absl::StatusOr<JobStore::Inserted> Jobs::derive(const Caller& caller, const std::string& source,
                                                const CheckpointChoice& choice, Submission submission,
                                                const RequestKey& key) {
  auto derived = check_derived(caller, source, choice, std::move(submission));
  if (!derived.ok()) return derived.status();
  Job& job = derived->checked.job;
  if (auto status = check_room(job.memory_estimate); !status.ok()) return status;
  job.id = new_id();
  job.parent = source;
  job.parent_generation = derived->checkpoint.choice.generation;
  const std::filesystem::path made = folder(job.id);
  if (auto status = make_job_folder(made, job.spec); !status.ok()) return status;
  // What is taken over exists nowhere else: durable before the row.
  absl::Status taken = secure_job_folder(made, job.spec);
  if (taken.ok()) {
    taken = derived->goes_on ? continue_from(folder(source), derived->checkpoint, made)
                             : start_from(derived->checkpoint, made);
  }
  if (!taken.ok()) {
    std::error_code ignored;
    std::filesystem::remove_all(made, ignored);
    return taken;
  }
  return insert(std::move(job), key, made);
}

absl::StatusOr<Job> Jobs::get(const Caller& caller, const std::string& id) const {
  auto job = store_.get(id);
  if (job.ok() && !caller.sees().empty() && job->owner != caller.sees()) return job_not_found(id);
  return job;
}

absl::StatusOr<std::vector<Job>> Jobs::list(const Caller& caller, ListQuery query) {
  query.owner = caller.sees();
  std::sort(query.states.begin(), query.states.end());
  query.states.erase(std::unique(query.states.begin(), query.states.end()), query.states.end());
  return store_.list(query);
}

absl::StatusOr<std::vector<Attempt>> Jobs::attempts(const Caller& caller, const std::string& id,
                                                    std::int64_t first, int limit) {
  if (auto job = get(caller, id); !job.ok()) return job.status();
  return store_.attempts(id, first, limit);
}

absl::StatusOr<Job> Jobs::change(const Caller& caller, const std::string& id,
                                 const std::function<absl::Status(Job&)>& change) {
  if (auto job = get(caller, id); !job.ok()) return job.status();
  auto changed = store_.change(id, change);
  if (changed.ok()) wake_();
  return changed;
}

absl::StatusOr<Job> Jobs::pause(const Caller& caller, const std::string& id) {
  return change(caller, id, [](Job& job) -> absl::Status {
    if (is_final(job.state) || job.reason == StateReason::kCancelRequested) return wrong_state(job, "paused");
    if (job.state == JobState::kRunning) {
      job.reason = StateReason::kPauseRequested;
      return absl::OkStatus();
    }
    job.state = JobState::kPaused;
    job.reason = StateReason::kPausedByUser;
    job.message = "paused; resume it to go on";
    return absl::OkStatus();
  });
}

absl::StatusOr<Job> Jobs::resume(const Caller& caller, const std::string& id) {
  return change(caller, id, [](Job& job) -> absl::Status {
    if (is_final(job.state) || job.reason == StateReason::kCancelRequested)
      return wrong_state(job, "resumed");
    if (job.state == JobState::kPaused)
      job.state = JobState::kQueued;
    else if (job.reason != StateReason::kPauseRequested)
      return absl::OkStatus();
    job.reason = StateReason::kResumed;
    job.message.clear();
    job.not_before = 0;
    return absl::OkStatus();
  });
}

absl::StatusOr<Job> Jobs::cancel(const Caller& caller, const std::string& id, bool at_once) {
  return change(caller, id, [at_once](Job& job) -> absl::Status {
    if (job.state == JobState::kCancelled) return absl::OkStatus();
    if (is_final(job.state)) return wrong_state(job, "cancelled");
    if (job.state == JobState::kRunning) {
      job.reason = StateReason::kCancelRequested;
      job.stop_now = job.stop_now || at_once;
      return absl::OkStatus();
    }
    job.state = JobState::kCancelled;
    job.reason = StateReason::kCancelledByUser;
    job.message = "cancelled";
    job.ended = wall_clock();
    return absl::OkStatus();
  });
}

std::vector<absl::Status> Jobs::remove_all(const Caller& caller, const std::vector<std::string>& ids) {
  std::vector<absl::Status> results;
  std::vector<std::string> allowed;
  for (const std::string& id : ids) {
    results.push_back(get(caller, id).status());
    if (results.back().ok()) allowed.push_back(id);
  }
  const std::vector<absl::Status> marked = store_.mark_deleted(allowed);
  std::vector<std::string> gone;
  for (std::size_t i = 0, next = 0; i < ids.size(); ++i) {
    if (!results[i].ok()) continue;
    results[i] = marked[next++];
    if (!results[i].ok()) continue;
    samples_.forget(ids[i]);
    std::error_code error;
    std::filesystem::remove_all(folder(ids[i]), error);
    if (!error) gone.push_back(ids[i]);
  }
  // What could not be removed for good the supervisor tries again.
  if (!gone.empty() && creep::sync_directory(jobs_).ok()) store_.forget(gone).IgnoreError();
  return results;
}

}  // namespace creepd
