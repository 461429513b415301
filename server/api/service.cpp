#include "server/api/service.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/arithmetic/digest.h"
#include "server/api/answer.h"
#include "server/worker/durable_file.h"

namespace creepd {
namespace {

namespace v1 = creep::v1;

constexpr int kMostTransfers = 64;
constexpr std::size_t kChunk = 256 << 10;
constexpr int kMostJobsOnPage = 1000;
constexpr int kMostSamplesOnPage = 5000;

template <class Request>
Submission submission_of(const Request& request) {
  return {request.spec(),
          request.request_id(),
          {request.labels().begin(), request.labels().end()},
          request.priority()};
}

/// Ties a page token to the list it came from.
std::string list_mark(const Caller& caller, const v1::ListJobsRequest& request) {
  std::string filter = caller.owner;
  for (const int state : request.states()) absl::StrAppend(&filter, "\n", state);
  const std::map<std::string, std::string> labels(request.labels().begin(), request.labels().end());
  for (const auto& [key, value] : labels) absl::StrAppend(&filter, "\n", key, " ", value.size(), " ", value);
  return creep::sha256_hex(filter).substr(0, 16);
}

std::optional<std::int64_t> number_in(const std::string& token, const std::string& mark) {
  std::int64_t number = 0;
  if (token.size() <= mark.size() + 1 || !token.starts_with(mark + "-")) return std::nullopt;
  const char* const end = token.data() + token.size();
  const auto parsed = std::from_chars(token.data() + mark.size() + 1, end, number);
  if (parsed.ec != std::errc() || parsed.ptr != end || number <= 0) return std::nullopt;
  return number;
}

/// One FetchArtifact: reads on a thread of the queue, one chunk in flight.
class FetchStream final : public grpc::ServerWriteReactor<v1::ArtifactChunk> {
 public:
  FetchStream(CallQueue& calls, std::atomic<int>& transfers) : calls_(calls), transfers_(transfers) {
    ++transfers_;
  }
  ~FetchStream() override { --transfers_; }

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
    if (got < 0) return fail(errno_status("read " + open_.artifact.name, errno));
    if (got == 0 && !data.empty()) return fail(absl::DataLossError(open_.artifact.name + " became shorter"));
    data.resize(static_cast<std::size_t>(got));
    chunk_.set_offset(offset_);
    offset_ += data.size();
    StartWrite(&chunk_);
  }

  CallQueue& calls_;
  std::atomic<int>& transfers_;
  OpenArtifact open_;
  std::uint64_t offset_ = 0;
  v1::ArtifactChunk chunk_;
};

absl::Status check_fetch(const OpenArtifact& open, const v1::FetchArtifactRequest& request) {
  if (!request.etag().empty() && request.etag() != open.artifact.etag) {
    return refuse(absl::StatusCode::kAborted, "another file has taken its place; begin at 0",
                  {"ARTIFACT_REPLACED", {{"etag", open.artifact.etag}}, {}, {}});
  }
  if (request.offset() <= open.artifact.size) return absl::OkStatus();
  return refuse(absl::StatusCode::kOutOfRange, "offset is beyond the end",
                {"OFFSET_BEYOND_END", {{"size_bytes", absl::StrCat(open.artifact.size)}}, {}, {}});
}

}  // namespace

CreepService::CreepService(Jobs& jobs, JobStore& store, SampleLibrary& samples, WatchHub& hub,
                           FillServerInfo fill_server_info)
    : jobs_(jobs),
      store_(store),
      samples_(samples),
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

absl::Status CreepService::fill(const Job& job, v1::Job& message) {
  to_message(job, message);
  if (job.state != JobState::kQueued || job.id.empty()) return absl::OkStatus();
  const auto positions = store_.queue_positions();
  if (!positions.ok()) return positions.status();
  const auto position = positions->find(job.id);
  message.set_queue_position(position == positions->end() ? 0 : position->second);
  return absl::OkStatus();
}

CreepService::Unary* CreepService::SubmitJob(Context* context, const v1::SubmitJobRequest* request,
                                             v1::SubmitJobResponse* response) {
  return answer(context, [=, this](const Caller& caller) -> absl::Status {
    const Submission submission = submission_of(*request);
    if (request->validate_only()) {
      const auto job = jobs_.check(caller, submission);
      if (!job.ok()) return job.status();
      return fill(*job, *response->mutable_job());
    }
    const auto inserted = jobs_.submit(caller, submission);
    if (!inserted.ok()) return inserted.status();
    response->set_already_existed(inserted->already_existed);
    to_message(inserted->job, *response->mutable_job());
    return absl::OkStatus();
  });
}

CreepService::Unary* CreepService::ForkJob(Context* context, const v1::ForkJobRequest* request,
                                           v1::SubmitJobResponse* response) {
  return answer(context, [=, this](const Caller& caller) -> absl::Status {
    const auto inserted = jobs_.fork(caller, request->job(), request->generation(), submission_of(*request));
    if (!inserted.ok()) return inserted.status();
    response->set_already_existed(inserted->already_existed);
    to_message(inserted->job, *response->mutable_job());
    return absl::OkStatus();
  });
}

CreepService::Unary* CreepService::GetJob(Context* context, const v1::GetJobRequest* request,
                                          v1::Job* response) {
  return answer(context, [=, this](const Caller& caller) -> absl::Status {
    const auto job = jobs_.get(caller, request->job());
    return job.ok() ? fill(*job, *response) : job.status();
  });
}

absl::Status CreepService::list_jobs(const Caller& caller, const v1::ListJobsRequest& request,
                                     v1::ListJobsResponse& response) {
  std::vector<Violation> violations;
  if (request.page_size() < 0) violations.push_back({"page_size", "must not be negative"});
  const std::string mark = list_mark(caller, request);
  ListQuery query;
  if (!request.page_token().empty()) {
    const auto number = number_in(request.page_token(), mark);
    if (!number) violations.push_back({"page_token", "is not from this list"});
    query.before_number = number.value_or(0);
  }
  for (const int state : request.states()) {
    if (state < 1 || state > 6) violations.push_back({"states", absl::StrCat(state, " is no state")});
    query.states.push_back(static_cast<JobState>(state));
  }
  if (request.labels_size() > 32) violations.push_back({"labels", "at most 32"});
  if (!violations.empty()) return bad_request(std::move(violations));
  if (!caller.admin) query.owner = caller.owner;
  query.labels = {request.labels().begin(), request.labels().end()};
  const int size = request.page_size() == 0 ? 50 : std::min(request.page_size(), kMostJobsOnPage);
  query.limit = size + 1;  // one more tells whether there is another page
  auto jobs = store_.list(query);
  if (!jobs.ok()) return jobs.status();
  if (static_cast<int>(jobs->size()) > size) {
    jobs->pop_back();
    response.set_next_page_token(absl::StrCat(mark, "-", jobs->back().number));
  }
  std::map<std::string, std::int64_t> positions;
  if (std::any_of(jobs->begin(), jobs->end(),
                  [](const Job& job) { return job.state == JobState::kQueued; })) {
    auto found = store_.queue_positions();
    if (!found.ok()) return found.status();
    positions = *std::move(found);
  }
  for (const Job& job : *jobs) {
    v1::Job& message = *response.add_jobs();
    to_message(job, message);
    if (const auto found = positions.find(job.id); found != positions.end())
      message.set_queue_position(found->second);
  }
  return absl::OkStatus();
}

CreepService::Unary* CreepService::ListJobs(Context* context, const v1::ListJobsRequest* request,
                                            v1::ListJobsResponse* response) {
  return answer(context, [=, this](const Caller& caller) { return list_jobs(caller, *request, *response); });
}

CreepService::Unary* CreepService::PauseJob(Context* context, const v1::PauseJobRequest* request,
                                            v1::Job* response) {
  return answer(context, [=, this](const Caller& caller) -> absl::Status {
    const auto job = jobs_.pause(caller, request->job());
    return job.ok() ? fill(*job, *response) : job.status();
  });
}

CreepService::Unary* CreepService::ResumeJob(Context* context, const v1::ResumeJobRequest* request,
                                             v1::Job* response) {
  return answer(context, [=, this](const Caller& caller) -> absl::Status {
    const auto job = jobs_.resume(caller, request->job());
    return job.ok() ? fill(*job, *response) : job.status();
  });
}

CreepService::Unary* CreepService::CancelJob(Context* context, const v1::CancelJobRequest* request,
                                             v1::Job* response) {
  return answer(context, [=, this](const Caller& caller) -> absl::Status {
    const auto job = jobs_.cancel(caller, request->job(), request->mode() == v1::CancelJobRequest::NOW);
    return job.ok() ? fill(*job, *response) : job.status();
  });
}

CreepService::Unary* CreepService::DeleteJob(Context* context, const v1::DeleteJobRequest* request,
                                             v1::DeleteJobResponse* /*response*/) {
  return answer(context, [=, this](const Caller& caller) { return jobs_.remove(caller, request->job()); });
}

absl::Status CreepService::list_samples(const Caller& caller, const v1::ListSamplesRequest& request,
                                        v1::ListSamplesResponse& response) {
  std::vector<Violation> violations;
  if (request.page_size() < 0) violations.push_back({"page_size", "must not be negative"});
  if (request.stride() < 0) violations.push_back({"stride", "must not be negative"});
  if (!violations.empty()) return bad_request(std::move(violations));
  const auto job = jobs_.get(caller, request.job());
  if (!job.ok()) return job.status();
  const auto samples = samples_.of(job->id);
  const auto damaged = [](const absl::Status& status) {
    return refuse(absl::StatusCode::kDataLoss, std::string(status.message()), {"LOG_DAMAGED", {}, {}, {}});
  };
  const auto there = samples->poll();
  if (!there.ok() && samples->size() <= request.first_index()) return damaged(there.status());
  const std::uint64_t end = std::min(samples->size(), job->samples);
  const int size = request.page_size() == 0 ? 1000 : std::min(request.page_size(), kMostSamplesOnPage);
  const auto stride = static_cast<std::uint64_t>(std::max(1, request.stride()));
  std::uint64_t index = request.first_index();
  for (; index < end && response.samples_size() < size; index += stride) {
    const auto sample = samples->read(index);
    if (!sample.ok()) return damaged(sample.status());
    to_message(*sample, index, *response.add_samples());
  }
  response.set_next_index(index);
  response.set_at_end(index >= end);
  return absl::OkStatus();
}

CreepService::Unary* CreepService::ListSamples(Context* context, const v1::ListSamplesRequest* request,
                                               v1::ListSamplesResponse* response) {
  return answer(context,
                [=, this](const Caller& caller) { return list_samples(caller, *request, *response); });
}

CreepService::Unary* CreepService::ListArtifacts(Context* context, const v1::ListArtifactsRequest* request,
                                                 v1::ListArtifactsResponse* response) {
  return answer(context, [=, this](const Caller& caller) -> absl::Status {
    const auto job = jobs_.get(caller, request->job());
    if (!job.ok()) return job.status();
    for (const Artifact& artifact : list_artifacts(jobs_.folder(job->id))) {
      to_message(artifact, *response->add_artifacts());
    }
    return absl::OkStatus();
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
    if (transfers_ > kMostTransfers) {
      return stream->fail(refuse(absl::StatusCode::kResourceExhausted, "there are too many transfers",
                                 {"TOO_MANY_TRANSFERS", {{"limit", absl::StrCat(kMostTransfers)}}, {}, 10}));
    }
    const auto job = jobs_.get(*caller, request->job());
    if (!job.ok()) return stream->fail(job.status());
    auto open = open_artifact(jobs_.folder(job->id), request->name());
    if (!open.ok()) return stream->fail(open.status());
    if (auto status = check_fetch(*open, *request); !status.ok()) return stream->fail(status);
    stream->begin(*std::move(open), request->offset());
  };
  if (!calls_.run(begin)) {
    stream->fail(
        refuse(absl::StatusCode::kUnavailable, "too many calls wait already", {"OVERLOADED", {}, {}, 5}));
  }
  return stream;
}

}  // namespace creepd
