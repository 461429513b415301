#include "server/host/state_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/folder/durable_file.h"
#include "core/folder/ownership.h"

namespace creepd {
namespace {

namespace fs = std::filesystem;

// What SQLite can open is shorter than what the kernel can: 512 bytes with the names of its own files.
constexpr std::size_t kLongestPath = 450;

/// A folder of ours: of this user, and written by nobody else, sticky bit or not.
absl::Status check_own(const fs::path& path) {
  struct stat about {};
  if (::stat(path.c_str(), &about) != 0) return creep::errno_status("look at " + path.string(), errno);
  if (about.st_uid != ::geteuid()) {
    return absl::FailedPreconditionError(
        absl::StrCat(path.string(), " belongs to ", creep::user_name(about.st_uid)));
  }
  if ((about.st_mode & (S_IWGRP | S_IWOTH)) == 0) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(path.string(),
                                                    " can be written by others: look at what is",
                                                    " there, then chmod go-w ", path.string()));
}

/// What is there already of STATE and STATE/jobs, and the way to them.
absl::Status check_ours(const fs::path& state) {
  const fs::path jobs = state / "jobs";
  absl::Status status = creep::check_ownership(jobs, {0, ::geteuid()});
  for (const fs::path* folder : {&state, &jobs}) {
    if (status.ok()) status = check_own(*folder);
    if (absl::IsNotFound(status)) return absl::OkStatus();
  }
  if (!absl::IsFailedPrecondition(status)) return status;
  return absl::FailedPreconditionError(
      absl::StrCat("creepd runs as ", creep::user_name(::geteuid()), " and does not use ", state.string(),
                   ": ", std::string(status.message()), "; or give another --state"));
}

/// Makes the names of the folders on the way to `state` durable: without them a power cut takes all of it
/// away.
absl::Status sync_way_to(const fs::path& state) {
  if (auto status = creep::sync_directory(state); !status.ok()) return status;
  for (fs::path above = state; above.has_relative_path();) {
    above = above.parent_path();
    // What this process may not open was not made by it.
    if (!creep::sync_directory(above).ok()) break;
  }
  return absl::OkStatus();
}

/// 0, or why it cannot be locked.
int lock_error(const creep::FileDescriptor& file) {
  return ::flock(file.get(), LOCK_EX | LOCK_NB) == 0 ? 0 : errno;
}

/// A lock on the folder cannot be deleted as the file `lock` can. NFS locks only what is open for writing,
/// which no folder can be: there the file has to do.
absl::Status keep_others_out(const creep::FileDescriptor& folder, const creep::FileDescriptor& lock,
                             const fs::path& path) {
  const int error = lock_error(lock);
  if (error == EWOULDBLOCK || lock_error(folder) == EWOULDBLOCK) {
    return absl::AlreadyExistsError("another creepd uses " + path.string());
  }
  return error == 0 ? absl::OkStatus() : creep::errno_status("lock " + (path / "lock").string(), error);
}

}  // namespace

absl::StatusOr<StateFolder> StateFolder::take(const fs::path& path) {
  if (path.native().size() > kLongestPath) {
    return absl::FailedPreconditionError(absl::StrCat("--state: the path has ", path.native().size(),
                                                      " bytes, of which the database can use ", kLongestPath,
                                                      " at most"));
  }
  // Before anything is made, since it would be made where the links of others lead; and once it is.
  if (auto status = check_ours(path); !status.ok()) return status;
  std::error_code error;
  fs::create_directories(path / "jobs", error);
  if (error)
    return absl::UnavailableError(absl::StrCat("cannot make ", path.string(), ": ", error.message()));
  if (auto status = check_ours(path); !status.ok()) return status;
  if (::chmod(path.c_str(), 0700) != 0) return creep::errno_status("chmod 0700 " + path.string(), errno);
  auto folder = creep::open_file(path, O_RDONLY | O_DIRECTORY);
  if (!folder.ok()) return folder.status();
  auto lock = creep::open_file(path / "lock", O_RDWR | O_CREAT);
  if (!lock.ok()) return lock.status();
  if (auto status = keep_others_out(*folder, *lock, path); !status.ok()) return status;
  if (auto status = sync_way_to(path); !status.ok()) return status;
  return StateFolder(*std::move(folder), *std::move(lock));
}

}  // namespace creepd
