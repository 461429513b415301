#include "server/api/watch.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "server/api/answer.h"
#include "server/api/convert.h"
#include "server/rules/event_feed.h"

namespace creepd {

namespace v1 = creep::v1;
using std::chrono::seconds;

namespace {

constexpr seconds kHeartbeat{10};
constexpr seconds kStalled{60};

}  // namespace

class WatchStream final : public grpc::ServerWriteReactor<v1::Event> {
 public:
  WatchStream(WatchHub& hub, grpc::CallbackServerContext* context, std::optional<Caller> caller,
              const v1::WatchJobRequest& request)
      : hub(hub),
        context(context),
        caller(std::move(caller)),
        job(request.job()),
        every_sample(request.every_sample()),
        last_seq(request.after_seq()) {}

  void OnWriteDone(bool ok) override { news(true, !ok); }
  void OnCancel() override { news(false, true); }
  void OnDone() override {
    {
      const std::lock_guard lock(hub.mutex_);
      hub.streams_.erase(this);
      if (admitted) --hub.admitted_;
      hub.some_left_ = true;
    }
    hub.news_.notify_one();
    delete this;
  }

  WatchHub& hub;
  grpc::CallbackServerContext* const context;
  // Of the hub's thread alone.
  const std::optional<Caller> caller;
  const std::string job;
  const bool every_sample;
  std::uint64_t last_seq;
  bool caught_up = false;  // once: from then on it looks on
  bool cancel_tried = false;
  v1::Event event;
  WatchHub::Clock::time_point sent = WatchHub::Clock::now();
  // Behind the hub's mutex; written by the hub's thread alone, which reads it without.
  bool admitted = false;
  // Behind the hub's mutex.
  bool in_flight = false;
  bool gone = false;
  bool finished = false;
  bool due = true;

 private:
  void news(bool landed, bool is_gone) {
    {
      const std::lock_guard lock(hub.mutex_);
      in_flight = in_flight && !landed;
      gone = gone || is_gone;
      due = true;
    }
    hub.news_.notify_one();
  }
};

WatchHub::WatchHub(Jobs& jobs, JobStore& store, SampleLibrary& samples)
    : jobs_(jobs), store_(store), samples_(samples), thread_([this] { loop(); }) {}

WatchHub::~WatchHub() {
  stop();
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  news_.notify_one();
  thread_.join();
}

grpc::ServerWriteReactor<v1::Event>* WatchHub::watch(grpc::CallbackServerContext* context,
                                                     std::optional<Caller> caller,
                                                     const v1::WatchJobRequest& request) {
  auto* stream = new WatchStream(*this, context, std::move(caller), request);
  {
    const std::lock_guard lock(mutex_);
    streams_.insert(stream);
  }
  news_.notify_one();
  return stream;
}

void WatchHub::changed(const std::string& job) {
  {
    const std::lock_guard lock(mutex_);
    if (streams_.empty()) return;
    changed_.insert(job);
  }
  news_.notify_one();
}

void WatchHub::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    for (WatchStream* stream : streams_) stream->due = true;
  }
  news_.notify_one();
}

int WatchHub::watchers() const {
  const std::lock_guard lock(mutex_);
  return admitted_;
}

void WatchHub::loop() {
  std::unique_lock lock(mutex_);
  for (;;) {
    std::set<std::string> changed = std::exchange(changed_, {});
    std::vector<WatchStream*> ready;
    const auto now = Clock::now();
    for (WatchStream* stream : streams_) {
      if (stream->finished) continue;
      if (changed.contains(stream->job) || now - stream->sent >= kHeartbeat) stream->due = true;
      if (stream->due && !stream->in_flight) {
        stream->due = false;
        ready.push_back(stream);
      } else if (stream->in_flight && now - stream->sent > kStalled &&
                 !std::exchange(stream->cancel_tried, true)) {
        stream->context->TryCancel();
      }
    }
    lock.unlock();
    for (const std::string& job : changed) {
      if (const auto feed = feeds_.find(job); feed != feeds_.end()) feed->second.stale = true;
    }
    for (WatchStream* stream : ready) serve(*stream);
    lock.lock();
    if (ended_ && streams_.empty()) return;
    if (std::exchange(some_left_, false)) forget_unused_feeds();
    const auto something = [this] {
      if (!changed_.empty() || ended_) return true;
      for (const WatchStream* stream : streams_) {
        if (stream->due && !stream->in_flight && !stream->finished) return true;
      }
      return false;
    };
    news_.wait_for(lock, seconds(1), something);
  }
}

void WatchHub::serve(WatchStream& stream) {
  bool gone = false;
  bool stopping = false;
  {
    const std::lock_guard lock(mutex_);
    gone = stream.gone;
    stopping = stopping_;
  }
  if (gone) return finish(stream, absl::CancelledError("the caller is gone"));
  if (stopping) return finish(stream, shutting_down());
  if (!stream.admitted) {
    if (auto status = admit(stream); !status.ok()) return finish(stream, status);
    const std::lock_guard lock(mutex_);
    stream.admitted = true;
    ++admitted_;
  }
  send(stream);
}

absl::Status WatchHub::admit(WatchStream& stream) {
  if (!stream.caller) return unknown_user();
  if (watchers() >= kMostWatchers) {
    return refuse(absl::StatusCode::kResourceExhausted, "there are too many watchers",
                  {"TOO_MANY_WATCHERS", {{"limit", absl::StrCat(kMostWatchers)}}, {}, 30});
  }
  const auto job = jobs_.get(*stream.caller, stream.job);
  if (!job.ok()) return job.status();
  if (stream.last_seq <= job->last_seq()) return absl::OkStatus();
  return refuse(absl::StatusCode::kOutOfRange,
                absl::StrCat("after_seq ", stream.last_seq, " is ahead of the job, whose last event is ",
                             job->last_seq()),
                {"AFTER_SEQ_IN_FUTURE", {{"last_seq", absl::StrCat(job->last_seq())}}, {}, {}});
}

absl::StatusOr<WatchHub::Feed*> WatchHub::feed_of(const std::string& job) {
  Feed& feed = feeds_[job];
  if (!feed.stale) return &feed;
  auto events = store_.events(job, feed.changes.size());
  if (!events.ok()) return events.status();
  feed.job = std::move(events->job);
  for (StateEvent& change : events->changes) feed.changes.push_back(std::move(change));
  if (!feed.samples) feed.samples = samples_.of(job);
  // A damaged log ends the samples here; the worker says what it does about it.
  const auto readable = feed.samples->poll();
  feed.readable = readable.ok() ? *readable : feed.samples->size();
  feed.stale = false;
  return &feed;
}

void WatchHub::send(WatchStream& stream) {
  const auto feed = feed_of(stream.job);
  if (!feed.ok()) return finish(stream, feed.status());
  const Feed& now = **feed;
  const std::uint64_t backlog = stream.every_sample || !stream.caught_up ? kMostBacklog : kMostLiveBacklog;
  const auto step = next_event(now.changes, now.job.samples, now.readable, stream.last_seq, backlog);
  stream.caught_up = stream.caught_up || !step;
  stream.event.Clear();
  if (step) {
    stream.event.set_seq(step->seq);
    stream.event.set_skipped(step->skipped);
    stream.last_seq = step->seq;
    if (step->change) {
      to_message(now.changes[*step->change], *stream.event.mutable_state_change());
    } else {
      const auto sample = now.samples->read(*step->sample);
      if (!sample.ok()) return finish(stream, sample.status());
      to_message(*sample, *step->sample, *stream.event.mutable_sample());
    }
  } else if (is_final(now.job.state)) {
    return finish(stream, absl::OkStatus());
  } else if (Clock::now() - stream.sent >= kHeartbeat) {
    auto& heartbeat = *stream.event.mutable_heartbeat();
    heartbeat.set_last_seq(now.job.last_seq());
    if (!to_message(now.job.progress, *heartbeat.mutable_progress())) heartbeat.clear_progress();
  } else {
    return;
  }
  stream.sent = Clock::now();
  {
    const std::lock_guard lock(mutex_);
    stream.in_flight = true;
  }
  stream.StartWrite(&stream.event);
}

void WatchHub::finish(WatchStream& stream, const absl::Status& status) {
  {
    const std::lock_guard lock(mutex_);
    stream.finished = true;
  }
  stream.Finish(to_grpc(status));  // and may be deleted from now on
}

void WatchHub::forget_unused_feeds() {
  std::set<std::string> watched;
  for (const WatchStream* stream : streams_) watched.insert(stream->job);
  std::erase_if(feeds_, [&watched](const auto& entry) { return !watched.contains(entry.first); });
}

}  // namespace creepd
