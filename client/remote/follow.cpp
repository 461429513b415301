#include "client/remote/follow.h"

#include <algorithm>
#include <random>
#include <thread>

#include "client/remote/remote_job.h"

namespace creepctl {
namespace {

using Clock = std::chrono::system_clock;

class Follower {
 public:
  Follower(Connection& connection, const std::string& id, std::uint64_t after_seq,
           Connection::Deadline deadline, const FollowListener& listener)
      : connection_(connection), deadline_(deadline), listener_(listener) {
    request_.set_job(id);
    request_.set_after_seq(after_seq);
    request_.set_every_sample(listener.every_sample);
  }

  FollowEnd run() {
    for (;;) {
      CallResult end = read_one_stream();
      if (end.ok() && !is_final(state_)) end = look_at_the_end();
      if (is_final(state_)) return {FollowEnd::kFinal, state_, {}};
      // gRPC's timer can be a little ahead of our clock.
      const bool timed_out =
          deadline_ && (absl::IsDeadlineExceeded(end.status) || Clock::now() >= *deadline_);
      if (timed_out) return {FollowEnd::kTimedOut, state_, {}};
      // A daemon that restarts can find all its watchers back before it knows which have gone.
      const bool crowded = end.reason == "TOO_MANY_WATCHERS" && answered_once_;
      if (!end.lost() && !crowded) return {FollowEnd::kRefused, state_, end};
      if (!wait_before_the_next(end)) return {FollowEnd::kTimedOut, state_, {}};
    }
  }

 private:
  CallResult read_one_stream() {
    const auto stream = connection_.watch(request_, deadline_);
    api::Event event;
    while (stream->read(event)) {
      answered();
      if (event.has_heartbeat()) {
        if (listener_.heartbeat) listener_.heartbeat(event);
        continue;
      }
      if (event.seq() <= request_.after_seq()) continue;  // seen already
      request_.set_after_seq(event.seq());
      if (listener_.event) listener_.event(event);
      if (event.has_state_change()) state_ = event.state_change().state();
    }
    return stream->finish();
  }

  /// The stream of a job that was final already ends at once, without an event.
  CallResult look_at_the_end() {
    api::GetJobRequest request;
    request.set_job(request_.job());
    api::Job job;
    CallResult result = connection_.call(request, job);
    if (!result.ok()) return result;
    state_ = job.state();
    if (!is_final(state_)) {
      result.status = absl::UnavailableError("the daemon ended the stream of a job that goes on");
    }
    return result;
  }

  void answered() {
    if (lost_since_ && listener_.again) {
      listener_.again(std::chrono::duration<double>(Clock::now() - *lost_since_).count());
    }
    lost_since_.reset();
    answered_once_ = true;
    attempt_ = 0;
  }

  /// False if the deadline comes first.
  bool wait_before_the_next(const CallResult& end) {
    if (!lost_since_) {
      lost_since_ = Clock::now();
      if (listener_.lost) listener_.lost(std::string(end.status.message()));
    }
    auto until = Clock::now() + std::chrono::milliseconds(reconnect_delay(attempt_++, random()));
    if (deadline_) until = std::min(until, *deadline_);
    std::this_thread::sleep_until(until);
    return !deadline_ || Clock::now() < *deadline_;
  }

  double random() { return std::uniform_real_distribution<double>(0.0, 1.0)(random_); }

  Connection& connection_;
  Connection::Deadline deadline_;
  const FollowListener& listener_;
  api::WatchJobRequest request_;
  api::JobState state_ = api::JOB_STATE_UNSPECIFIED;
  std::optional<Clock::time_point> lost_since_;
  bool answered_once_ = false;
  int attempt_ = 0;
  std::minstd_rand random_{std::random_device()()};
};

}  // namespace

int reconnect_delay(int attempt, double random) {
  const int longest = std::min(5000, 200 << std::min(attempt, 5));
  return longest - static_cast<int>(random * longest / 2);
}

FollowEnd follow(Connection& connection, const std::string& id, std::uint64_t after_seq,
                 Connection::Deadline deadline, const FollowListener& listener) {
  return Follower(connection, id, after_seq, deadline, listener).run();
}

}  // namespace creepctl
