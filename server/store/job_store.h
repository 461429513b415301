// The daemon's memory: jobs, their changes of state and the submissions answered, in one SQLite database.
//
// Every call is one transaction, durable when it returns (WAL, synchronous=FULL). Safe from several threads:
// one connection behind one mutex. Nothing else opens the file. Errors of the storage are Unavailable with
// the reason STORAGE_FAILED (refusal.h), and then nothing was changed. Changes and deletions of jobs have a
// reserve of room for when the disk is full; new jobs and news of running ones do not.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/rules/attempt.h"
#include "server/rules/job.h"

namespace creepd {

/// What makes a submission the same one when it is repeated.
struct RequestKey {
  std::string id;       ///< "" = none: never the same
  std::string content;  ///< SHA-256 of all that was asked
};

struct ListQuery {
  std::string owner;  ///< "" = everybody's
  std::vector<JobState> states;
  std::map<std::string, std::string> labels;
  std::int64_t before_number = 0;  ///< only jobs submitted earlier than this one; 0 = all
  int limit = 50;
};

struct Counts {
  std::int64_t queued = 0;
  std::int64_t running = 0;
  std::int64_t unfinished = 0;
};

class JobStore {
 public:
  /// Opens or makes the database, checks it and brings its schema up to date. Errors: Unavailable (storage),
  /// DataLoss (damaged), FailedPrecondition (made by a newer version). `changed` is called with the id of the
  /// job after each change that watchers may want to know, from any thread and outside all locks.
  static absl::StatusOr<std::unique_ptr<JobStore>> open(
      const std::filesystem::path& path, std::function<void(const std::string&)> changed = nullptr);
  ~JobStore();

  /// The job of an earlier submission with this key. Errors: InvalidArgument REQUEST_ID_REUSED.
  absl::StatusOr<std::optional<Job>> find_request(const std::string& owner, const RequestKey& key);

  struct Inserted {
    Job job;
    bool already_existed = false;
  };
  /// Puts a new QUEUED job in, its first event with it; or finds that the request was answered before. Errors
  /// also: ResourceExhausted QUEUE_FULL.
  absl::StatusOr<Inserted> insert(Job job, const RequestKey& key, std::int64_t most_unfinished);

  /// Errors: NotFound JOB_NOT_FOUND.
  absl::StatusOr<Job> get(const std::string& id);

  /// Newest first; without specs.
  absl::StatusOr<std::vector<Job>> list(ListQuery query);

  /// Reads the job, has `change` alter it, and stores it; a change of state or reason becomes an event. The
  /// error of `change` is returned and nothing is stored. An attempt, which `change` may fill in, is stored
  /// with it.
  absl::StatusOr<Job> change(const std::string& id, const std::function<absl::Status(Job&)>& change,
                             const Attempt* attempt = nullptr);

  /// News of an attempt. Errors: NotFound JOB_NOT_FOUND.
  absl::Status note(const std::string& id, const Attempt& attempt);
  /// Those of a job from number `first` on, at most `limit`. Errors: NotFound JOB_NOT_FOUND.
  absl::StatusOr<std::vector<Attempt>> attempts(const std::string& id, std::int64_t first, int limit);

  struct Telling {
    std::string id;
    std::uint64_t samples = 0;
    std::string latest_sample;
    std::string progress;
  };
  /// What running jobs brought forth, in one transaction. Samples never become fewer.
  absl::Status tell(const std::vector<Telling>& news);

  /// Changes of state from `from_place` on, and the job as it is at the same moment.
  struct Events {
    Job job;
    std::vector<StateEvent> changes;
  };
  absl::StatusOr<Events> events(const std::string& id, std::uint64_t from_place);

  /// The next queued job to start, if any: by priority, then by age.
  absl::StatusOr<std::optional<Job>> next_queued(Moment now);
  absl::StatusOr<std::vector<Job>> running();
  /// Paused for this reason.
  absl::StatusOr<std::vector<Job>> paused(StateReason reason);
  absl::StatusOr<Counts> counts();
  /// Place in the queue of a queued job, from 1.
  absl::StatusOr<std::int64_t> queue_position(const Job& job);
  /// That of each, by Job::number.
  absl::StatusOr<std::unordered_map<std::int64_t, std::int64_t>> queue_positions();

  /// Two steps, so that a power cut between them leaves no orphan: hidden from now on, each or not (errors of
  /// each: NotFound, FailedPrecondition WRONG_STATE while it is queued or running) ...
  std::vector<absl::Status> mark_deleted(const std::vector<std::string>& ids);
  /// ... and, their files being gone, forgotten.
  absl::Status forget(const std::vector<std::string>& ids);
  absl::StatusOr<std::vector<std::string>> marked_deleted();

  /// Forgets answered submissions older than this.
  absl::Status forget_requests_before(Moment moment);

  /// Makes the file shorter by some of the room that was deleted, soon enough for nobody to wait long.
  absl::Status shrink();

  /// Gives up the reserve if the disk is full. False if that is of no use.
  bool use_reserve();
  /// Takes the reserve again where there is room. False while it is in use: then nothing else should grow.
  bool restore_reserve();

 private:
  struct Impl;
  explicit JobStore(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace creepd
