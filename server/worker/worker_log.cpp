#include "server/worker/worker_log.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <chrono>
#include <cstdio>
#include <ctime>
#include <string>

#include "absl/strings/str_cat.h"
#include "core/folder/durable_file.h"

namespace creepd {
namespace {

std::string wall_clock() {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm parts{};
  ::gmtime_r(&seconds, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

bool same_file(int first, int second) {
  struct stat a {};
  struct stat b {};
  return ::fstat(first, &a) == 0 && ::fstat(second, &b) == 0 && a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

}  // namespace

absl::StatusOr<WorkerLog> WorkerLog::open(const std::filesystem::path& path, std::int64_t attempt) {
  auto file = creep::open_file(path, O_WRONLY | O_CREAT | O_APPEND);
  if (!file.ok()) return file.status();
  return WorkerLog(*std::move(file), attempt);
}

void WorkerLog::line(std::string_view text) {
  const std::string whole = absl::StrCat(wall_clock(), " attempt ", attempt_, ": ", std::string(text), "\n");
  if (::write(file_.get(), whole.data(), whole.size()) < 0) return;
}

void WorkerLog::trouble(std::string_view text) {
  line(text);
  if (!same_file(file_.get(), STDERR_FILENO)) {
    std::fprintf(stderr, "creep-worker: %s\n", std::string(text).c_str());
  }
}

}  // namespace creepd
