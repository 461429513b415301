// How creepctl ends: scripts depend on these numbers.
#pragma once

namespace creepctl {

inline constexpr int kOk = 0;            ///< done; a creep failure of the specimen is a result, so this too
inline constexpr int kFailed = 1;        ///< the run failed: a guard stopped it, or a crash
inline constexpr int kUsage = 2;         ///< unknown command or option, or a bad value of one
inline constexpr int kCancelled = 3;     ///< the job was cancelled
inline constexpr int kUnreachable = 4;   ///< no daemon, or not allowed
inline constexpr int kInvalidInput = 5;  ///< the job file (or another input file) is wrong or cannot be read
inline constexpr int kWaitTimedOut = 6;  ///< wait gave up
inline constexpr int kIoError = 74;      ///< passed on by run: input or output failed, e.g. the disk is full
inline constexpr int kRunAgain = 75;     ///< passed on by run: checkpointed; the same command continues

}  // namespace creepctl
