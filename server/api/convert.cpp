#include "server/api/convert.h"

#include <array>
#include <limits>
#include <vector>

#include <nlohmann/json.hpp>

#include "absl/strings/ascii.h"
#include "core/arithmetic/check.h"

namespace creepd {
namespace {

namespace v1 = creep::v1;
using google::protobuf::FieldDescriptor;

void set_moment(Moment moment, google::protobuf::Timestamp& message) {
  message.set_seconds(moment / 1'000'000);
  message.set_nanos(static_cast<std::int32_t>(moment % 1'000'000 * 1000));
}

std::vector<const FieldDescriptor*> sample_fields() {
  std::vector<const FieldDescriptor*> fields;
  for (const creep::Column& column : creep::columns(creep::RecordKind::kSample)) {
    const std::string name = absl::AsciiStrToLower(std::string(column.name));
    fields.push_back(v1::Sample::descriptor()->FindFieldByName(name));
    CREEP_CHECK(fields.back() != nullptr, "creep.proto has a field for each column of a sample");
  }
  return fields;
}

/// What a file of a job says, as a whole number: any double is possible there.
template <class Integer>
Integer whole(double value) {
  constexpr auto kLeast = static_cast<double>(std::numeric_limits<Integer>::min());
  if (!(value > kLeast)) return value <= kLeast ? std::numeric_limits<Integer>::min() : Integer{0};
  return value < -kLeast ? static_cast<Integer>(value) : std::numeric_limits<Integer>::max();
}

void to_message(const creep::Range& range, v1::Range& message) {
  message.set_expected(range.expected);
  message.set_least(range.least);
  message.set_most(range.most);
}

}  // namespace

void to_message(const JobPlan& plan, v1::Plan& message) {
  message.set_particles(plan.plan.particles);
  message.set_packing_particle_steps(plan.plan.packing_particle_steps);
  for (const creep::PlannedStage& stage : plan.plan.stages) {
    v1::PlannedStage& added = *message.add_stages();
    added.set_text(stage.text);
    if (stage.dynamic_stages.expected > 0.0)
      to_message(stage.dynamic_stages, *added.mutable_dynamic_stages());
    added.set_cycles(stage.cycles);
    added.set_time_step_s(stage.time_step);
    added.set_particle_steps(stage.particle_steps);
  }
  to_message(plan.plan.wall_seconds, *message.mutable_wall_seconds());
  message.set_memory_bytes(plan.plan.memory);
  if (plan.plan.error) message.set_error(*plan.plan.error);
  message.set_pilot_particles(plan.pilot.particles);
  message.set_pilot_breakages_per_ageing(plan.pilot.breakages);
  message.set_pilot_wall_seconds(plan.pilot.seconds);
  message.set_particle_steps_per_second(plan.pilot.speed);
  message.set_pilot_reason(plan.pilot.reason);
}

void to_message(const creep::Record& sample, std::uint64_t index, v1::Sample& message) {
  static const std::vector<const FieldDescriptor*> kFields = sample_fields();
  message.set_index(index);
  message.set_sequence(sample.sequence);
  for (std::size_t i = 0; i < kFields.size(); ++i) {
    const double value = sample.values[i];
    switch (kFields[i]->cpp_type()) {
      case FieldDescriptor::CPPTYPE_DOUBLE:
        v1::Sample::GetReflection()->SetDouble(&message, kFields[i], value);
        break;
      case FieldDescriptor::CPPTYPE_ENUM:
        v1::Sample::GetReflection()->SetEnumValue(&message, kFields[i], whole<std::int32_t>(value));
        break;
      default:
        v1::Sample::GetReflection()->SetInt64(&message, kFields[i], whole<std::int64_t>(value));
    }
  }
}

bool to_message(const std::string& progress_json, v1::Progress& message) {
  const auto json = nlohmann::json::parse(progress_json, nullptr, false);
  if (!json.is_object()) return false;
  const auto number = [&](const nlohmann::json& from, const char* key) {
    const auto found = from.find(key);
    return found != from.end() && found->is_number() ? found->get<double>() : 0.0;
  };
  const auto stage = json.find("stage");
  if (stage != json.end() && stage->is_string()) message.set_stage(stage->get<std::string>());
  message.set_stage_index(whole<std::int32_t>(number(json, "stage_index")));
  message.set_stage_count(whole<std::int32_t>(number(json, "stage_count")));
  message.set_stage_fraction(number(json, "stage_fraction"));
  message.set_dynamic_stage(whole<std::int64_t>(number(json, "dynamic_stage")));
  message.set_wall_seconds(number(json, "wall_seconds"));
  const auto speed = json.find("particle_steps_per_second");
  if (speed != json.end() && speed->is_object())
    message.set_particle_steps_per_second(number(*speed, "recent"));
  const auto left = json.find("seconds_left");
  if (left != json.end() && left->is_number()) message.set_seconds_left(left->get<double>());
  return true;
}

void to_message(const Job& job, v1::Job& message) {
  message.set_id(job.id);
  message.set_name(job.name);
  message.set_state(static_cast<v1::JobState>(job.state));
  message.set_state_reason(static_cast<v1::StateReason>(job.reason));
  message.set_state_message(job.message);
  message.set_log_tail(job.log_tail);
  message.set_priority(job.priority);
  for (const auto& [key, value] : job.labels) (*message.mutable_labels())[key] = value;
  message.set_owner(job.owner);
  set_moment(job.submitted, *message.mutable_submit_time());
  if (job.started) set_moment(*job.started, *message.mutable_start_time());
  if (job.ended) set_moment(*job.ended, *message.mutable_end_time());
  message.set_attempts(job.attempts);
  message.set_parent_job(job.parent);
  message.set_parent_generation(job.parent_generation);
  message.set_experiment_hash(job.experiment_hash);
  message.set_state_digest(job.state_digest);
  message.set_memory_estimate_bytes(job.memory_estimate);
  message.set_last_seq(job.last_seq());
  const auto sample = creep::decode(job.latest_sample);
  if (sample.ok() && sample->kind == creep::RecordKind::kSample)
    to_message(*sample, job.samples - 1, *message.mutable_latest_sample());
  if (!to_message(job.progress, *message.mutable_progress())) message.clear_progress();
  message.set_spec(job.spec);
  for (const std::string& warning : job.warnings) message.add_warnings(warning);
  const auto progress = nlohmann::json::parse(job.progress, nullptr, false);
  if (!progress.is_object() || !progress.contains("warnings") || !progress["warnings"].is_array()) return;
  for (const auto& warning : progress["warnings"]) {
    if (warning.is_string()) message.add_warnings(warning.get<std::string>());
  }
}

void to_message(const StateEvent& event, v1::StateChange& message) {
  message.set_state(static_cast<v1::JobState>(event.state));
  message.set_state_reason(static_cast<v1::StateReason>(event.reason));
  message.set_message(event.message);
  message.set_attempt(event.attempt);
  set_moment(event.moment, *message.mutable_change_time());
}

void to_message(const Attempt& attempt, v1::Attempt& message) {
  message.set_number(attempt.number);
  message.set_engine(attempt.engine);
  message.set_engine_id(attempt.engine_id);
  message.set_state(static_cast<v1::AttemptState>(attempt.state));
  set_moment(attempt.asked, *message.mutable_ask_time());
  if (attempt.started) set_moment(*attempt.started, *message.mutable_start_time());
  if (attempt.ended) set_moment(*attempt.ended, *message.mutable_end_time());
  message.set_place(attempt.place);
  if (attempt.process.exit_code) message.set_exit_code(*attempt.process.exit_code);
  if (attempt.process.signal) message.set_signal(*attempt.process.signal);
  message.set_cause(static_cast<v1::AttemptCause>(attempt.cause));
  message.set_message(attempt.words);
}

void to_message(const Artifact& artifact, v1::Artifact& message) {
  message.set_name(artifact.name);
  message.set_size_bytes(artifact.size);
  set_moment(artifact.modified, *message.mutable_modify_time());
  message.set_etag(artifact.etag);
}

}  // namespace creepd
