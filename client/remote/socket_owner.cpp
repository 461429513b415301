#include "client/remote/socket_owner.h"

#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <charconv>
#include <set>
#include <system_error>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "core/folder/ownership.h"

namespace creepctl {
namespace {

// Only root can make it: it is the service manager's, made for the user that runs the daemon.
constexpr const char* kServiceFolder = "/run/creepd";

absl::StatusOr<uid_t> user_number(const std::string& name) {
  uid_t number = 0;
  const char* const end = name.data() + name.size();
  const auto parsed = std::from_chars(name.data(), end, number);
  if (parsed.ec == std::errc() && parsed.ptr == end) return number;
  if (const passwd* const entry = ::getpwnam(name.c_str())) return entry->pw_uid;
  return absl::InvalidArgumentError(absl::StrCat("--server-user: there is no user ", name));
}

}  // namespace

absl::Status check_socket_owner(const std::string& path, const std::string& server_user) {
  std::set<uid_t> trusted = {0, ::geteuid()};
  if (!server_user.empty()) {
    const auto user = user_number(server_user);
    if (!user.ok()) return user.status();
    trusted.insert(*user);
  }
  struct stat service {};
  if (path == absl::StrCat(kServiceFolder, "/creepd.sock") && ::lstat(kServiceFolder, &service) == 0) {
    trusted.insert(service.st_uid);
  }
  const absl::Status status = creep::check_ownership(path, trusted);
  if (!absl::IsFailedPrecondition(status)) return absl::OkStatus();  // that it cannot be used is told later
  return absl::PermissionDeniedError(absl::StrCat(
      std::string(status.message()), ". Nothing was sent there; if that user runs your daemon, say so: ",
      "--server-user NAME or CREEPCTL_SERVER_USER"));
}

}  // namespace creepctl
