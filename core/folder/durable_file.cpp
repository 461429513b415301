#include "core/folder/durable_file.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>

#include "absl/strings/str_cat.h"

namespace creep {
namespace {

absl::Status write_temporary(const std::filesystem::path& path, std::string_view bytes, bool durable) {
  auto file = open_file(path, O_WRONLY | O_CREAT | O_TRUNC);
  if (!file.ok()) return file.status();
  if (auto written = write_all(file->get(), bytes, path); !written.ok()) return written;
  if (durable && ::fsync(file->get()) != 0) return errno_status(absl::StrCat("fsync ", path.string()), errno);
  if (file->close() != 0) return errno_status(absl::StrCat("close ", path.string()), errno);
  return absl::OkStatus();
}

absl::Status write_and_rename(const std::filesystem::path& path, std::string_view bytes, bool durable) {
  std::filesystem::path temporary = path;
  temporary += ".tmp";
  absl::Status status = write_temporary(temporary, bytes, durable);
  if (status.ok() && ::rename(temporary.c_str(), path.c_str()) != 0) {
    status = errno_status(absl::StrCat("rename ", temporary.string()), errno);
  }
  if (!status.ok()) {
    ::unlink(temporary.c_str());
    return status;
  }
  return durable ? sync_directory(path.parent_path()) : absl::OkStatus();
}

}  // namespace

absl::Status errno_status(std::string_view what, int error_number) {
  const std::string message = absl::StrCat(std::string(what), ": ", std::strerror(error_number));
  switch (error_number) {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      return absl::ResourceExhaustedError(message);
    case ENOENT:
    case ENOTDIR:
      return absl::NotFoundError(message);
    case EACCES:
    case EPERM:
    case EROFS:
      return absl::PermissionDeniedError(message);
    default:
      return absl::DataLossError(message);
  }
}

absl::StatusOr<FileDescriptor> open_file(const std::filesystem::path& path, int flags) {
  const bool writes = (flags & (O_WRONLY | O_RDWR | O_CREAT)) != 0;
  FileDescriptor file(::open(path.c_str(), flags | O_CLOEXEC | (writes ? O_NOFOLLOW : 0), 0644));
  if (!file.open() && writes && errno == ELOOP)
    return absl::PermissionDeniedError(
        absl::StrCat("open ", path.string(), ": it is a link, and would lead to another file"));
  if (!file.open()) return errno_status(absl::StrCat("open ", path.string()), errno);
  return file;
}

absl::Status write_all(int descriptor, std::string_view bytes, const std::filesystem::path& path) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno_status(absl::StrCat("write ", path.string()), errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> read_file(const std::filesystem::path& path, std::uint64_t most_bytes) {
  const auto file = open_file(path, O_RDONLY);
  if (!file.ok()) return file.status();
  struct stat about {};
  if (::fstat(file->get(), &about) != 0) return errno_status(absl::StrCat("stat ", path.string()), errno);
  if (!S_ISREG(about.st_mode))
    return absl::DataLossError(absl::StrCat(path.string(), ": not a regular file"));
  const auto size = static_cast<std::uint64_t>(about.st_size);
  if (size > most_bytes) {
    return absl::DataLossError(
        absl::StrCat(path.string(), ": ", size, " bytes where at most ", most_bytes, " belong"));
  }
  std::string bytes(size, '\0');
  std::size_t have = 0;
  while (have < bytes.size()) {
    const ssize_t got = ::read(file->get(), bytes.data() + have, bytes.size() - have);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return errno_status(absl::StrCat("read ", path.string()), errno);
    if (got == 0) break;
    have += static_cast<std::size_t>(got);
  }
  bytes.resize(have);
  return bytes;
}

absl::Status write_durably(const std::filesystem::path& path, std::string_view bytes) {
  return write_and_rename(path, bytes, true);
}

absl::Status replace_file(const std::filesystem::path& path, std::string_view bytes) {
  return write_and_rename(path, bytes, false);
}

absl::Status sync_directory(const std::filesystem::path& directory) {
  const auto file = open_file(directory.empty() ? "." : directory, O_RDONLY | O_DIRECTORY);
  if (!file.ok()) return file.status();
  if (::fsync(file->get()) != 0) return errno_status(absl::StrCat("fsync ", directory.string()), errno);
  return absl::OkStatus();
}

}  // namespace creep
