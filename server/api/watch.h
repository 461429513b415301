// The watch streams of all jobs, served by one thread.
//
// A stream has at most one write in flight: a slow reader costs one message of memory and delays nobody. Only
// the thread here starts writes and finishes streams, so a stream lives until this thread has finished it.
#pragma once

#include <chrono>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <grpcpp/grpcpp.h>

#include "creep/v1/creep.pb.h"
#include "server/folders/sample_index.h"
#include "server/jobs/jobs.h"
#include "server/store/job_store.h"

namespace creepd {

class WatchStream;

class WatchHub {
 public:
  static constexpr int kMostWatchers = 1000;

  WatchHub(Jobs& jobs, JobStore& store, SampleLibrary& samples);
  ~WatchHub();

  /// A stream of the events after `after_seq`, errors included.
  grpc::ServerWriteReactor<creep::v1::Event>* watch(grpc::CallbackServerContext* context,
                                                    std::optional<Caller> caller,
                                                    const creep::v1::WatchJobRequest& request);
  /// Something happened to this job. Any thread.
  void changed(const std::string& job);
  /// Ends all streams and those to come: the daemon is going down.
  void stop();

  /// Those admitted: one that is refused does not count, or many at once would shut out those that fit.
  int watchers() const;

 private:
  friend class WatchStream;
  using Clock = std::chrono::steady_clock;

  struct Feed {
    Job job;
    std::vector<StateEvent> changes;
    std::shared_ptr<SampleIndex> samples;
    std::uint64_t readable = 0;
    bool stale = true;
  };

  void loop();
  void serve(WatchStream& stream);
  absl::Status admit(WatchStream& stream);
  absl::StatusOr<Feed*> feed_of(const std::string& job);
  void send(WatchStream& stream);
  void finish(WatchStream& stream, const absl::Status& status);
  void forget_unused_feeds();

  Jobs& jobs_;
  JobStore& store_;
  SampleLibrary& samples_;
  std::map<std::string, Feed> feeds_;  // of the thread alone

  mutable std::mutex mutex_;
  std::condition_variable news_;
  std::set<WatchStream*> streams_;
  int admitted_ = 0;  // of them
  std::set<std::string> changed_;
  bool some_left_ = false;  // since feeds were last looked through
  bool stopping_ = false;
  bool ended_ = false;
  std::thread thread_;
};

}  // namespace creepd
