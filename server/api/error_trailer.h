// How an error leaves: every text that came from outside passes here, and is cut to what a trailer can carry.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace creepd {

/// The text, or its beginning and "..." if it has more than `most` bytes. Cuts no UTF-8 letter.
std::string shortened(std::string_view text, std::size_t most);

/// What gRPC tells beside the details: valid UTF-8, bounded.
std::string error_message(const absl::Status& status);

/// creep.v1.details.Status with ErrorInfo, BadRequest and RetryInfo, serialized for the trailer. Violations
/// are told in order until there is no more room; then how many are left out.
std::string error_details(const absl::Status& status);

}  // namespace creepd
