#include "server/api/service.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/folder/durable_file.h"
#include "server/api/answer.h"
#include "server/api/convert.h"
#include "server/api/read_curves.h"

namespace creepd {
namespace {

namespace v1 = creep::v1;

constexpr int kMostTransfers = 64;
constexpr std::size_t kChunk = 256 << 10;

/// One FetchArtifact: reads on a thread of the queue, one chunk in flight.
class FetchStream final : public grpc::ServerWriteReactor<v1::ArtifactChunk> {
 public:
  FetchStream(CallQueue& calls, std::atomic<int>& transfers) : calls_(calls), transfers_(transfers) {}
  ~FetchStream() override {
    if (counted_) --transfers_;
  }

  /// False if there are too many already. One that is refused is not counted: it would shut out those that
  /// fit.
  bool admit() {
    counted_ = transfers_.fetch_add(1) < kMostTransfers;
    if (!counted_) --transfers_;
    return counted_;
  }
  void begin(OpenArtifact open, std::uint64_t offset) {
    open_ = std::move(open);
    offset_ = offset;
    to_message(open_.artifact, *chunk_.mutable_artifact());
    send();
  }
  void fail(const absl::Status& status) { Finish(to_grpc(status)); }

  void OnWriteDone(bool ok) override {
    chunk_.clear_artifact();
    if (!ok) return Finish(grpc::Status::CANCELLED);
    if (!calls_.run([this] { send(); }))
      Finish(grpc::Status(grpc::StatusCode::UNAVAILABLE, "too many calls"));
  }
  void OnDone() override { delete this; }

 private:
  void send() {
    const bool first = chunk_.has_artifact();
    if (offset_ >= open_.artifact.size && !first) return Finish(grpc::Status::OK);
    std::string& data = *chunk_.mutable_data();
    data.resize(std::min<std::uint64_t>(kChunk, open_.artifact.size - offset_));
    const ssize_t got = ::pread(open_.file.get(), data.data(), data.size(), static_cast<off_t>(offset_));
    if (got < 0) return fail(creep::errno_status("read " + open_.artifact.name, errno));
    if (got == 0 && !data.empty()) return fail(absl::DataLossError(open_.artifact.name + " became shorter"));
    data.resize(static_cast<std::size_t>(got));
    chunk_.set_offset(offset_);
    offset_ += data.size();
    StartWrite(&chunk_);
  }

  CallQueue& calls_;
  std::atomic<int>& transfers_;
  bool counted_ = false;
  OpenArtifact open_;
  std::uint64_t offset_ = 0;
  v1::ArtifactChunk chunk_;
};

}  // namespace

CreepService::CreepService(Jobs& jobs, JobStore& store, SampleLibrary& samples, WatchHub& hub,
                           FillServerInfo fill_server_info)
    : handler_(jobs, store, samples),
      store_(store),
      hub_(hub),
      fill_server_info_(std::move(fill_server_info)) {}

CreepService::Unary* CreepService::answer(Context* context, Work work) {
  Unary* reactor = context->DefaultReactor();
  const std::optional<Caller> caller = caller_of(*context);
  absl::Status refused;
  if (refusing_) {
    refused = shutting_down();
  } else if (!caller) {
    refused = unknown_user();
  } else if (!calls_.run([reactor, caller = *caller, work = std::move(work)] {
               reactor->Finish(to_grpc(work(caller)));
             })) {
    refused =
        refuse(absl::StatusCode::kUnavailable, "too many calls wait already", {"OVERLOADED", {}, {}, 5});
  }
  if (!refused.ok()) reactor->Finish(to_grpc(refused));
  return reactor;
}

CreepService::Unary* CreepService::SubmitJob(Context* context, const v1::SubmitJobRequest* request,
                                             v1::SubmitJobResponse* response) {
  return answer(context,
                [=, this](const Caller& caller) { return handler_.submit(caller, *request, *response); });
}

CreepService::Unary* CreepService::ForkJob(Context* context, const v1::ForkJobRequest* request,
                                           v1::SubmitJobResponse* response) {
  return answer(context,
                [=, this](const Caller& caller) { return handler_.fork(caller, *request, *response); });
}

CreepService::Unary* CreepService::PlanJob(Context* context, const v1::PlanJobRequest* request,
                                           v1::PlanJobResponse* response) {
  return answer(context,
                [=, this](const Caller& caller) { return handler_.plan(caller, *request, *response); });
}

CreepService::Unary* CreepService::GetJob(Context* context, const v1::GetJobRequest* request,
                                          v1::Job* response) {
  return answer(context,
                [=, this](const Caller& caller) { return handler_.get(caller, *request, *response); });
}

CreepService::Unary* CreepService::ListJobs(Context* context, const v1::ListJobsRequest* request,
                                            v1::ListJobsResponse* response) {
  return answer(context,
                [=, this](const Caller& caller) { return handler_.list(caller, *request, *response); });
}

CreepService::Unary* CreepService::PauseJob(Context* context, const v1::PauseJobRequest* request,
                                            v1::Job* response) {
  return answer(context,
                [=, this](const Caller& caller) { return handler_.pause(caller, *request, *response); });
}

CreepService::Unary* CreepService::ResumeJob(Context* context, const v1::ResumeJobRequest* request,
                                             v1::Job* response) {
  return answer(context,
                [=, this](const Caller& caller) { return handler_.resume(caller, *request, *response); });
}

CreepService::Unary* CreepService::CancelJob(Context* context, const v1::CancelJobRequest* request,
                                             v1::Job* response) {
  return answer(context,
                [=, this](const Caller& caller) { return handler_.cancel(caller, *request, *response); });
}

CreepService::Unary* CreepService::DeleteJob(Context* context, const v1::DeleteJobRequest* request,
                                             v1::DeleteJobResponse* /*response*/) {
  return answer(context, [=, this](const Caller& caller) { return handler_.remove(caller, *request); });
}

CreepService::Unary* CreepService::DeleteJobs(Context* context, const v1::DeleteJobsRequest* request,
                                              v1::DeleteJobsResponse* response) {
  return answer(context,
                [=, this](const Caller& caller) { return handler_.remove_all(caller, *request, *response); });
}

CreepService::Unary* CreepService::ListAttempts(Context* context, const v1::ListAttemptsRequest* request,
                                                v1::ListAttemptsResponse* response) {
  return answer(context, [=, this](const Caller& caller) {
    return handler_.list_attempts(caller, *request, *response);
  });
}

CreepService::Unary* CreepService::ListSamples(Context* context, const v1::ListSamplesRequest* request,
                                               v1::ListSamplesResponse* response) {
  return answer(context, [=, this](const Caller& caller) {
    return handler_.list_samples(caller, *request, *response);
  });
}

CreepService::Unary* CreepService::ReadCurves(Context* context, const v1::ReadCurvesRequest* request,
                                              v1::Curves* response) {
  return answer(
      context, [=, this](const Caller& caller) { return handler_.read_curves(caller, *request, *response); });
}

CreepService::Unary* CreepService::ListArtifacts(Context* context, const v1::ListArtifactsRequest* request,
                                                 v1::ListArtifactsResponse* response) {
  return answer(context, [=, this](const Caller& caller) {
    return handler_.list_artifacts(caller, *request, *response);
  });
}

CreepService::Unary* CreepService::GetServerInfo(Context* context,
                                                 const v1::GetServerInfoRequest* /*request*/,
                                                 v1::ServerInfo* response) {
  return answer(context, [=, this](const Caller& /*caller*/) -> absl::Status {
    const auto counts = store_.counts();
    if (!counts.ok()) return counts.status();
    response->set_queued(counts->queued);
    response->set_running(static_cast<std::int32_t>(counts->running));
    response->set_watchers(hub_.watchers());
    fill_server_info_(*response);
    list_columns(*response);
    return absl::OkStatus();
  });
}

grpc::ServerWriteReactor<v1::Event>* CreepService::WatchJob(Context* context,
                                                            const v1::WatchJobRequest* request) {
  return hub_.watch(context, caller_of(*context), *request);
}

grpc::ServerWriteReactor<v1::ArtifactChunk>* CreepService::FetchArtifact(
    Context* context, const v1::FetchArtifactRequest* request) {
  auto* stream = new FetchStream(calls_, transfers_);
  const std::optional<Caller> caller = caller_of(*context);
  const auto begin = [this, stream, caller, request] {
    if (refusing_) return stream->fail(shutting_down());
    if (!caller) return stream->fail(unknown_user());
    if (!stream->admit()) {
      return stream->fail(refuse(absl::StatusCode::kResourceExhausted, "there are too many transfers",
                                 {"TOO_MANY_TRANSFERS", {{"limit", absl::StrCat(kMostTransfers)}}, {}, 10}));
    }
    auto open = handler_.open(*caller, *request);
    if (!open.ok()) return stream->fail(open.status());
    stream->begin(*std::move(open), request->offset());
  };
  if (!calls_.run(begin)) {
    stream->fail(
        refuse(absl::StatusCode::kUnavailable, "too many calls wait already", {"OVERLOADED", {}, {}, 5}));
  }
  return stream;
}

}  // namespace creepd
