#include "client/laboratory/laboratory_curve.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client/results/job_results.h"

namespace creepctl {

absl::StatusOr<LaboratoryCurve> parse_laboratory_curve(std::string_view text, std::string name) {
  std::string lines;
  for (absl::string_view line : absl::StrSplit(absl::string_view(text.data(), text.size()), '\n')) {
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (!line.empty() && line.front() != '#') absl::StrAppend(&lines, line, "\n");
  }
  const auto table = NumberTable::parse(lines, name);
  if (!table.ok()) return table.status();
  if (!table->has("age_s") || !table->has("axial_strain")) {
    return absl::InvalidArgumentError(absl::StrCat(name, ": needs the columns age_s and axial_strain"));
  }
  if (table->rows() == 0) return absl::InvalidArgumentError(absl::StrCat(name, ": holds no line of numbers"));
  return LaboratoryCurve{std::move(name), table->column("age_s"), table->column("axial_strain")};
}

}  // namespace creepctl
