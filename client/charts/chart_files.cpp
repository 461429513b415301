#include "client/charts/chart_files.h"

#include <cstdio>
#include <fstream>

#include "absl/strings/str_cat.h"

namespace creepctl {
namespace {

absl::Status write_file(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) return absl::UnavailableError(absl::StrCat("cannot write ", path.string()));
  std::printf("%s\n", path.c_str());
  return absl::OkStatus();
}

absl::Status write_chart(const std::filesystem::path& out, const std::string& format,
                         const NamedChart& named) {
  if (format != "png") {
    const auto written = write_file(out / (named.file_stem + ".svg"), draw_svg(named.chart, ""));
    if (!written.ok()) return written;
  }
  if (format == "svg") return absl::OkStatus();
  const auto png = draw_png(named.chart);
  if (!png.ok()) return png.status();
  return write_file(out / (named.file_stem + ".png"), *png);
}

}  // namespace

absl::Status write_charts(const std::filesystem::path& folder, const std::string& format,
                          const std::vector<NamedChart>& charts) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return absl::UnavailableError(absl::StrCat("cannot make ", folder.string(), ": ", error.message()));
  }
  for (const NamedChart& chart : charts) {
    if (auto written = write_chart(folder, format, chart); !written.ok()) return written;
  }
  return absl::OkStatus();
}

}  // namespace creepctl
