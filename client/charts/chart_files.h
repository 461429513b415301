// Charts as files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/report/result_charts.h"

namespace creepctl {

/// Writes each chart into `folder`, which is made, as FILE_STEM.svg, .png or both (`format`), and prints the
/// path of every file written. Error: Unavailable, Internal from Cairo.
absl::Status write_charts(const std::filesystem::path& folder, const std::string& format,
                          const std::vector<NamedChart>& charts);

}  // namespace creepctl
