#include "client/local/run_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace creepctl {
namespace {

constexpr const char* kJobFile = "job.toml";
constexpr const char* kTemporaryJobFile = "job.toml.tmp";

absl::Status cannot(const std::string& what, const std::filesystem::path& path, int error_number) {
  return absl::UnavailableError(
      absl::StrCat("cannot ", what, " ", path.string(), ": ", std::strerror(error_number)));
}

bool is_finished(const std::filesystem::path& folder) {
  const auto verdict = nlohmann::json::parse(read_text(folder / "verdict.json"), nullptr, false);
  return verdict.is_object() && verdict.value("exit_code", nlohmann::json()) == 0;
}

absl::Status sync_folder(const std::filesystem::path& folder) {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return cannot("open", folder, errno);
  const int result = ::fsync(file);
  const int error_number = errno;
  ::close(file);
  return result == 0 ? absl::OkStatus() : cannot("write", folder, error_number);
}

absl::Status write_durably(const std::filesystem::path& path, std::string_view text) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file < 0) return cannot("write", path, errno);
  const ssize_t written = ::write(file, text.data(), text.size());
  const bool whole = written == static_cast<ssize_t>(text.size()) && ::fsync(file) == 0;
  // A short write without an error is a disk that became full.
  const int error_number = written >= 0 && written < static_cast<ssize_t>(text.size()) ? ENOSPC : errno;
  ::close(file);
  return whole ? absl::OkStatus() : cannot("write", path, error_number);
}

}  // namespace

std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
}

std::string last_lines(std::string_view text, int count) {
  std::size_t start = text.size();
  if (start > 0 && text[start - 1] == '\n') --start;
  while (start > 0 && (text[start - 1] != '\n' || --count > 0)) --start;
  return std::string(text.substr(start));
}

absl::StatusOr<RunFolderState> look_at_run_folder(const std::filesystem::path& folder,
                                                  std::string_view job_text, const std::string& job_path) {
  std::error_code error;
  const auto status = std::filesystem::status(folder, error);
  if (status.type() == std::filesystem::file_type::not_found) return RunFolderState::kNew;
  if (error) return cannot("read", folder, error.value());
  if (status.type() != std::filesystem::file_type::directory) {
    return absl::FailedPreconditionError(absl::StrCat(folder.string(), " is not a directory"));
  }
  const auto job_file = folder / kJobFile;
  if (std::filesystem::exists(job_file, error)) {
    if (read_text(job_file) == job_text) {
      return is_finished(folder) ? RunFolderState::kFinished : RunFolderState::kUnfinished;
    }
    return absl::FailedPreconditionError(absl::StrCat(
        folder.string(), " holds the run of another job file: ", job_file.string(), " differs from ",
        job_path, "; give another --out, or run ", job_file.string(), " to continue the one there"));
  }
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path().filename() == kTemporaryJobFile) continue;  // of a run killed at its very beginning
    return absl::FailedPreconditionError(absl::StrCat(folder.string(), " holds files but no ", kJobFile,
                                                      ", so it is no run; give another --out"));
  }
  if (error) return cannot("read", folder, error.value());
  return RunFolderState::kNew;
}

absl::Status begin_run_folder(const std::filesystem::path& folder, std::string_view job_text) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return cannot("make", folder, error.value());
  if (auto written = write_by_rename(folder / kJobFile, job_text); !written.ok()) return written;
  // A power cut must not take the folder away with all that is computed in it.
  for (std::filesystem::path above = std::filesystem::absolute(folder, error); above.has_relative_path();) {
    above = above.parent_path();
    if (!sync_folder(above).ok()) break;  // may not be opened, so it was not made here
  }
  return absl::OkStatus();
}

absl::Status write_by_rename(const std::filesystem::path& path, std::string_view bytes) {
  std::filesystem::path temporary = path;
  temporary += ".tmp";
  if (auto written = write_durably(temporary, bytes); !written.ok()) {
    ::unlink(temporary.c_str());
    return written;
  }
  if (::rename(temporary.c_str(), path.c_str()) != 0) return cannot("write", path, errno);
  return sync_folder(path.parent_path());
}

bool is_worker_at(const std::filesystem::path& folder) {
  const int file = ::open((folder / "lease").c_str(), O_RDWR | O_CLOEXEC);
  if (file < 0) return false;
  const bool held = ::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(file);
  return held;
}

}  // namespace creepctl
