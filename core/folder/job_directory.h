// The names of the files of one job directory. The worker that holds the lease is their only writer.
#pragma once

#include <filesystem>
#include <utility>

namespace creep {

class JobDirectory {
 public:
  explicit JobDirectory(std::filesystem::path root) : root_(std::move(root)) {}

  const std::filesystem::path& root() const { return root_; }
  std::filesystem::path job_file() const { return root_ / "job.toml"; }  ///< as sent; written by the caller
  std::filesystem::path lease() const { return root_ / "lease"; }        ///< lock and attempt number
  std::filesystem::path sample_log() const { return root_ / "samples.log"; }   ///< every record, in sequence
  std::filesystem::path checkpoints() const { return root_ / "checkpoints"; }  ///< three generations of ck.N
  std::filesystem::path start_checkpoint() const {  ///< of the job that this one starts from; by the caller
    return checkpoints() / "start";
  }
  std::filesystem::path snapshots() const { return root_ / "snapshots"; }  ///< for a viewer, if asked for
  std::filesystem::path stage_timings() const { return root_ / "stage_timings.csv"; }  ///< cost, not physics
  std::filesystem::path profile() const {
    return root_ / "profile.csv";
  }  ///< of the last attempt, if asked for
  std::filesystem::path progress() const { return root_ / "progress.json"; }
  std::filesystem::path verdict() const { return root_ / "verdict.json"; }  ///< how the last attempt ended
  std::filesystem::path summary() const { return root_ / "summary.json"; }  ///< final figures
  std::filesystem::path worker_log() const { return root_ / "worker.log"; }

 private:
  std::filesystem::path root_;
};

}  // namespace creep
