#include "server/api/request_handler.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/arithmetic/digest.h"
#include "server/api/convert.h"
#include "server/api/read_curves.h"
#include "server/jobs/job_plan.h"
#include "server/rules/refusal.h"

namespace creepd {
namespace {

namespace v1 = creep::v1;

constexpr int kMostJobsOnPage = 1000;
constexpr int kMostSamplesOnPage = 5000;
constexpr int kMostAttemptsOnPage = 1000;
constexpr int kMostDeletions = 1000;
constexpr int kPilotPriority = 100;  // it is short, and somebody waits for it

template <class Request>
Submission submission_of(const Request& request) {
  return {request.spec(),
          request.request_id(),
          {request.labels().begin(), request.labels().end()},
          request.priority(),
          {request.overrides().begin(), request.overrides().end()}};
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

void RequestHandler::add_figures(const Job& job, v1::Job& message) {
  if (job.state != JobState::kSucceeded) return;
  for (const auto& [name, value] : figures_.of(jobs_.folder(job.id)))
    (*message.mutable_figures())[name] = value;
}

absl::Status RequestHandler::fill(const absl::StatusOr<Job>& job, v1::Job& message) {
  if (!job.ok()) return job.status();
  to_message(*job, message);
  add_figures(*job, message);
  if (job->state != JobState::kQueued || job->id.empty()) return absl::OkStatus();
  const auto position = store_.queue_position(*job);
  if (!position.ok()) return position.status();
  message.set_queue_position(*position);
  return absl::OkStatus();
}

absl::Status RequestHandler::submit(const Caller& caller, const v1::SubmitJobRequest& request,
                                    v1::SubmitJobResponse& response) {
  const Submission submission = submission_of(request);
  if (request.validate_only()) return fill(jobs_.check(caller, submission), *response.mutable_job());
  const auto inserted = jobs_.submit(caller, submission);
  if (!inserted.ok()) return inserted.status();
  response.set_already_existed(inserted->already_existed);
  return fill(inserted->job, *response.mutable_job());
}

absl::Status RequestHandler::fork(const Caller& caller, const v1::ForkJobRequest& request,
                                  v1::SubmitJobResponse& response) {
  if (request.generation() != 0 && !request.checkpoint().empty()) {
    return bad_request({{"checkpoint", "give either checkpoint or generation, not both"}});
  }
  const auto inserted =
      jobs_.fork(caller, request.job(), {request.generation(), request.checkpoint()}, submission_of(request));
  if (!inserted.ok()) return inserted.status();
  response.set_already_existed(inserted->already_existed);
  return fill(inserted->job, *response.mutable_job());
}

absl::Status RequestHandler::plan(const Caller& caller, const v1::PlanJobRequest& request,
                                  v1::PlanJobResponse& response) {
  if (request.request_id().empty())
    return bad_request({{"request_id", "must be given: by it the pilot is found again"}});
  Submission asked;
  asked.spec = request.spec();
  asked.overrides = {request.overrides().begin(), request.overrides().end()};
  const auto whole = Jobs::completed(std::move(asked));
  if (!whole.ok()) return whole.status();
  auto spec = pilot_spec(whole->spec);
  if (!spec.ok()) return spec.status();
  Submission submission;
  submission.spec = *std::move(spec);
  submission.request_id = request.request_id();
  submission.labels = {{"pilot", ""}};
  submission.priority = kPilotPriority;
  const auto inserted = jobs_.submit(caller, submission);
  if (!inserted.ok()) return inserted.status();
  const Job& pilot = inserted->job;
  if (pilot.state == JobState::kFailed || pilot.state == JobState::kCancelled) {
    return refuse(absl::StatusCode::kFailedPrecondition,
                  absl::StrCat("the pilot ", pilot.id, " is ", state_name(pilot.state), ": ", pilot.message),
                  {"PILOT_FAILED", {{"job", pilot.id}, {"state", state_name(pilot.state)}}, {}, {}});
  }
  if (pilot.state == JobState::kSucceeded) {
    const std::string reason = pilot.message.empty() ? "completed" : pilot.message;
    const auto planned = read_job_plan(whole->spec, jobs_.folder(pilot.id), reason);
    if (!planned.ok()) {
      return refuse(absl::StatusCode::kDataLoss, std::string(planned.status().message()),
                    {"PILOT_DAMAGED", {{"job", pilot.id}}, {}, {}});
    }
    to_message(*planned, *response.mutable_plan());
    response.mutable_plan()->set_threads(jobs_.limits().threads);
  }
  return fill(pilot, *response.mutable_pilot());
}

absl::Status RequestHandler::get(const Caller& caller, const v1::GetJobRequest& request, v1::Job& response) {
  return fill(jobs_.get(caller, request.job()), response);
}

absl::Status RequestHandler::list(const Caller& caller, const v1::ListJobsRequest& request,
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
  query.labels = {request.labels().begin(), request.labels().end()};
  const int size = request.page_size() == 0 ? 50 : std::min(request.page_size(), kMostJobsOnPage);
  query.limit = size + 1;  // one more tells whether there is another page
  auto jobs = jobs_.list(caller, query);
  if (!jobs.ok()) return jobs.status();
  if (static_cast<int>(jobs->size()) > size) {
    jobs->pop_back();
    response.set_next_page_token(absl::StrCat(mark, "-", jobs->back().number));
  }
  std::unordered_map<std::int64_t, std::int64_t> positions;
  if (std::any_of(jobs->begin(), jobs->end(),
                  [](const Job& job) { return job.state == JobState::kQueued; })) {
    auto found = store_.queue_positions();
    if (!found.ok()) return found.status();
    positions = *std::move(found);
  }
  for (const Job& job : *jobs) {
    v1::Job& message = *response.add_jobs();
    to_message(job, message);
    add_figures(job, message);
    if (const auto found = positions.find(job.number); found != positions.end())
      message.set_queue_position(found->second);
  }
  return absl::OkStatus();
}

absl::Status RequestHandler::pause(const Caller& caller, const v1::PauseJobRequest& request,
                                   v1::Job& response) {
  return fill(jobs_.pause(caller, request.job()), response);
}

absl::Status RequestHandler::resume(const Caller& caller, const v1::ResumeJobRequest& request,
                                    v1::Job& response) {
  return fill(jobs_.resume(caller, request.job()), response);
}

absl::Status RequestHandler::cancel(const Caller& caller, const v1::CancelJobRequest& request,
                                    v1::Job& response) {
  return fill(jobs_.cancel(caller, request.job(), request.mode() == v1::CancelJobRequest::NOW), response);
}

absl::Status RequestHandler::remove(const Caller& caller, const v1::DeleteJobRequest& request) {
  return jobs_.remove(caller, request.job());
}

absl::Status RequestHandler::remove_all(const Caller& caller, const v1::DeleteJobsRequest& request,
                                        v1::DeleteJobsResponse& response) {
  if (request.jobs_size() > kMostDeletions) {
    return bad_request({{"jobs", absl::StrCat(request.jobs_size(), " given; at most ", kMostDeletions)}});
  }
  const std::vector<std::string> ids(request.jobs().begin(), request.jobs().end());
  const auto removed = jobs_.remove_all(caller, ids);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    v1::DeleteJobsResponse::Deletion& deletion = *response.add_deletions();
    deletion.set_job(ids[i]);
    deletion.set_deleted(removed[i].ok());
    deletion.set_reason(refusal_of(removed[i]).reason);
    deletion.set_message(std::string(removed[i].message()));
  }
  return absl::OkStatus();
}

absl::Status RequestHandler::list_attempts(const Caller& caller, const v1::ListAttemptsRequest& request,
                                           v1::ListAttemptsResponse& response) {
  std::vector<Violation> violations;
  if (request.page_size() < 0) violations.push_back({"page_size", "must not be negative"});
  if (request.first_number() < 0) violations.push_back({"first_number", "must not be negative"});
  if (!violations.empty()) return bad_request(std::move(violations));
  const int size = request.page_size() == 0 ? 100 : std::min(request.page_size(), kMostAttemptsOnPage);
  auto attempts = jobs_.attempts(caller, request.job(), request.first_number(), size + 1);
  if (!attempts.ok()) return attempts.status();
  response.set_at_end(static_cast<int>(attempts->size()) <= size);
  if (!response.at_end()) attempts->pop_back();
  std::int64_t next = std::max<std::int64_t>(1, request.first_number());
  for (const Attempt& attempt : *attempts) {
    to_message(attempt, *response.add_attempts());
    next = attempt.number + 1;
  }
  response.set_next_number(next);
  return absl::OkStatus();
}

absl::Status RequestHandler::list_samples(const Caller& caller, const v1::ListSamplesRequest& request,
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

absl::Status RequestHandler::read_curves(const Caller& caller, const v1::ReadCurvesRequest& request,
                                         v1::Curves& response) {
  const auto job = jobs_.get(caller, request.job());
  if (!job.ok()) return job.status();
  return creepd::read_curves(*samples_.of(job->id), job->samples, request, response);
}

absl::Status RequestHandler::list_artifacts(const Caller& caller, const v1::ListArtifactsRequest& request,
                                            v1::ListArtifactsResponse& response) {
  const auto job = jobs_.get(caller, request.job());
  if (!job.ok()) return job.status();
  for (const Artifact& artifact : creepd::list_artifacts(jobs_.folder(job->id))) {
    to_message(artifact, *response.add_artifacts());
  }
  return absl::OkStatus();
}

absl::StatusOr<OpenArtifact> RequestHandler::open(const Caller& caller,
                                                  const v1::FetchArtifactRequest& request) {
  const auto job = jobs_.get(caller, request.job());
  if (!job.ok()) return job.status();
  auto open = open_artifact(jobs_.folder(job->id), request.name());
  if (!open.ok()) return open.status();
  if (auto status = check_fetch(*open, request); !status.ok()) return status;
  return open;
}

}  // namespace creepd
