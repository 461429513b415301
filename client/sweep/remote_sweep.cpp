#include "client/sweep/remote_sweep.h"

#include <algorithm>
#include <map>
#include <thread>

#include "absl/strings/str_cat.h"
#include "client/remote/remote_job.h"

namespace creepctl {
namespace {

/// Full queue or disk: later it may be taken.
bool can_pass(const CallResult& result) {
  return result.lost() || result.reason == "QUEUE_FULL" || result.reason == "DISK_FULL";
}

std::string words_of(const CallResult& result) {
  std::string words(result.status.message());
  for (const Violation& violation : result.violations) absl::StrAppend(&words, "; ", violation.description);
  return words;
}

class RemoteSweep {
 public:
  RemoteSweep(Connection& connection, const std::vector<SweepJob>& jobs, const RemoteSweepOptions& options,
              const std::function<void(const std::string&)>& say, std::vector<SweepEnd>& ends)
      : connection_(connection), jobs_(jobs), options_(options), say_(say), ends_(ends) {
    ends_.assign(jobs.size(), {});
    for (std::size_t i = 0; i < jobs.size(); ++i) {
      ends_[i].name = jobs[i].name;
      ends_[i].exit_code = kRunAgain;
      ends_[i].message =
          jobs[i].trunk ? absl::StrCat("waits for ", jobs[*jobs[i].trunk].name) : "not submitted";
    }
  }

  /// Submits what can be and looks at all. Error: the daemon is gone, or full.
  CallResult step() {
    CallResult last;
    for (std::size_t i = 0; i < jobs_.size(); ++i) {
      if (ends_[i].ended || !ends_[i].place.empty()) continue;
      CallResult result = jobs_[i].trunk ? fork(i) : submit(i);
      if (!result.ok()) last = std::move(result);
      if (last.lost()) return last;
    }
    if (CallResult looked = look(); !looked.ok()) return looked;
    return last;
  }

  bool all_ended() const {
    return std::all_of(ends_.begin(), ends_.end(), [](const SweepEnd& end) { return end.ended; });
  }

 private:
  template <typename Request>
  void fill(std::size_t index, Request& request) const {
    set_labels(options_.labels, *request.mutable_labels());
    (*request.mutable_labels())["sweep"] = options_.name;
    (*request.mutable_labels())["member"] = jobs_[index].name;
    request.set_request_id(absl::StrCat("sweep/", options_.name, "/", jobs_[index].name));
    request.set_priority(options_.priority);
    request.set_spec(jobs_[index].text);
  }

  CallResult submit(std::size_t index) {
    api::SubmitJobRequest request;
    fill(index, request);
    api::SubmitJobResponse response;
    return taken(index, connection_.call(request, response), response);
  }

  CallResult fork(std::size_t index) {
    const SweepEnd& trunk = ends_[*jobs_[index].trunk];
    if (trunk.place.empty() && trunk.ended) {
      finish(index, trunk.exit_code, absl::StrCat(trunk.name, " was refused"));
      return {};
    }
    if (trunk.place.empty()) return {};
    api::ForkJobRequest request;
    fill(index, request);
    request.set_job(trunk.place);
    request.set_checkpoint(jobs_[index].checkpoint);
    api::SubmitJobResponse response;
    CallResult result = connection_.call(request, response);
    if (result.reason != "CHECKPOINT_NOT_FOUND") return taken(index, std::move(result), response);
    // What ended before this call was made has kept all that it will keep.
    if (trunk.ended)
      finish(index, kFailed,
             absl::StrCat(trunk.name, " ended without the checkpoint ", jobs_[index].checkpoint, " (",
                          trunk.message, ")"));
    return {};
  }

  CallResult taken(std::size_t index, CallResult result, const api::SubmitJobResponse& response) {
    if (result.ok()) {
      ends_[index].place = response.job().id();
      ends_[index].message = "submitted";
      say_(absl::StrCat(jobs_[index].name, ": ", response.job().id(),
                        response.already_existed() ? " (submitted before)" : " submitted"));
      return {};
    }
    if (can_pass(result)) {
      ends_[index].message = words_of(result);
      return result;
    }
    const bool reused = result.reason == "REQUEST_ID_REUSED";
    finish(index, exit_code_of(result),
           reused ? absl::StrCat(
                        "the sweep ", options_.name,
                        " was submitted before with another job file, priority or labels: give --name, or "
                        "delete its jobs")
                  : words_of(result));
    if (exit_code_of(result) == kUnreachable) return result;
    return {};
  }

  CallResult look() {
    std::vector<api::Job> jobs;
    api::ListJobsRequest request;
    (*request.mutable_labels())["sweep"] = options_.name;
    if (CallResult result = list_jobs(connection_, request, 0, jobs); !result.ok()) return result;
    std::map<std::string, const api::Job*> by_id;
    for (const api::Job& job : jobs) by_id[job.id()] = &job;
    for (std::size_t i = 0; i < jobs_.size(); ++i) {
      if (ends_[i].ended || ends_[i].place.empty()) continue;
      const auto found = by_id.find(ends_[i].place);
      if (found == by_id.end()) {
        finish(i, kFailed, "the job was deleted");
        continue;
      }
      const api::Job& job = *found->second;
      std::string words = state_text(job.state(), job.state_reason());
      if (const std::string news = news_in(job.state_message(), job.state_reason()); !news.empty())
        absl::StrAppend(&words, ": ", news);
      if (is_final(job.state())) {
        finish(i, exit_code_of(job.state()), words);
      } else {
        ends_[i].message = words;
      }
    }
    return {};
  }

  void finish(std::size_t index, int exit_code, const std::string& message) {
    ends_[index].ended = true;
    ends_[index].exit_code = exit_code;
    ends_[index].message = message;
    say_(absl::StrCat(jobs_[index].name, ": ", message));
  }

  Connection& connection_;
  const std::vector<SweepJob>& jobs_;
  const RemoteSweepOptions& options_;
  const std::function<void(const std::string&)>& say_;
  std::vector<SweepEnd>& ends_;
};

}  // namespace

CallResult sweep_remotely(Connection& connection, const std::vector<SweepJob>& jobs,
                          const RemoteSweepOptions& options,
                          const std::function<void(const std::string&)>& say, std::vector<SweepEnd>& ends) {
  RemoteSweep sweep(connection, jobs, options, say, ends);
  CallResult result = sweep.step();
  if (result.lost() || exit_code_of(result) == kUnreachable) return result;
  std::string said;
  while (options.wait && !sweep.all_ended()) {
    // Why nothing moves is said once, not every time.
    const std::string trouble = result.ok() ? "" : words_of(result);
    if (!trouble.empty() && trouble != said) say(absl::StrCat("waiting: ", trouble));
    said = trouble;
    std::this_thread::sleep_for(std::chrono::seconds(options.poll_seconds));
    result = sweep.step();
    if (!result.ok() && !can_pass(result)) return result;
  }
  return {};
}

}  // namespace creepctl
