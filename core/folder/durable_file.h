// Files that are either there whole or not at all.
//
// A file is written beside its place under the name PATH.tmp and renamed into it. One process writes a path
// at a time (the lease sees to that), so the temporary name needs no further distinction.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/folder/file_descriptor.h"

namespace creep {

/// "what: text of errno". Codes: ResourceExhausted (disk or quota full, file too large), NotFound,
/// PermissionDenied (also a read-only file system), DataLoss (everything else: the storage failed).
absl::Status errno_status(std::string_view what, int error_number);

/// open(2), close-on-exec. For writing no link is followed: who can put one in the place of a file of ours
/// must not choose what we overwrite.
absl::StatusOr<FileDescriptor> open_file(const std::filesystem::path& path, int flags);

/// Writes all of `bytes` at the descriptor's place; restarts after interruptions and short writes.
absl::Status write_all(int descriptor, std::string_view bytes, const std::filesystem::path& path);

/// The whole file. Error: also DataLoss if it is longer than `most_bytes`, looked at before memory is taken.
absl::StatusOr<std::string> read_file(const std::filesystem::path& path,
                                      std::uint64_t most_bytes = std::uint64_t{1} << 36);

/// Temporary file, write, fsync, rename, fsync of the directory: after a power cut `path` holds the old bytes
/// or the new ones. On an error the temporary file is removed and the old bytes stand.
absl::Status write_durably(const std::filesystem::path& path, std::string_view bytes);

/// The same without fsync: safe against a killed process, not against a power cut. For files made again at
/// will.
absl::Status replace_file(const std::filesystem::path& path, std::string_view bytes);

/// Makes the names in a directory durable.
absl::Status sync_directory(const std::filesystem::path& directory);

}  // namespace creep
