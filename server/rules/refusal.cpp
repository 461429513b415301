#include "server/rules/refusal.h"

#include <nlohmann/json.hpp>

#include "absl/strings/cord.h"

namespace creepd {
namespace {

constexpr const char* kPayload = "creepd/refusal";

}  // namespace

absl::Status refuse(absl::StatusCode code, std::string_view message, const Refusal& refusal) {
  nlohmann::json json = {{"reason", refusal.reason}, {"facts", refusal.facts}};
  json["violations"] = nlohmann::json::array();
  for (const Violation& violation : refusal.violations) {
    json["violations"].push_back({violation.field, violation.description, violation.line, violation.column});
  }
  json["left_out"] = refusal.left_out;
  if (refusal.retry_seconds) json["retry"] = *refusal.retry_seconds;
  absl::Status status(code, std::string(message));
  status.SetPayload(kPayload,
                    absl::Cord(json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)));
  return status;
}

absl::Status job_not_found(std::string_view id) {
  const std::string name(id);
  return refuse(absl::StatusCode::kNotFound, "there is no job \"" + name + "\"",
                {"JOB_NOT_FOUND", {{"job", name}}, {}, {}});
}

absl::Status bad_request(std::vector<Violation> violations) {
  const std::string& field = violations.front().field;
  const std::string message = (field.empty() ? "" : field + ": ") + violations.front().description;
  return refuse(absl::StatusCode::kInvalidArgument, message, {"BAD_REQUEST", {}, std::move(violations), {}});
}

Refusal refusal_of(const absl::Status& status) {
  Refusal refusal;
  const auto payload = status.GetPayload(kPayload);
  if (!payload) return refusal;
  const auto json = nlohmann::json::parse(std::string(*payload));
  refusal.reason = json["reason"].get<std::string>();
  refusal.facts = json["facts"].get<std::vector<std::pair<std::string, std::string>>>();
  for (const auto& violation : json["violations"]) {
    refusal.violations.push_back({violation[0].get<std::string>(), violation[1].get<std::string>(),
                                  violation[2].get<int>(), violation[3].get<int>()});
  }
  refusal.left_out = json["left_out"].get<std::size_t>();
  if (json.contains("retry")) refusal.retry_seconds = json["retry"].get<int>();
  return refusal;
}

}  // namespace creepd
