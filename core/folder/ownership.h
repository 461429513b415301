// Who could exchange what a path leads to.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <set>
#include <string>

#include "absl/status/status.h"

namespace creep {

/// "alice (user 1000)"
std::string user_name(uid_t user);

/// Whether nobody but the trusted users can change what the absolute path leads to: each folder and each link
/// on the way, links followed one by one, and what is at its end belong to one of them, and no folder can be
/// written by others unless its sticky bit keeps what is in it to its owner. What is not there yet is no
/// fault. Error: FailedPrecondition, which names the place, its owner and why that is not good, without a
/// full stop; or of the file system.
absl::Status check_ownership(const std::filesystem::path& path, const std::set<uid_t>& trusted);

}  // namespace creep
