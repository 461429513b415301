// What each call answers: from request to response. Protocol buffers, no gRPC.
#pragma once

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "creep/v1/creep.pb.h"
#include "server/folders/figure_library.h"
#include "server/folders/sample_index.h"
#include "server/jobs/jobs.h"
#include "server/store/job_store.h"

namespace creepd {

/// The calls and their errors are documented in creep.proto. Safe from several threads; may wait on the disk.
class RequestHandler {
 public:
  RequestHandler(Jobs& jobs, JobStore& store, SampleLibrary& samples)
      : jobs_(jobs), store_(store), samples_(samples) {}

  absl::Status submit(const Caller& caller, const creep::v1::SubmitJobRequest& request,
                      creep::v1::SubmitJobResponse& response);
  absl::Status fork(const Caller& caller, const creep::v1::ForkJobRequest& request,
                    creep::v1::SubmitJobResponse& response);
  absl::Status plan(const Caller& caller, const creep::v1::PlanJobRequest& request,
                    creep::v1::PlanJobResponse& response);
  absl::Status get(const Caller& caller, const creep::v1::GetJobRequest& request, creep::v1::Job& response);
  absl::Status list(const Caller& caller, const creep::v1::ListJobsRequest& request,
                    creep::v1::ListJobsResponse& response);
  absl::Status pause(const Caller& caller, const creep::v1::PauseJobRequest& request,
                     creep::v1::Job& response);
  absl::Status resume(const Caller& caller, const creep::v1::ResumeJobRequest& request,
                      creep::v1::Job& response);
  absl::Status cancel(const Caller& caller, const creep::v1::CancelJobRequest& request,
                      creep::v1::Job& response);
  absl::Status remove(const Caller& caller, const creep::v1::DeleteJobRequest& request);
  absl::Status remove_all(const Caller& caller, const creep::v1::DeleteJobsRequest& request,
                          creep::v1::DeleteJobsResponse& response);
  absl::Status list_attempts(const Caller& caller, const creep::v1::ListAttemptsRequest& request,
                             creep::v1::ListAttemptsResponse& response);
  absl::Status list_samples(const Caller& caller, const creep::v1::ListSamplesRequest& request,
                            creep::v1::ListSamplesResponse& response);
  absl::Status read_curves(const Caller& caller, const creep::v1::ReadCurvesRequest& request,
                           creep::v1::Curves& response);
  absl::Status list_artifacts(const Caller& caller, const creep::v1::ListArtifactsRequest& request,
                              creep::v1::ListArtifactsResponse& response);
  /// What FetchArtifact is going to send, from the offset of the request on.
  absl::StatusOr<OpenArtifact> open(const Caller& caller, const creep::v1::FetchArtifactRequest& request);

 private:
  absl::Status fill(const absl::StatusOr<Job>& job, creep::v1::Job& message);
  void add_figures(const Job& job, creep::v1::Job& message);

  Jobs& jobs_;
  JobStore& store_;
  SampleLibrary& samples_;
  FigureLibrary figures_;
};

}  // namespace creepd
