// Room on the disk that is given up when the disk is full, so that what is then most needed can still be
// stored: ends of attempts, pauses, and above all deletions, which make room.
#pragma once

#include <cstdint>
#include <filesystem>

namespace creepd {

class Reserve {
 public:
  /// The file is made by restore() only. One of length 0 says that its room is in use.
  explicit Reserve(std::filesystem::path file);

  /// Gives the room up. False if there is none to give.
  bool use();
  /// Takes the room (again) where at least twice as much is free. False while it is in use.
  bool restore();
  bool in_use() const { return state_ == State::kInUse; }

 private:
  enum class State { kNone, kHeld, kInUse };

  std::filesystem::path file_;
  State state_ = State::kNone;
};

}  // namespace creepd
