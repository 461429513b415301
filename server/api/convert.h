// Between the daemon's values and the messages of creep.proto. Protocol buffers, no gRPC.
#pragma once

#include <string>

#include "core/output/record.h"
#include "creep/v1/creep.pb.h"
#include "server/folders/job_files.h"
#include "server/jobs/job_plan.h"
#include "server/rules/attempt.h"
#include "server/rules/job.h"

namespace creepd {

void to_message(const Job& job, creep::v1::Job& message);
void to_message(const StateEvent& event, creep::v1::StateChange& message);
void to_message(const Attempt& attempt, creep::v1::Attempt& message);
void to_message(const Artifact& artifact, creep::v1::Artifact& message);

/// All but `threads`.
void to_message(const JobPlan& plan, creep::v1::Plan& message);

/// Each column of a sample goes to the field of its name in small letters.
void to_message(const creep::Record& sample, std::uint64_t index, creep::v1::Sample& message);

/// progress.json; nothing for an empty or broken text. False if nothing was set.
bool to_message(const std::string& progress_json, creep::v1::Progress& message);

}  // namespace creepd
