// What pause, resume and cancel have in common.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include "client/remote/connection.h"
#include "client/remote/remote_job.h"
#include "client/terminal/exit_codes.h"

namespace creepctl {

/// Sends the request for each job and prints the state that it leads to. If one of the ids is unknown,
/// nothing is sent. An exit code: of the last call that failed.
template <typename Request>
int change_jobs(const ServerOptions& server, const std::vector<std::string>& ids, Request request) {
  return with_connection(server, [&](Connection& connection) {
    std::vector<api::Job> jobs;
    int exit_code = find_jobs(connection, ids, jobs);
    if (exit_code != kOk) return exit_code;
    for (api::Job& job : jobs) {
      request.set_job(job.id());
      const CallResult result = connection.call(request, job);
      if (result.ok()) {
        std::printf("%s: %s\n", job.id().c_str(), state_text(job.state(), job.state_reason()).c_str());
      } else {
        print_failure(result);
        exit_code = exit_code_of(result);
      }
    }
    return exit_code;
  });
}

}  // namespace creepctl
