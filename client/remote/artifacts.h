// Bringing the files of a job from the daemon, resumable by offset.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "client/remote/connection.h"

namespace creepctl {

/// How far an artifact was read.
struct ArtifactPosition {
  std::uint64_t offset = 0;  ///< [bytes]
  std::string etag;          ///< "" before the first chunk
};

/// Reads from `position` to the present end of the artifact and moves `position` on. `begin` is called with
/// each first chunk, before its data; `data` returns false when it cannot take more, which is an Aborted
/// error. A broken connection is made again as long as there is progress within ten seconds.
/// Further errors: DataLoss (fewer bytes than announced, or not in order).
CallResult read_artifact(Connection& connection, const std::string& job, const std::string& name,
                         ArtifactPosition& position, const std::function<bool(const api::Artifact&)>& begin,
                         const std::function<bool(std::string_view)>& data);

/// Whether a name of the daemon stays below the folder it is joined to: no "..", no absolute path.
bool is_safe_artifact_name(std::string_view name);

struct FetchedFile {
  std::string name;
  std::uint64_t size_bytes = 0;
  std::uint64_t fetched_bytes = 0;  ///< by this call; 0: it was there already
};

/// Brings all artifacts into the folder; what an earlier call brought is not brought again. A file is under
/// its name only when it is whole. `said` gets a line for each file. Errors beside those of the calls:
/// InvalidArgument (the folder holds something else), ResourceExhausted (the folder cannot be written).
CallResult fetch_all(Connection& connection, const std::string& job, const std::filesystem::path& folder,
                     const std::function<void(const FetchedFile&)>& said, std::vector<FetchedFile>& files);

/// What is wrong with what was fetched: damaged checkpoints, a summary with another digest, another job file.
std::vector<std::string> verify_fetched(const api::Job& job, const std::filesystem::path& folder);

}  // namespace creepctl
