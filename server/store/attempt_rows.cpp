#include "server/store/attempt_rows.h"

#include <optional>
#include <utility>

namespace creepd {
namespace {

std::optional<std::int64_t> widened(const std::optional<int>& value) {
  return value ? std::optional<std::int64_t>(*value) : std::nullopt;
}

std::optional<int> narrowed(const std::optional<std::int64_t>& value) {
  return value ? std::optional<int>(static_cast<int>(*value)) : std::nullopt;
}

}  // namespace

absl::Status put_attempt(Database& database, std::int64_t job, const Attempt& attempt) {
  Statement row(database, "INSERT OR REPLACE INTO attempt VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?)");
  row.bind(job).bind(attempt.number).bind(attempt.engine).bind(attempt.engine_id);
  row.bind(static_cast<std::int64_t>(attempt.state)).bind(attempt.asked);
  row.bind(attempt.started).bind(attempt.ended).bind(attempt.place);
  row.bind(widened(attempt.process.exit_code)).bind(widened(attempt.process.signal));
  return row.bind(static_cast<std::int64_t>(attempt.cause)).bind(attempt.words).run();
}

absl::StatusOr<std::vector<Attempt>> read_attempts(Database& database, std::int64_t job, std::int64_t first,
                                                   int limit) {
  Statement rows(database,
                 "SELECT number,engine,engine_id,state,asked,started,ended,place,exit_code,signal,cause,"
                 "words FROM attempt WHERE job=? AND number>=? ORDER BY number LIMIT ?");
  rows.bind(job).bind(first).bind(limit);
  std::vector<Attempt> attempts;
  while (rows.step()) {
    Attempt attempt;
    attempt.number = rows.integer();
    attempt.engine = rows.text();
    attempt.engine_id = rows.text();
    attempt.state = static_cast<AttemptState>(rows.integer());
    attempt.asked = rows.integer();
    attempt.started = rows.moment();
    attempt.ended = rows.moment();
    attempt.place = rows.text();
    attempt.process.exit_code = narrowed(rows.moment());
    attempt.process.signal = narrowed(rows.moment());
    attempt.cause = static_cast<Cause>(rows.integer());
    attempt.words = rows.text();
    attempts.push_back(std::move(attempt));
  }
  if (auto status = rows.status(); !status.ok()) return status;
  return attempts;
}

}  // namespace creepd
