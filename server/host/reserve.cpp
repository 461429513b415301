#include "server/host/reserve.h"

#include <fcntl.h>

#include <system_error>
#include <utility>

#include "core/folder/durable_file.h"
#include "server/folders/job_files.h"
#include "server/host/daemon_log.h"

namespace creepd {
namespace {

namespace fs = std::filesystem;

// What the database's log may grow by before SQLite begins it anew: 1000 pages.
constexpr std::uint64_t kRoom = 4 << 20;

}  // namespace

Reserve::Reserve(fs::path file) : file_(std::move(file)) {
  std::error_code error;
  const auto size = fs::file_size(file_, error);
  if (!error) state_ = size >= kRoom ? State::kHeld : State::kInUse;
}

bool Reserve::use() {
  if (state_ != State::kHeld) return false;
  std::error_code error;
  fs::resize_file(file_, 0, error);
  if (error) return false;
  state_ = State::kInUse;
  log_line("the disk is full: the reserve is in use, no job is started");
  return true;
}

bool Reserve::restore() {
  if (state_ != State::kHeld && free_bytes(file_.parent_path()) >= 2 * kRoom) {
    const auto file = creep::open_file(file_, O_WRONLY | O_CREAT);
    std::error_code error;
    if (file.ok() && ::posix_fallocate(file->get(), 0, static_cast<off_t>(kRoom)) == 0) {
      state_ = State::kHeld;
    } else if (state_ == State::kInUse) {
      fs::resize_file(file_, 0, error);
    } else {
      fs::remove(file_, error);
    }
  }
  return !in_use();
}

}  // namespace creepd
