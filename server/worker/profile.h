// Where the time of an attempt goes: a thread that looks every millisecond at what the run is doing.
//
// Samples rather than clocks, since the phases of a cycle are too short to be timed one by one.
#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <thread>

#include "absl/status/status.h"
#include "core/dem/activity.h"

namespace creepd {

class Profile {
 public:
  Profile();
  ~Profile();
  Profile(const Profile&) = delete;
  Profile& operator=(const Profile&) = delete;

  /// For the run and for those who write its files.
  creep::ActivityMark* mark() { return &mark_; }

  /// profile.csv: activity, seconds, share of the time of this attempt. Stops the looking. Errors: as
  /// replace_file.
  absl::Status write(const std::filesystem::path& path);

 private:
  void look();
  void stop();

  creep::ActivityMark mark_{creep::Activity::kOther};
  std::array<std::int64_t, creep::kActivityNames.size()>
      seen_{};  // [ns]; of the looking thread until it has ended
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ending_ = false;  // guarded by mutex_
  std::thread thread_;
};

}  // namespace creepd
