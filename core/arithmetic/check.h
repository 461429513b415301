// Checks of our own invariants: on in every build, because a wrong state must not become a result.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>

namespace creep::internal {
[[noreturn]] inline void check_failed(const char* file, int line, const char* condition, const char* why) {
  const std::string message =
      std::string(file) + ":" + std::to_string(line) + ": " + condition + ": " + why + "\n";
  std::fputs(message.c_str(), stderr);
  std::abort();
}
}  // namespace creep::internal

/// Aborts with file, line and reason when a bug of ours broke an invariant. Never for bad input.
#define CREEP_CHECK(condition, why)                                                         \
  do {                                                                                      \
    if (!(condition)) ::creep::internal::check_failed(__FILE__, __LINE__, #condition, why); \
  } while (false)
