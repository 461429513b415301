// Checks of our own invariants: on in every build, because a wrong state must not become a result.
#pragma once

#include <cstdio>
#include <cstdlib>

namespace creep::internal {
[[noreturn]] inline void check_failed(const char* file, int line, const char* condition, const char* why) {
  std::fputs(file, stderr);
  char number[16];
  std::snprintf(number, sizeof number, ":%d: ", line);
  std::fputs(number, stderr);
  std::fputs(condition, stderr);
  std::fputs(": ", stderr);
  std::fputs(why, stderr);
  std::fputs("\n", stderr);
  std::abort();
}
}  // namespace creep::internal

/// Aborts with file, line and reason when a bug of ours broke an invariant. Never for bad input.
#define CREEP_CHECK(condition, why)                                                       \
  do {                                                                                    \
    if (!(condition)) ::creep::internal::check_failed(__FILE__, __LINE__, #condition, why); \
  } while (false)
