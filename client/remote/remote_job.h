// A job of the daemon as the commands name, find and describe it.
#pragma once

#include <string>
#include <vector>

#include "client/remote/connection.h"
#include "client/terminal/run_progress.h"

namespace creepctl {

/// The job with this id, or the only one whose id begins so. Further errors: NotFound (none), and
/// InvalidArgument (several; the message names them).
CallResult find_job(Connection& connection, const std::string& id_or_prefix, api::Job& job);

/// find_job() for each, all or nothing; prints what is wrong. An exit code, kOk if all were found.
int find_jobs(Connection& connection, const std::vector<std::string>& ids, std::vector<api::Job>& jobs);

/// Every job that the request selects, page after page, at most `limit` (0: all), newest first.
CallResult list_jobs(Connection& connection, api::ListJobsRequest request, std::size_t limit,
                     std::vector<api::Job>& jobs);

/// Every attempt of a job, from the first.
CallResult list_attempts(Connection& connection, const std::string& id, std::vector<api::Attempt>& attempts);

bool is_final(api::JobState state);

/// What a final state means for scripts (exit_codes.h).
int exit_code_of(api::JobState state);

/// "RUNNING", "PAUSED, disk full", "FAILED, guard stop"
std::string state_text(api::JobState state, api::StateReason reason);

/// The message, or "" if it only repeats the reason in small letters.
std::string news_in(const std::string& message, api::StateReason reason);

/// Figures of the sample with the guesses of the progress, as the live line takes them.
RunProgress run_progress_of(const api::Job& job);

/// "k=v"; false if there is no '=' or no key.
bool split_label(const std::string& text, std::string& key, std::string& value);

/// Fills the labels of a request from --label options; CLI::ValidationError on a bad one.
void set_labels(const std::vector<std::string>& given,
                google::protobuf::Map<std::string, std::string>& labels);

/// A new random identifier for a request that may be repeated.
std::string new_request_id();

}  // namespace creepctl
