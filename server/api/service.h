// creep.v1.CreepService as gRPC calls it: who calls, and on which thread. Nothing waits on a thread of gRPC.
#pragma once

#include <atomic>
#include <functional>

#include "creep/v1/creep.grpc.pb.h"
#include "server/api/call_queue.h"
#include "server/api/request_handler.h"
#include "server/api/watch.h"

namespace creepd {

/// What GetServerInfo tells beyond the store.
using FillServerInfo = std::function<void(creep::v1::ServerInfo&)>;

class CreepService final : public creep::v1::CreepService::CallbackService {
 public:
  CreepService(Jobs& jobs, JobStore& store, SampleLibrary& samples, WatchHub& hub,
               FillServerInfo fill_server_info);

  /// From now on every call is refused with SHUTTING_DOWN.
  void refuse_calls() { refusing_ = true; }

  // The calls are documented in creep.proto.
  using Context = grpc::CallbackServerContext;
  using Unary = grpc::ServerUnaryReactor;
  Unary* SubmitJob(Context*, const creep::v1::SubmitJobRequest*, creep::v1::SubmitJobResponse*) override;
  Unary* PlanJob(Context*, const creep::v1::PlanJobRequest*, creep::v1::PlanJobResponse*) override;
  Unary* GetJob(Context*, const creep::v1::GetJobRequest*, creep::v1::Job*) override;
  Unary* ListJobs(Context*, const creep::v1::ListJobsRequest*, creep::v1::ListJobsResponse*) override;
  Unary* PauseJob(Context*, const creep::v1::PauseJobRequest*, creep::v1::Job*) override;
  Unary* ResumeJob(Context*, const creep::v1::ResumeJobRequest*, creep::v1::Job*) override;
  Unary* CancelJob(Context*, const creep::v1::CancelJobRequest*, creep::v1::Job*) override;
  Unary* ForkJob(Context*, const creep::v1::ForkJobRequest*, creep::v1::SubmitJobResponse*) override;
  Unary* DeleteJob(Context*, const creep::v1::DeleteJobRequest*, creep::v1::DeleteJobResponse*) override;
  Unary* DeleteJobs(Context*, const creep::v1::DeleteJobsRequest*, creep::v1::DeleteJobsResponse*) override;
  Unary* ListAttempts(Context*, const creep::v1::ListAttemptsRequest*,
                      creep::v1::ListAttemptsResponse*) override;
  Unary* ListSamples(Context*, const creep::v1::ListSamplesRequest*,
                     creep::v1::ListSamplesResponse*) override;
  Unary* ReadCurves(Context*, const creep::v1::ReadCurvesRequest*, creep::v1::Curves*) override;
  Unary* ListArtifacts(Context*, const creep::v1::ListArtifactsRequest*,
                       creep::v1::ListArtifactsResponse*) override;
  Unary* GetServerInfo(Context*, const creep::v1::GetServerInfoRequest*, creep::v1::ServerInfo*) override;
  grpc::ServerWriteReactor<creep::v1::Event>* WatchJob(Context*, const creep::v1::WatchJobRequest*) override;
  grpc::ServerWriteReactor<creep::v1::ArtifactChunk>* FetchArtifact(
      Context*, const creep::v1::FetchArtifactRequest*) override;

 private:
  using Work = std::function<absl::Status(const Caller&)>;
  Unary* answer(Context* context, Work work);

  RequestHandler handler_;
  JobStore& store_;
  WatchHub& hub_;
  FillServerInfo fill_server_info_;
  std::atomic<bool> refusing_ = false;
  std::atomic<int> transfers_ = 0;
  CallQueue calls_{4};
};

}  // namespace creepd
