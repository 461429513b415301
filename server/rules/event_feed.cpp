#include "server/rules/event_feed.h"

#include <algorithm>

namespace creepd {

std::optional<FeedStep> next_event(std::span<const StateEvent> changes, std::uint64_t samples,
                                   std::uint64_t readable, std::uint64_t after_seq,
                                   std::uint64_t most_backlog) {
  // The first change not seen: change c has seq samples_before + c + 1, which rises with c.
  std::size_t change = 0;
  std::size_t end = changes.size();
  while (change < end) {
    const std::size_t middle = change + (end - change) / 2;
    if (changes[middle].samples_before + middle + 1 <= after_seq) {
      change = middle + 1;
    } else {
      end = middle;
    }
  }
  // All changes before it were seen, and the rest of what was seen are samples.
  const std::uint64_t limit = change < changes.size() ? changes[change].samples_before : samples;
  std::uint64_t sample = after_seq - std::min<std::uint64_t>(after_seq, change);
  if (samples > sample + most_backlog) sample = samples - 1;
  if (sample < std::min(limit, readable)) {
    const std::uint64_t seq = sample + change + 1;
    return FeedStep{seq, seq - after_seq - 1, std::nullopt, sample};
  }
  if (change == changes.size()) return std::nullopt;
  const std::uint64_t seq = changes[change].samples_before + change + 1;
  return FeedStep{seq, seq - after_seq - 1, change, std::nullopt};
}

}  // namespace creepd
