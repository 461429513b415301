#include "core/folder/lease.h"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <cstdio>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "core/folder/durable_file.h"

namespace creep {
namespace {

struct Holder {
  long long attempt = 0;  ///< 0 in a file just made
  long long process = 0;
};

Holder read_holder(int file) {
  char text[64] = {};
  Holder holder;
  if (::pread(file, text, sizeof text - 1, 0) > 0 &&
      std::sscanf(text, "attempt %lld process %lld", &holder.attempt, &holder.process) < 1) {
    holder.attempt = 0;
  }
  return holder;
}

}  // namespace

absl::StatusOr<Lease> Lease::take(const std::filesystem::path& path,
                                  std::optional<std::int64_t> wanted_attempt) {
  auto file = open_file(path, O_RDWR | O_CREAT);
  if (!file.ok()) return file.status();
  if (::flock(file->get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return errno_status(absl::StrCat("lock ", path.string()), errno);
    const Holder holder = read_holder(file->get());
    return absl::UnavailableError(absl::StrCat(path.parent_path().string(),
                                               " is in use by another worker (attempt ", holder.attempt,
                                               ", process ", holder.process, ")"));
  }
  const Holder last = read_holder(file->get());
  const std::int64_t attempt = wanted_attempt.value_or(last.attempt + 1);
  if (attempt < last.attempt) {
    return absl::FailedPreconditionError(
        absl::StrCat("attempt ", attempt, " is late: attempt ", last.attempt, " was made already"));
  }
  // Of constant length and written in place: a full disk cannot take the number away.
  char text[64];
  const int length = std::snprintf(text, sizeof text, "attempt %010lld process %010lld\n",
                                   static_cast<long long>(attempt), static_cast<long long>(::getpid()));
  if (::pwrite(file->get(), text, static_cast<std::size_t>(length), 0) != length ||
      ::fsync(file->get()) != 0) {
    return errno_status(absl::StrCat("write ", path.string()), errno);
  }
  return Lease(*std::move(file), attempt);
}

}  // namespace creep
