// A daemon that behaves as a test says: what a real one does only once in a while, such as breaking a stream
// in the middle of a file.
#pragma once

#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "client/remote/connection.h"

namespace creepctl {

inline CallResult failure(absl::StatusCode code, const std::string& reason = "") {
  CallResult result;
  result.status = absl::Status(code, "as scripted");
  result.reason = reason;
  return result;
}

template <typename Message>
struct ScriptedStream final : Stream<Message> {
  std::vector<Message> messages;
  CallResult end;
  std::size_t next = 0;

  bool read(Message& message) override {
    if (next == messages.size()) return false;
    message = messages[next++];
    return true;
  }
  CallResult finish() override { return end; }
};

/// Streams in the order in which they are asked for; calls that a test does not script are Unimplemented.
class ScriptedConnection : public Connection {
 public:
  std::deque<std::pair<std::vector<api::Event>, CallResult>> watches;
  std::deque<std::pair<std::vector<api::ArtifactChunk>, CallResult>> fetches;
  std::vector<api::WatchJobRequest> watch_requests;
  std::vector<api::FetchArtifactRequest> fetch_requests;
  std::vector<api::Job> jobs;  ///< what GetJob and ListJobs know
  std::vector<api::Artifact> artifacts;

  const std::string& target() const override { return target_; }
  void set_patience(std::chrono::milliseconds) override {}

  CallResult call(const api::GetJobRequest& request, api::Job& response) override {
    for (const api::Job& job : jobs) {
      if (job.id() == request.job()) {
        response = job;
        return {};
      }
    }
    return failure(absl::StatusCode::kNotFound, "JOB_NOT_FOUND");
  }
  /// Two a page.
  CallResult call(const api::ListJobsRequest& request, api::ListJobsResponse& response) override {
    response.Clear();
    const std::size_t from = request.page_token().empty() ? 0 : std::stoul(request.page_token());
    for (std::size_t i = from; i < jobs.size() && i < from + 2; ++i) *response.add_jobs() = jobs[i];
    if (from + 2 < jobs.size()) response.set_next_page_token(std::to_string(from + 2));
    return {};
  }
  CallResult call(const api::ReadCurvesRequest&, api::Curves&) override { return none(); }
  CallResult call(const api::ListArtifactsRequest&, api::ListArtifactsResponse& response) override {
    for (const api::Artifact& artifact : artifacts) *response.add_artifacts() = artifact;
    return {};
  }
  CallResult call(const api::SubmitJobRequest&, api::SubmitJobResponse&) override { return none(); }
  CallResult call(const api::ForkJobRequest&, api::SubmitJobResponse&) override { return none(); }
  CallResult call(const api::PlanJobRequest&, api::PlanJobResponse&) override { return none(); }
  CallResult call(const api::PauseJobRequest&, api::Job&) override { return none(); }
  CallResult call(const api::ResumeJobRequest&, api::Job&) override { return none(); }
  CallResult call(const api::CancelJobRequest&, api::Job&) override { return none(); }
  CallResult call(const api::DeleteJobRequest&, api::DeleteJobResponse&) override { return none(); }
  CallResult call(const api::DeleteJobsRequest&, api::DeleteJobsResponse&) override { return none(); }
  CallResult call(const api::ListAttemptsRequest&, api::ListAttemptsResponse&) override { return none(); }
  CallResult call(const api::GetServerInfoRequest&, api::ServerInfo&) override { return none(); }

  std::unique_ptr<Stream<api::Event>> watch(const api::WatchJobRequest& request, Deadline) override {
    watch_requests.push_back(request);
    return next(watches);
  }
  std::unique_ptr<Stream<api::ArtifactChunk>> fetch(const api::FetchArtifactRequest& request) override {
    fetch_requests.push_back(request);
    return next(fetches);
  }

 private:
  static CallResult none() { return failure(absl::StatusCode::kUnimplemented, "UNSCRIPTED"); }

  template <typename Message>
  static std::unique_ptr<Stream<Message>> next(
      std::deque<std::pair<std::vector<Message>, CallResult>>& script) {
    auto stream = std::make_unique<ScriptedStream<Message>>();
    stream->end = none();
    if (script.empty()) return stream;
    stream->messages = std::move(script.front().first);
    stream->end = std::move(script.front().second);
    script.pop_front();
    return stream;
  }

  std::string target_ = "scripted";
};

}  // namespace creepctl
