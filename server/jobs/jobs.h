// What callers may do with jobs: every change of the API, without gRPC. Answers are durable before they are
// given.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/folders/job_files.h"
#include "server/folders/sample_index.h"
#include "server/rules/job.h"
#include "server/store/job_store.h"

namespace creepd {

/// Who calls: verified by the kernel or by a certificate, never told by the caller.
struct Caller {
  std::string owner;   ///< "uid:1000"
  bool admin = false;  ///< sees and changes everybody's jobs

  /// Whose jobs it may see and change; "" = everybody's.
  std::string sees() const { return admin ? "" : owner; }
};

struct Submission {
  std::string spec;
  std::string request_id;
  std::map<std::string, std::string> labels;
  std::int32_t priority = 0;
  std::map<std::string, std::string> overrides = {};  ///< keys of the job file, in order of the key
};

struct JobLimits {
  std::int64_t most_unfinished = 20'000;
  std::uint64_t memory = 0;             ///< of one job [bytes]
  int threads = 1;                      ///< of one job
  std::uint64_t least_free = 64 << 20;  ///< of the state directory, else no job is taken [bytes]
};

class Jobs {
 public:
  /// `wake` is called after each change that concerns workers.
  Jobs(std::filesystem::path jobs, JobLimits limits, JobStore& store, SampleLibrary& samples,
       std::function<void()> wake);

  /// The job file of a submission with its overrides, which it then has no more. Errors: InvalidArgument
  /// BAD_REQUEST.
  static absl::StatusOr<Submission> completed(Submission submission);

  /// Errors of all: creep.proto. NotFound for the jobs of others.
  absl::StatusOr<Job> check(const Caller& caller, const Submission& submission) const;
  absl::StatusOr<JobStore::Inserted> submit(const Caller& caller, const Submission& submission);
  absl::StatusOr<JobStore::Inserted> fork(const Caller& caller, const std::string& source,
                                          const CheckpointChoice& choice, Submission submission);
  absl::StatusOr<Job> get(const Caller& caller, const std::string& id) const;
  absl::StatusOr<Job> pause(const Caller& caller, const std::string& id);
  absl::StatusOr<Job> resume(const Caller& caller, const std::string& id);
  absl::StatusOr<Job> cancel(const Caller& caller, const std::string& id, bool now);
  /// Each or not: what became of it, in the order of the ids.
  std::vector<absl::Status> remove_all(const Caller& caller, const std::vector<std::string>& ids);
  absl::Status remove(const Caller& caller, const std::string& id) {
    return remove_all(caller, {id}).front();
  }
  /// Newest first, without specs; `query.owner` is set here.
  absl::StatusOr<std::vector<Job>> list(const Caller& caller, ListQuery query);
  absl::StatusOr<std::vector<Attempt>> attempts(const Caller& caller, const std::string& id,
                                                std::int64_t first, int limit);

  std::filesystem::path folder(const std::string& id) const { return jobs_ / id; }
  const JobLimits& limits() const { return limits_; }

 private:
  struct Checked {
    Job job;
    std::string specimen_hash;
    std::optional<creep::Start> start;
  };
  absl::StatusOr<Checked> check_all(const Caller& caller, const Submission& submission) const;
  struct Derived {
    Checked checked;
    ChosenCheckpoint checkpoint;
    bool goes_on = false;  ///< the experiment of the checkpoint, not another
  };
  absl::StatusOr<Derived> check_derived(const Caller& caller, const std::string& source,
                                        const CheckpointChoice& choice, Submission submission) const;
  /// A new job from a checkpoint of `source`: its own experiment goes on, or another starts.
  absl::StatusOr<JobStore::Inserted> derive(const Caller& caller, const std::string& source,
                                            const CheckpointChoice& choice, Submission submission,
                                            const RequestKey& key);
  /// What to say where the checkpoint is missing: that, and what is wrong with the job file besides.
  absl::Status without_checkpoint(const Caller& caller, const std::string& source,
                                  const CheckpointChoice& choice, Submission submission,
                                  const std::string& parent_spec, const absl::Status& missing) const;
  absl::Status check_room(std::uint64_t memory) const;
  absl::StatusOr<JobStore::Inserted> insert(Job job, const RequestKey& key,
                                            const std::filesystem::path& folder);
  absl::StatusOr<Job> change(const Caller& caller, const std::string& id,
                             const std::function<absl::Status(Job&)>& change);

  std::filesystem::path jobs_;
  JobLimits limits_;
  JobStore& store_;
  SampleLibrary& samples_;
  std::function<void()> wake_;
};

}  // namespace creepd
