#include "server/worker/worker.h"

#include <chrono>
#include <cstdio>
#include <memory>
#include <new>
#include <span>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "core/experiment/experiment_toml.h"
#include "core/folder/checkpoint_store.h"
#include "core/folder/durable_file.h"
#include "core/folder/ending.h"
#include "core/folder/job_directory.h"
#include "core/folder/lease.h"
#include "core/folder/sample_log.h"
#include "core/run/run.h"
#include "core/run/self_test.h"
#include "core/state/program_version.h"
#include "server/worker/pace.h"
#include "server/worker/profile.h"
#include "server/worker/progress_file.h"
#include "server/worker/snapshot_folder.h"
#include "server/worker/stage_timings.h"
#include "server/worker/summary_file.h"
#include "server/worker/tables.h"
#include "server/worker/worker_log.h"

namespace creepd {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Everything an attempt writes to.
struct Output {
  creep::JobDirectory files;
  std::int64_t attempt;
  WorkerLog& log;
  creep::SampleLog samples;
  creep::CheckpointStore checkpoints;
  SnapshotFolder snapshots;
  StageTimings timings;
  Tables tables;
  ProgressFile progress;
};

absl::StatusOr<Output> open_output(const creep::JobDirectory& files, std::int64_t attempt, WorkerLog& log) {
  // First, since it refuses what a newer program has made: then nothing else is touched.
  auto checkpoints = creep::CheckpointStore::open(files.checkpoints(), &creep::read_checkpoint_info);
  if (!checkpoints.ok()) return checkpoints.status();
  auto samples = creep::SampleLog::open(files.sample_log());
  if (!samples.ok()) return samples.status();
  if (!samples->repair().empty()) log.line(samples->repair());
  auto snapshots = SnapshotFolder::open(files.snapshots());
  if (!snapshots.ok()) return snapshots.status();
  auto timings = StageTimings::open(files.stage_timings());
  if (!timings.ok()) return timings.status();
  auto tables = Tables::render(files.root(), *samples, *timings);
  if (!tables.ok()) return tables.status();
  return Output{files,
                attempt,
                log,
                *std::move(samples),
                *std::move(checkpoints),
                *std::move(snapshots),
                *std::move(timings),
                *std::move(tables),
                ProgressFile(files.progress(), attempt)};
}

absl::StatusOr<creep::Experiment> read_experiment(const creep::JobDirectory& files) {
  const auto text = creep::read_file(files.job_file(), 1 << 20);
  if (absl::IsNotFound(text.status())) return absl::InvalidArgumentError(text.status().message());
  if (!text.ok()) return text.status();
  creep::ParseResult parsed = creep::parse_experiment(*text);
  if (parsed.experiment) return *std::move(parsed.experiment);
  std::vector<std::string> lines;
  for (const creep::Diagnostic& error : parsed.errors) {
    lines.push_back(absl::StrCat("job.toml:", error.line, ":", error.column, ": error: ", error.message));
  }
  return absl::InvalidArgumentError(absl::StrJoin(lines, "\n"));
}

absl::StatusOr<std::unique_ptr<creep::Run>> start_run(const creep::Experiment& experiment,
                                                      const creep::RunOptions& options,
                                                      const creep::JobDirectory& files) {
  if (!experiment.start) return creep::Run::start(experiment, options);
  const auto bytes = creep::read_file(files.start_checkpoint());
  if (absl::IsNotFound(bytes.status())) {
    return absl::InvalidArgumentError(
        "job.toml has [start], but checkpoints/start, the checkpoint to start from, is not there");
  }
  if (!bytes.ok()) return bytes.status();
  return creep::Run::start_from(experiment, options, *bytes);
}

/// A run at its start or at the newest checkpoint that is good and not ahead of the log.
absl::StatusOr<std::unique_ptr<creep::Run>> begin_run(const creep::Experiment& experiment,
                                                      const creep::RunOptions& options, Output& output) {
  const std::uint64_t log_size = output.samples.size();
  const auto newest = output.checkpoints.load_newest([log_size](const creep::CheckpointInfo& info) {
    if (info.next_sequence <= log_size) return absl::OkStatus();
    return absl::DataLossError(
        absl::StrCat("it follows record ", info.next_sequence, ", samples.log has only ", log_size));
  });
  if (!newest.ok()) return newest.status();
  for (const auto& rejected : newest->rejected) {
    output.log.trouble(absl::StrCat("checkpoint ", rejected.generation, " is set aside as bad.",
                                    rejected.generation, ": ", rejected.reason));
  }
  if (!newest->loaded && !newest->rejected.empty()) {
    return absl::DataLossError("no checkpoint is good: remove the checkpoints folder to begin from zero");
  }
  if (!newest->loaded) {
    output.log.line(absl::StrCat("begins from zero, ", log_size, " records in the log"));
    output.samples.rewind(0);
    return start_run(experiment, options, output.files);
  }
  const creep::CheckpointInfo& info = newest->loaded->info;
  auto run = creep::Run::resume(experiment, options, newest->loaded->bytes);
  if (absl::IsInvalidArgument(run.status())) return absl::FailedPreconditionError(run.status().message());
  if (!run.ok()) return run.status();
  output.log.line(absl::StrCat("continues from checkpoint ", newest->loaded->generation, ": ", info.stage,
                               ", cycle ", info.cycle, ", creep time ", info.creep_time, " s, record ",
                               info.next_sequence, " of ", log_size, " in the log"));
  if ((*run)->inexact()) output.log.trouble("inexact: resumed with other arithmetic than it began with");
  output.samples.rewind(info.next_sequence);
  return run;
}

/// The loop of an attempt: computes, keeps what came out, and knows when to end.
class Attempt {
 public:
  Attempt(const WorkerOptions& options, StopRequest& stop, Output& output, creep::Run& run,
          SummaryFacts facts, Profile* profile)
      : options_(options),
        stop_(stop),
        output_(output),
        run_(run),
        facts_(std::move(facts)),
        mark_(profile != nullptr ? profile->mark() : nullptr) {}

  absl::StatusOr<creep::Ending> carry_out() {
    if (auto counted = count_stage_rows(); !counted.ok()) return counted;
    for (;;) {
      auto batch = advance();
      if (!batch.ok()) return batch.status();
      if (batch->outcome) return finish(*batch->outcome);
      const auto request = stop_.poll();
      if (request || batch->stage_ended || seconds_since(last_checkpoint_) > options_.checkpoint_interval) {
        if (auto saved = checkpoint(); !saved.ok()) return saved;
      }
      if (request) {
        if (auto told = output_.progress.write(state("checkpointed")); !told.ok()) return told;
        return creep::Ending{creep::kCheckpointed, "checkpointed", absl::StrCat("stopped by ", *request), ""};
      }
      if (!output_.progress.due()) continue;
      if (auto told = output_.progress.offer(state("running")); !told.ok()) return told;
    }
  }

 private:
  absl::Status count_stage_rows() {
    for (std::uint64_t sequence = 0; sequence < run_.next_sequence(); ++sequence) {
      const auto record = output_.samples.read(sequence);
      if (!record.ok()) return record.status();
      if (record->kind == creep::RecordKind::kStage) ++stage_row_;
      output_.progress.saw(*record);
    }
    return absl::OkStatus();
  }

  absl::StatusOr<creep::Batch> advance() {
    const bool packing = run_.progress().phase == creep::Phase::kPacking;
    const auto start = Clock::now();
    creep::Batch batch = run_.advance(pace_.cycle_budget());
    const double seconds = seconds_since(start);
    pace_.took(batch.cycles, seconds);
    output_.timings.add(packing ? StageTimings::kPacking : stage_row_,
                        {batch.rebuilds, seconds, batch.particle_steps});
    output_.progress.worked(batch.particle_steps, seconds);
    log_new_warnings();
    if (auto kept = keep(batch); !kept.ok()) return kept;
    return batch;
  }

  absl::Status keep(const creep::Batch& batch) {
    const creep::Doing writing(mark_, creep::Activity::kOutput);
    for (const creep::KeptCheckpoint& one : batch.kept) {
      if (auto kept = output_.checkpoints.keep(one.name, one.bytes); !kept.ok()) return kept;
      output_.log.line(absl::StrCat("keeps checkpoint ", one.name));
    }
    // Pictures first: a checkpoint that follows the records implies them.
    if (auto written = output_.snapshots.write(batch.snapshots); !written.ok()) return written;
    const std::vector<creep::Record>& records = batch.records;
    if (records.empty()) return absl::OkStatus();
    std::optional<std::string> note;
    if (options_.allow_inexact)
      note = absl::StrCat("attempt ", output_.attempt, " was allowed to be inexact");
    const auto appended = output_.samples.append(records, note);
    if (!appended.ok()) return appended.status();
    if (appended->superseded) {
      output_.log.trouble(absl::StrCat("records from ", records[appended->repeated].sequence,
                                       " on differ from those in samples.log and supersede them"));
      auto tables = Tables::render(output_.files.root(), output_.samples, output_.timings);
      if (!tables.ok()) return tables.status();
      output_.tables = *std::move(tables);
      const std::uint64_t first_other = records[appended->repeated].sequence;
      if (auto dropped = output_.snapshots.drop_after(first_other); !dropped.ok()) return dropped;
      if (auto written = output_.snapshots.write(batch.snapshots); !written.ok()) return written;
    } else {
      const std::span<const creep::Record> fresh = std::span(records).subspan(appended->repeated);
      if (auto shown = output_.tables.append(fresh, output_.timings); !shown.ok()) return shown;
    }
    for (const creep::Record& record : records) {
      output_.progress.saw(record);
      if (record.kind == creep::RecordKind::kStage) ++stage_row_;
    }
    return absl::OkStatus();
  }

  absl::Status checkpoint() {
    const creep::Doing writing(mark_, creep::Activity::kOutput);
    if (auto synced = output_.samples.sync(); !synced.ok()) return synced;
    const auto generation = output_.checkpoints.add(run_.checkpoint());
    if (!generation.ok()) return generation.status();
    last_checkpoint_ = Clock::now();
    const creep::Progress progress = run_.progress();
    output_.log.line(absl::StrCat("checkpoint ", *generation, ": ", progress.stage, ", dynamic stage ",
                                  progress.dynamic_stage, ", record ", run_.next_sequence()));
    return output_.timings.write();
  }

  /// No checkpoint of the very end: the run cannot be advanced from there. The one before stays for a look or
  /// a fork.
  absl::StatusOr<creep::Ending> finish(const creep::Outcome& outcome) {
    const creep::Ending ending = creep::ending_of(outcome);
    if (auto synced = output_.samples.sync(); !synced.ok()) return synced;
    // Nobody renders the tables again once the job is done.
    if (auto synced = output_.tables.sync(); !synced.ok()) return synced;
    if (auto written = output_.timings.write(); !written.ok()) return written;
    facts_.total = output_.timings.total();
    if (auto written = write_summary(output_.files.summary(), run_, ending, facts_); !written.ok())
      return written;
    if (auto told = output_.progress.write(state(ending.outcome)); !told.ok()) return told;
    return ending;
  }

  void log_new_warnings() {
    const auto warnings = run_.warnings();
    for (; warnings_logged_ < warnings.size(); ++warnings_logged_) {
      output_.log.line(absl::StrCat("warning: ", warnings[warnings_logged_]));
    }
  }

  ProgressFile::State state(std::string word) const {
    return {run_.progress(), output_.timings.total(), run_.warnings(), std::move(word)};
  }

  const WorkerOptions& options_;
  StopRequest& stop_;
  Output& output_;
  creep::Run& run_;
  SummaryFacts facts_;
  creep::ActivityMark* mark_;  // nullptr: nobody looks
  Pace pace_;
  std::int64_t stage_row_ = 0;  ///< of stages.csv, of the stage being computed
  std::size_t warnings_logged_ = 0;
  Clock::time_point last_checkpoint_ = Clock::now();
};

absl::StatusOr<creep::Ending> carry_out(const WorkerOptions& options, StopRequest& stop,
                                        const creep::JobDirectory& files, std::int64_t attempt,
                                        WorkerLog& log) {
  const auto experiment = read_experiment(files);
  if (!experiment.ok()) return experiment.status();
  const auto instruction_set = creep::choose_instruction_set(options.instruction_set);
  if (!instruction_set.ok()) return absl::InvalidArgumentError(instruction_set.status().message());
  auto output = open_output(files, attempt, log);
  if (!output.ok()) return output.status();
  log.line(absl::StrCat("started: ", options.threads, " threads, ", *instruction_set, ", version ",
                        std::string(creep::program_version())));
  std::optional<Profile> profile;
  if (options.profile) profile.emplace();
  const creep::RunOptions run_options{.threads = options.threads,
                                      .instruction_set = *instruction_set,
                                      .allow_inexact = options.allow_inexact,
                                      .rebuild_every = options.rebuild_every,
                                      .activity = profile ? profile->mark() : nullptr};
  auto run = begin_run(*experiment, run_options, *output);
  if (!run.ok()) return run.status();
  SummaryFacts facts{.experiment_hash = creep::experiment_hash(*experiment),
                     .numerics = experiment->numerics,
                     .instruction_set = *instruction_set,
                     .threads = options.threads,
                     .attempts = attempt,
                     .total = {}};
  auto ending =
      Attempt(options, stop, *output, **run, std::move(facts), profile ? &*profile : nullptr).carry_out();
  if (!profile) return ending;
  const auto written = profile->write(files.profile());
  return ending.ok() && !written.ok() ? written : ending;
}

creep::Ending see_through(const WorkerOptions& options, StopRequest& stop, const creep::JobDirectory& files,
                          std::int64_t attempt, WorkerLog& log) {
  try {
    const auto carried_out = carry_out(options, stop, files, attempt, log);
    return carried_out.ok() ? *carried_out : creep::ending_of(carried_out.status());
  } catch (const std::bad_alloc&) {
    return {creep::kOutOfMemory, "crash", "out of memory",
            "Give the job more memory: it continues from its last checkpoint."};
  }
}

}  // namespace

int work(const WorkerOptions& options, StopRequest& stop) {
  const creep::JobDirectory files(options.directory);
  const auto lease = creep::Lease::take(files.lease(), options.attempt);
  if (!lease.ok()) {
    std::fprintf(stderr, "creep-worker: %s\n", std::string(lease.status().message()).c_str());
    if (absl::IsUnavailable(lease.status())) return creep::kLeaseHeld;
    return creep::ending_of(lease.status()).exit_code;
  }
  auto log = WorkerLog::open(files.worker_log(), lease->attempt());
  if (!log.ok()) {
    std::fprintf(stderr, "creep-worker: %s\n", std::string(log.status().message()).c_str());
    return creep::kIoError;
  }
  const auto before = creep::read_verdict(files.verdict());
  if (before && before->exit_code == creep::kDone) {
    log->line("nothing to do: the job is done");
    // Of this attempt now: whoever started it has not heard of the one that did the job.
    const auto told = creep::write_verdict(files.verdict(), *before, lease->attempt());
    return told.ok() ? creep::kDone : creep::kIoError;
  }
  std::error_code ignored;  // a verdict that cannot be removed is overwritten at the end
  std::filesystem::remove(files.verdict(), ignored);

  creep::Ending ending = see_through(options, stop, files, lease->attempt(), *log);
  const auto told = creep::write_verdict(files.verdict(), ending, lease->attempt());
  if (!told.ok() && ending.exit_code == creep::kDone) ending = creep::ending_of(told);
  const std::string line =
      absl::StrCat("ended ", ending.exit_code, " (", ending.outcome, "): ", ending.reason,
                   ending.advice.empty() ? "" : ". ", ending.advice);
  ending.exit_code == creep::kDone || ending.exit_code == creep::kCheckpointed ? log->line(line)
                                                                               : log->trouble(line);
  return ending.exit_code;
}

}  // namespace creepd
