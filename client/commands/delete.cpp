#include "client/commands/commands.h"

#include <chrono>
#include <cstdio>
#include <memory>

#include "client/remote/connection.h"
#include "client/remote/remote_job.h"
#include "client/terminal/exit_codes.h"
#include "core/experiment/units.h"

namespace creepctl {
namespace {

constexpr int kMostInCall = 1000;  // creep.proto

struct Options {
  ServerOptions server;
  std::vector<std::string> ids;
  bool all_final = false;
  std::string older_than;    // with its unit
  double least_age_s = 0.0;  // from it
};

/// A call a job: of a daemon that knows no DeleteJobs.
int delete_one_by_one(Connection& connection, const std::vector<std::string>& ids) {
  int exit_code = kOk;
  for (const std::string& id : ids) {
    api::DeleteJobRequest request;
    request.set_job(id);
    api::DeleteJobResponse response;
    const CallResult result = connection.call(request, response);
    // Not there any more: an earlier call did it whose answer was lost.
    if (result.ok() || absl::IsNotFound(result.status)) {
      std::printf("%s: deleted\n", id.c_str());
    } else {
      print_failure(result);
      exit_code = exit_code_of(result);
    }
  }
  return exit_code;
}

int delete_ids(Connection& connection, const std::vector<std::string>& ids) {
  int exit_code = kOk;
  for (std::size_t begin = 0; begin < ids.size(); begin += kMostInCall) {
    api::DeleteJobsRequest request;
    for (std::size_t i = begin; i < std::min(ids.size(), begin + kMostInCall); ++i) request.add_jobs(ids[i]);
    api::DeleteJobsResponse response;
    const CallResult result = connection.call(request, response);
    if (absl::IsUnimplemented(result.status)) return delete_one_by_one(connection, ids);
    if (!result.ok()) {
      print_failure(result);
      return exit_code_of(result);
    }
    for (const auto& deletion : response.deletions()) {
      if (deletion.deleted() || deletion.reason() == "JOB_NOT_FOUND") {
        std::printf("%s: deleted\n", deletion.job().c_str());
      } else {
        std::fprintf(stderr, "creepctl: %s\n", deletion.message().c_str());
        exit_code = deletion.reason() == "STORAGE_FAILED" ? kUnreachable : kFailed;
      }
    }
  }
  return exit_code;
}

CallResult find_final(const Options& options, Connection& connection, std::vector<std::string>& ids) {
  const double now =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  api::ListJobsRequest request;
  for (const api::JobState state : {api::SUCCEEDED, api::FAILED, api::CANCELLED}) request.add_states(state);
  std::vector<api::Job> jobs;
  const CallResult result = list_jobs(connection, request, 0, jobs);
  for (const api::Job& job : jobs) {
    if (now - static_cast<double>(job.end_time().seconds()) >= options.least_age_s) ids.push_back(job.id());
  }
  return result;
}

int delete_jobs(const Options& options, Connection& connection) {
  std::vector<std::string> ids;
  if (options.all_final) {
    if (const CallResult result = find_final(options, connection, ids); !result.ok()) {
      print_failure(result);
      return exit_code_of(result);
    }
    if (ids.empty()) std::fprintf(stderr, "no jobs\n");
  } else {
    std::vector<api::Job> jobs;
    if (const int exit_code = find_jobs(connection, options.ids, jobs); exit_code != kOk) return exit_code;
    for (const api::Job& job : jobs) ids.push_back(job.id());
  }
  return delete_ids(connection, ids);
}

void check(Options& options) {
  if (options.all_final != options.ids.empty())
    throw CLI::ValidationError("IDS", "give either ids or --all-final");
  if (options.older_than.empty()) return;
  const auto seconds = creep::parse_quantity(options.older_than, creep::Dimension::kDuration);
  if (!seconds.ok()) throw CLI::ValidationError("--older-than", std::string(seconds.status().message()));
  options.least_age_s = *seconds;
}

}  // namespace

void add_delete(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("delete", "Removes ended or paused jobs and all their files");
  auto options = std::make_shared<Options>();
  command->add_option("IDS", options->ids, "The jobs, or the beginnings of their ids");
  auto* all = command->add_flag("--all-final", options->all_final,
                                "All that succeeded, failed or were cancelled: yours, or everybody's if you "
                                "are root or the user of the daemon");
  command
      ->add_option("--older-than", options->older_than,
                   "With --all-final: only those that ended so long ago, e.g. \"90 d\"")
      ->needs(all);
  add_server_options(*command, options->server);
  command->footer(
      "Cannot be undone. If one of the ids is unknown, nothing is deleted.\n\n"
      "Example:\n  creepctl delete 3f2a 7c01\n  creepctl delete --all-final --older-than \"90 d\"");
  command->callback([options, &exit_code] {
    check(*options);
    exit_code = with_connection(options->server,
                                [&](Connection& connection) { return delete_jobs(*options, connection); });
  });
}

}  // namespace creepctl
