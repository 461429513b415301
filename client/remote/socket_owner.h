// Whether a socket belongs to whom one would give a job file.
#pragma once

#include <string>

#include "absl/status/status.h"

namespace creepctl {

/// Whether the socket, and the way to it, belong to this user, to root or to `server_user` (name or number,
/// "" = nobody), so that nobody else answers there, also not by exchanging it between this look and the
/// connection. The socket of a package's daemon, /run/creepd/creepd.sock, belongs to whom root gave
/// /run/creepd. No socket there is no fault. Errors: InvalidArgument (no such user), PermissionDenied (who
/// could answer, and the cure).
absl::Status check_socket_owner(const std::string& path, const std::string& server_user);

}  // namespace creepctl
