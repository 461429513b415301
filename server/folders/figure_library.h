// The figures of finished jobs, each read once from its summary.
#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <string>

namespace creepd {

/// Safe from several threads.
class FigureLibrary {
 public:
  /// `figures` of summary.json in the folder of a job that has succeeded, which never changes again; empty if
  /// it has none.
  std::map<std::string, double> of(const std::filesystem::path& folder);

 private:
  static constexpr std::size_t kKept = 4096;

  std::mutex mutex_;
  std::map<std::string, std::map<std::string, double>> known_;  ///< by folder
};

}  // namespace creepd
