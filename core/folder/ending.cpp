#include "core/folder/ending.h"

#include <nlohmann/json.hpp>

#include "core/folder/durable_file.h"

namespace creep {

Ending ending_of(const Outcome& outcome) {
  switch (outcome.kind) {
    case Outcome::Kind::kCompleted:
      return {kDone, "completed", outcome.reason, outcome.advice};
    case Outcome::Kind::kCreepFailure:
      return {kDone, "creep_failure", outcome.reason, outcome.advice};
    case Outcome::Kind::kGuardStop:
      break;
  }
  return {kRefused, "guard_stop", outcome.reason, outcome.advice};
}

Ending ending_of(const absl::Status& status) {
  const std::string reason(status.message());
  switch (status.code()) {
    case absl::StatusCode::kInvalidArgument:
      return {kBadInput, "bad_input", reason, ""};
    case absl::StatusCode::kFailedPrecondition:
      return {kRefused, "refused", reason,
              "Continue with the program, the machine and the job file that computed it so far."};
    case absl::StatusCode::kAborted:
      return {kRefused, "refused", reason,
              "Continue on the machine and build that began the job, or with --allow-inexact, which is "
              "recorded."};
    case absl::StatusCode::kResourceExhausted:
      return {kIoError, "io_error", reason, "Make room and run the same command again: it continues."};
    default:
      return {kIoError, "io_error", reason,
              "The last good checkpoint stands. Check the storage, then run again."};
  }
}

absl::Status write_verdict(const std::filesystem::path& path, const Ending& ending, std::int64_t attempt) {
  const nlohmann::ordered_json verdict = {{"attempt", attempt},
                                          {"exit_code", ending.exit_code},
                                          {"outcome", ending.outcome},
                                          {"reason", ending.reason},
                                          {"advice", ending.advice}};
  return write_durably(path, verdict.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

std::optional<Ending> read_verdict(const std::filesystem::path& path) {
  const auto text = read_file(path, 1 << 20);
  if (!text.ok()) return std::nullopt;
  const auto verdict = nlohmann::json::parse(*text, nullptr, false);
  if (!verdict.is_object() || !verdict.contains("exit_code") || !verdict["exit_code"].is_number_integer()) {
    return std::nullopt;
  }
  const auto word = [&](const char* key) {
    const auto found = verdict.find(key);
    return found != verdict.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  return Ending{verdict["exit_code"].get<int>(), word("outcome"), word("reason"), word("advice")};
}

}  // namespace creep
