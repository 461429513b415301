// The figures of a run beside the paper's.
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/report/report_page.h"

namespace creepctl {
namespace {

const char* const kNone = "–";

/// Last row of stages.csv before the hold; nullopt if loading has not ended.
std::optional<std::size_t> end_of_loading(const JobResults& results) {
  std::optional<std::size_t> found;
  for (std::size_t row = 0; row < results.stages.rows(); ++row) {
    if (results.stages.at(row, "dynamic_stage") < 0.0) found = row;
  }
  return found;
}

/// Void ratio at the end of packing, where strains are zero.
Comparison initial_void_ratio(const JobResults& results, bool comparable) {
  Comparison line{"e after packing", kNone, kNone, kNone, ""};
  if (comparable) line.paper = absl::StrFormat("%.2f", kPaperInitialVoidRatio);
  const auto loading = loading_and_creep_samples(results);
  if (loading.empty()) return line;
  const double value = results.samples.at(loading.front(), "void_ratio");
  line.run = absl::StrFormat("%.4f", value);
  if (comparable) line.difference = absl::StrFormat("%+.4f", value - kPaperInitialVoidRatio);
  return line;
}

Comparison void_ratio(std::string quantity, double value, bool comparable) {
  Comparison line{std::move(quantity), kNone, kNone, kNone, "±0.006"};
  if (comparable) line.paper = absl::StrFormat("%.3f", kPaperVoidRatio);
  if (!std::isfinite(value)) return line;
  line.run = absl::StrFormat("%.4f", value);
  if (comparable) line.difference = absl::StrFormat("%+.4f", value - kPaperVoidRatio);
  return line;
}

Comparison stage_count(std::string quantity, std::optional<std::size_t> count, bool comparable) {
  Comparison line{std::move(quantity), kNone, kNone, kNone, "±3"};
  if (comparable) line.paper = absl::StrFormat("%.0f", kPaperDynamicStages);
  if (!count) return line;
  line.run = absl::StrCat(*count);
  if (comparable)
    line.difference = absl::StrFormat("%+.0f", static_cast<double>(*count) - kPaperDynamicStages);
  return line;
}

Comparison creep_strain(const std::optional<Hold>& hold, bool ended, bool comparable) {
  Comparison line{ended ? "creep strain at the end" : "creep strain so far", kNone, kNone, kNone, "±40 %"};
  if (hold && !hold->stage_rows.empty())
    line.run = absl::StrFormat("%.3f %%", 100.0 * hold->curve.axial_strain.back());
  if (comparable) line.paper = "linear in log time";
  if (!hold || !hold->analysis.log_time_fit) return line;
  const auto& fit = *hold->analysis.log_time_fit;
  absl::StrAppend(&line.run, absl::StrFormat("; %.3f %% per decade", 100.0 * fit.strain_per_decade));
  if (!fit.r_squared) return line;
  absl::StrAppend(&line.run, absl::StrFormat(", R² = %.3f", *fit.r_squared));
  if (comparable) line.difference = absl::StrFormat("R² is %.3f below 1", 1.0 - *fit.r_squared);
  return line;
}

Comparison grading_index(const JobResults& results, const std::optional<Hold>& hold, bool comparable) {
  Comparison line{"grading index I_G, start and end of creep", kNone, kNone, kNone, ""};
  if (comparable) line.paper = "rises in log time";
  const std::size_t rows = results.stages.rows();
  if (rows == 0) return line;
  if (!hold || hold->stage_rows.empty()) {
    line.quantity = "grading index I_G";
    line.run = absl::StrFormat("%.4f", results.stages.at(rows - 1, "grading_index_end"));
    return line;
  }
  const auto loading = end_of_loading(results);
  const double begin = results.stages.at(loading.value_or(hold->stage_rows.front()), "grading_index_end");
  const double end = results.stages.at(hold->stage_rows.back(), "grading_index_end");
  line.run = absl::StrFormat("%.4f → %.4f", begin, end);
  if (const auto& fit = hold->grading_index_fit; fit && fit->r_squared) {
    absl::StrAppend(
        &line.run, absl::StrFormat("; %+.4f per decade, R² = %.3f", fit->strain_per_decade, *fit->r_squared));
    if (comparable) line.difference = absl::StrFormat("R² is %.3f below 1", 1.0 - *fit->r_squared);
  }
  return line;
}

Comparison ripple(const JobResults& results, const std::optional<Hold>& hold, bool comparable) {
  Comparison line{"largest stress ripple during creep", kNone, kNone, kNone, ""};
  if (comparable) line.paper = "< 4 %";
  if (!hold || hold->stage_rows.empty()) return line;
  double largest = 0.0;
  for (const std::size_t row : hold->stage_rows)
    largest = std::fmax(largest, results.stages.at(row, "ripple"));
  line.run = absl::StrFormat("%.2f %%", 100.0 * largest);
  if (comparable) {
    line.difference = largest < kPaperRipple
                          ? "within"
                          : absl::StrFormat("above by %.2f %%", 100.0 * (largest - kPaperRipple));
  }
  return line;
}

}  // namespace

std::vector<Comparison> comparisons(const JobResults& results, const std::optional<Hold>& hold) {
  const PaperScene scene = paper_scene(results);
  const bool creeping = hold && !hold->stage_rows.empty();
  const auto loading = end_of_loading(results);
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  // An unfinished hold has had fewer stages than it will have.
  const bool ended = !results.text("outcome").empty();
  const auto count = [&](std::size_t extra) {
    return creeping ? std::optional<std::size_t>(hold->ageing_jumps() + extra) : std::nullopt;
  };
  return {
      initial_void_ratio(results, scene.compression),
      void_ratio("e at the end of loading", loading ? results.stages.at(*loading, "void_ratio_end") : unknown,
                 scene.compression),
      void_ratio("e after the initial dynamic stage",
                 creeping ? results.stages.at(hold->stage_rows.front(), "void_ratio_end") : unknown,
                 scene.compression),
      stage_count("dynamic stages: ageing jumps, the closing one included", count(0), ended && scene.creep),
      stage_count("dynamic stages: the initial one included", count(1), ended && scene.creep),
      creep_strain(hold, ended, scene.creep),
      grading_index(results, hold, scene.creep),
      ripple(results, hold, scene.creep)};
}

std::string one_packing_note() {
  return "One packing is one sample. From one realisation to another expect e to differ by ±0.006, the "
         "broken particles "
         "by ±20 %, the dynamic stages by ±3, the creep strain by ±40 % and the rate by a factor of 2.5: a "
         "difference "
         "within these says nothing, and only the mean over several seeds can be judged.";
}

}  // namespace creepctl
