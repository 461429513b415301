// The files of jobs as the daemon sees them: it makes and removes folders, and reads what workers write.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/folder/file_descriptor.h"
#include "core/state/checkpoint.h"

namespace creepd {

/// STATE/jobs/ID with job.toml in it. Not durable: the store has the job file too, and an attempt does not
/// start without secure_job_folder(). What was begun is removed on an error.
absl::Status make_job_folder(const std::filesystem::path& folder, std::string_view spec);

/// The same, durable; mends a folder that a power cut took or tore.
absl::Status secure_job_folder(const std::filesystem::path& folder, std::string_view spec);

struct Artifact {
  std::string name;  ///< relative to the folder, e.g. "checkpoints/ck.7"
  std::uint64_t size = 0;
  std::int64_t modified = 0;  ///< [us since 1970]
  std::string etag;           ///< of the file, not of its length
};

/// Regular files with a place in the list of what is given out, by name. Links are passed over.
std::vector<Artifact> list_artifacts(const std::filesystem::path& folder);

struct OpenArtifact {
  Artifact artifact;
  creep::FileDescriptor file;
};
/// Opens an artifact of the list: `name` is compared with the names there, and never becomes a path itself.
/// Errors: NotFound ARTIFACT_NOT_FOUND, or of the file system.
absl::StatusOr<OpenArtifact> open_artifact(const std::filesystem::path& folder, std::string_view name);

/// Highest N of checkpoints/ck.N; 0 if there is none.
std::uint64_t newest_checkpoint(const std::filesystem::path& folder);

/// The last lines of worker.log.
std::string log_tail(const std::filesystem::path& folder);

/// "state_digest" of summary.json; "" if there is none.
std::string state_digest(const std::filesystem::path& folder);

/// The attempt that verdict.json is of, and the one that took the lease last; nothing without the file.
std::optional<std::int64_t> verdict_attempt(const std::filesystem::path& folder);
std::optional<std::int64_t> lease_attempt(const std::filesystem::path& folder);

/// "process 4711": who took the lease last.
std::string lease_holder(const std::filesystem::path& folder);

/// True while a worker, of whatever daemon, holds the lease.
bool lease_is_held(const std::filesystem::path& folder);

/// Bytes an ordinary user may still write; 0 if that cannot be told.
std::uint64_t free_bytes(const std::filesystem::path& path);

/// Room without which an attempt would soon fail again: a few checkpoints of this job [bytes].
std::uint64_t needed_bytes(const std::filesystem::path& folder);

/// A checkpoint of a job: by the name under which its program kept it, else by its generation, else the
/// newest good generation.
struct CheckpointChoice {
  std::uint64_t generation = 0;
  std::string kept;
};
struct ChosenCheckpoint {
  CheckpointChoice choice;  ///< the generation that was taken
  std::string bytes;
  creep::CheckpointInfo info;
};
/// `kept` is compared with the names there, and never becomes a path itself. Errors: NotFound
/// CHECKPOINT_NOT_FOUND, DataLoss CHECKPOINT_DAMAGED, or of the file system.
absl::StatusOr<ChosenCheckpoint> choose_checkpoint(const std::filesystem::path& folder,
                                                   const CheckpointChoice& choice);

/// Puts a checkpoint of another job, and the records before it, into a folder that has job.toml already: the
/// same experiment goes on there. Errors: DataLoss CHECKPOINT_DAMAGED, or of the file system.
absl::Status continue_from(const std::filesystem::path& source, const ChosenCheckpoint& checkpoint,
                           const std::filesystem::path& target);

/// Puts a checkpoint into a folder that has job.toml already: another program starts from it there.
absl::Status start_from(const ChosenCheckpoint& checkpoint, const std::filesystem::path& target);

}  // namespace creepd
