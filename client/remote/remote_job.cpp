#include "client/remote/remote_job.h"

#include <algorithm>
#include <random>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "client/terminal/exit_codes.h"

namespace creepctl {
namespace {

constexpr int kPageSize = 1000;
constexpr std::size_t kShortestPrefix = 1;

/// Reasons that the state alone tells.
bool says_nothing(api::StateReason reason) {
  return reason == api::STATE_REASON_UNSPECIFIED || reason == api::SUBMITTED || reason == api::COMPLETED ||
         reason == api::PAUSED_BY_USER || reason == api::CANCELLED_BY_USER;
}

/// "pause requested"
std::string words_of(api::StateReason reason) {
  if (!api::StateReason_IsValid(reason)) return "";
  return absl::StrReplaceAll(absl::AsciiStrToLower(api::StateReason_Name(reason)), {{"_", " "}});
}

}  // namespace

CallResult list_jobs(Connection& connection, api::ListJobsRequest request, std::size_t limit,
                     std::vector<api::Job>& jobs) {
  api::ListJobsResponse page;
  do {
    const std::size_t wanted = limit == 0 ? kPageSize : std::min<std::size_t>(kPageSize, limit - jobs.size());
    request.set_page_size(static_cast<int>(wanted));
    CallResult result = connection.call(request, page);
    if (!result.ok()) return result;
    for (api::Job& job : *page.mutable_jobs()) jobs.push_back(std::move(job));
    request.set_page_token(page.next_page_token());
  } while (!page.next_page_token().empty() && (limit == 0 || jobs.size() < limit));
  return {};
}

CallResult list_attempts(Connection& connection, const std::string& id, std::vector<api::Attempt>& attempts) {
  api::ListAttemptsRequest request;
  request.set_job(id);
  request.set_page_size(kPageSize);
  api::ListAttemptsResponse page;
  do {
    CallResult result = connection.call(request, page);
    if (!result.ok()) return result;
    for (api::Attempt& attempt : *page.mutable_attempts()) attempts.push_back(std::move(attempt));
    request.set_first_number(page.next_number());
  } while (!page.at_end());
  return {};
}

CallResult find_job(Connection& connection, const std::string& id_or_prefix, api::Job& job) {
  api::GetJobRequest request;
  request.set_job(id_or_prefix);
  CallResult result = connection.call(request, job);
  const bool unknown = absl::IsNotFound(result.status) || absl::IsInvalidArgument(result.status);
  if (!unknown || id_or_prefix.size() < kShortestPrefix) return result;
  std::vector<api::Job> jobs;
  if (CallResult listed = list_jobs(connection, {}, 0, jobs); !listed.ok()) return listed;
  std::vector<std::string> ids;
  for (const api::Job& candidate : jobs) {
    if (absl::StartsWith(candidate.id(), id_or_prefix)) ids.push_back(candidate.id());
  }
  if (ids.size() == 1) {
    request.set_job(ids.front());
    return connection.call(request, job);
  }
  CallResult failure;
  failure.status = absl::NotFoundError(
      absl::StrCat("there is no job \"", id_or_prefix, "\", and none whose id begins so"));
  if (ids.empty()) return failure;
  const std::size_t shown = std::min<std::size_t>(ids.size(), 5);
  failure.status = absl::InvalidArgumentError(absl::StrCat(
      "\"", id_or_prefix, "\" begins the ids of ", ids.size(),
      " jobs: ", absl::StrJoin(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(shown), ", "),
      shown < ids.size() ? ", ..." : ""));
  return failure;
}

int find_jobs(Connection& connection, const std::vector<std::string>& ids, std::vector<api::Job>& jobs) {
  int exit_code = kOk;
  for (const std::string& id : ids) {
    CallResult result = find_job(connection, id, jobs.emplace_back());
    if (result.ok()) continue;
    print_failure(result);
    exit_code = exit_code_of(result);
    if (exit_code == kUnreachable) break;
  }
  return exit_code;
}

bool is_final(api::JobState state) {
  return state == api::SUCCEEDED || state == api::FAILED || state == api::CANCELLED;
}

int exit_code_of(api::JobState state) {
  return state == api::FAILED ? kFailed : state == api::CANCELLED ? kCancelled : kOk;
}

std::string state_text(api::JobState state, api::StateReason reason) {
  std::string text = api::JobState_IsValid(state) ? api::JobState_Name(state) : "UNKNOWN";
  const std::string words = words_of(reason);
  return says_nothing(reason) || words.empty() ? text : text + ", " + words;
}

std::string news_in(const std::string& message, api::StateReason reason) {
  return message == words_of(reason) ? "" : message;
}

RunProgress run_progress_of(const api::Job& job) {
  RunProgress shown;
  const api::Progress& progress = job.progress();
  shown.stage = progress.stage().empty() ? "starting" : progress.stage();
  shown.stage_index = progress.stage_index();
  shown.dynamic_stage = progress.dynamic_stage();
  shown.stage_fraction = progress.stage_fraction();
  shown.particle_steps_per_second = progress.particle_steps_per_second();
  if (progress.has_seconds_left()) shown.seconds_left = progress.seconds_left();
  if (job.has_latest_sample()) {
    const api::Sample& sample = job.latest_sample();
    shown.creep_time = sample.creep_time_s();
    shown.axial_strain = sample.axial_strain();
    shown.axial_stress = sample.axial_stress_pa();
    shown.void_ratio = sample.void_ratio();
    shown.grading_index = sample.grading_index();
    shown.broken_total = static_cast<double>(sample.broken_total());
  }
  shown.warnings.assign(job.warnings().begin(), job.warnings().end());
  return shown;
}

bool split_label(const std::string& text, std::string& key, std::string& value) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0) return false;
  key = text.substr(0, equals);
  value = text.substr(equals + 1);
  return true;
}

void set_labels(const std::vector<std::string>& given,
                google::protobuf::Map<std::string, std::string>& labels) {
  for (const std::string& text : given) {
    std::string key, value;
    if (!split_label(text, key, value)) {
      throw CLI::ValidationError("--label", "\"" + text + "\" is not KEY=VALUE");
    }
    if (!labels.insert({key, value}).second) {
      throw CLI::ValidationError("--label", "\"" + key + "\" is given twice");
    }
  }
}

std::string new_request_id() {
  std::random_device device;
  return absl::StrFormat("%08x%08x%08x%08x", device(), device(), device(), device());
}

}  // namespace creepctl
