#include "core/folder/ownership.h"

#include <pwd.h>
#include <sys/stat.h>

#include <cerrno>
#include <deque>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/folder/durable_file.h"

namespace creep {
namespace {

namespace fs = std::filesystem;

constexpr int kMostLinks = 40;  // as the kernel

/// One step of the way: itself, not what it links to.
absl::Status check_step(const fs::path& path, const struct stat& about, const std::set<uid_t>& trusted) {
  if (!trusted.contains(about.st_uid)) {
    return absl::FailedPreconditionError(absl::StrCat(path.string(), " belongs to ", user_name(about.st_uid),
                                                      ", who could exchange what lies there"));
  }
  const bool others_may_write = S_ISDIR(about.st_mode) && (about.st_mode & (S_IWGRP | S_IWOTH)) != 0;
  if (!others_may_write || (about.st_mode & S_ISVTX) != 0) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(
      path.string(), ", of ", user_name(about.st_uid),
      ", can be written by others, who could exchange what lies there: chmod go-w ", path.string()));
}

}  // namespace

std::string user_name(uid_t user) {
  const passwd* const entry = ::getpwuid(user);
  return entry == nullptr ? absl::StrCat("user ", user) : absl::StrCat(entry->pw_name, " (user ", user, ")");
}

absl::Status check_ownership(const fs::path& path, const std::set<uid_t>& trusted) {
  std::deque<fs::path> ahead(path.begin(), path.end());
  fs::path place = "/";
  int links = 0;
  while (!ahead.empty()) {
    const fs::path step = std::move(ahead.front());
    ahead.pop_front();
    if (step.empty() || step == ".") continue;
    if (step == "..") {
      place = place.parent_path();
      continue;
    }
    fs::path next = place / step;  // from the root again where the step is "/"
    struct stat about {};
    if (::lstat(next.c_str(), &about) != 0) {
      return errno == ENOENT ? absl::OkStatus() : errno_status("look at " + next.string(), errno);
    }
    if (auto status = check_step(next, about, trusted); !status.ok()) return status;
    if (!S_ISLNK(about.st_mode)) {
      place = std::move(next);
      continue;
    }
    std::error_code error;
    const fs::path target = fs::read_symlink(next, error);
    if (error || ++links > kMostLinks) {
      return absl::FailedPreconditionError(next.string() + " is a link that leads nowhere");
    }
    ahead.insert(ahead.begin(), target.begin(), target.end());
  }
  return absl::OkStatus();
}

}  // namespace creep
