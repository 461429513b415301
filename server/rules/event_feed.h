// The numbered events of a job: its changes of state and its samples, merged into one sequence without gap.
//
// A change of state remembers how many samples were told before it. So with changes c = 0, 1, ... and samples
// i = 0, 1, ...
//   seq of change c = samples before it + c + 1
//   seq of sample i = i + (changes with samples_before <= i) + 1
// and both are the same whoever asks, and after any restart. Both counts are durable before anything is told.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "server/rules/job.h"

namespace creepd {

struct FeedStep {
  std::uint64_t seq = 0;
  std::uint64_t skipped = 0;            ///< events left out since after_seq
  std::optional<std::size_t> change;    ///< place among the changes, or
  std::optional<std::uint64_t> sample;  ///< index of the sample
};

/// A reader that is more than this many samples behind gets the newest: one that wants every sample ...
inline constexpr std::uint64_t kMostBacklog = 1000;
/// ... and one that looks on.
inline constexpr std::uint64_t kMostLiveBacklog = 1;

/// The event to send after `after_seq`; nothing if there is none yet. `changes` in order; `samples` were
/// told; `readable` of them are in the log now (fewer after a power cut, until they are computed again).
/// Changes are never left out, samples may be.
std::optional<FeedStep> next_event(std::span<const StateEvent> changes, std::uint64_t samples,
                                   std::uint64_t readable, std::uint64_t after_seq,
                                   std::uint64_t most_backlog = kMostBacklog);

}  // namespace creepd
