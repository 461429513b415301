#include "client/remote/remote_plan.h"

#include <thread>

#include "absl/strings/str_cat.h"
#include "client/remote/remote_job.h"

namespace creepctl {
namespace {

constexpr auto kBetweenCalls = std::chrono::seconds(1);

creep::Range from_message(const api::Range& range) { return {range.expected(), range.least(), range.most()}; }

RemotePlan from_message(const api::Plan& message) {
  RemotePlan out;
  out.threads = message.threads();
  out.plan.particles = message.particles();
  out.plan.packing_particle_steps = message.packing_particle_steps();
  for (const api::PlannedStage& stage : message.stages()) {
    out.plan.stages.push_back({stage.text(), from_message(stage.dynamic_stages()), stage.cycles(),
                               stage.time_step_s(), stage.particle_steps()});
  }
  out.plan.wall_seconds = from_message(message.wall_seconds());
  out.plan.memory = message.memory_bytes();
  if (message.has_error()) out.plan.error = message.error();
  out.pilot.particles = message.pilot_particles();
  out.pilot.breakages = message.pilot_breakages_per_ageing();
  out.pilot.seconds = message.pilot_wall_seconds();
  out.pilot.speed = message.particle_steps_per_second();
  out.pilot.reason = message.pilot_reason();
  out.pilot.stages.resize(out.plan.stages.size());
  return out;
}

}  // namespace

CallResult plan_remotely(Connection& connection, const std::string& spec,
                         const std::function<void(const std::string&)>& say, RemotePlan& plan) {
  api::PlanJobRequest request;
  request.set_spec(spec);
  request.set_request_id(new_request_id());
  std::string said;
  for (;;) {
    api::PlanJobResponse response;
    if (CallResult result = connection.call(request, response); !result.ok()) return result;
    const api::Job& pilot = response.pilot();
    if (response.has_plan()) {
      plan = from_message(response.plan());
      api::DeleteJobRequest remove;
      remove.set_job(pilot.id());
      api::DeleteJobResponse removed;
      return connection.call(remove, removed);
    }
    const std::string words =
        absl::StrCat("pilot ", pilot.id(), ": ", state_text(pilot.state(), pilot.state_reason()));
    if (words != said) say(words);
    said = words;
    std::this_thread::sleep_for(kBetweenCalls);
  }
}

}  // namespace creepctl
