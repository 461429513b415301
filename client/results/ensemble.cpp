#include "client/results/ensemble.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace creepctl {
namespace {

namespace fs = std::filesystem;
constexpr int kDeepest = 4;            // folders between a sweep's and its jobs'
constexpr double kTenMinutes = 600.0;  // [s]

const char* const kNone = "–";

void add_jobs_below(const fs::path& folder, int depth, std::vector<std::string>& found) {
  std::error_code error;
  std::vector<fs::path> inner;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (entry->is_directory(error)) inner.push_back(entry->path());
  }
  std::sort(inner.begin(), inner.end());
  for (const fs::path& path : inner) {
    if (fs::is_regular_file(path / "job.toml", error)) {
      found.push_back(path.string());
    } else if (depth < kDeepest) {
      add_jobs_below(path, depth + 1, found);
    }
  }
}

/// Equal for jobs of one ensemble.
std::string key_of(const ComparedJob& job) {
  if (!job.results.experiment) return job.results.directory.string();
  creep::Experiment experiment = *job.results.experiment;
  experiment.specimen.seed = 0;
  const std::string name = experiment.start ? experiment.name : "";
  if (experiment.start) experiment.start->job = "";
  return absl::StrCat(creep::experiment_hash(experiment), name);
}

std::uint64_t seed_of(const ComparedJob& job) {
  return job.results.experiment ? job.results.experiment->specimen.seed : 0;
}

bool has_ended(const ComparedJob& job) { return !job.results.text("outcome").empty(); }

/// The values that there are.
template <typename Value>
EnsembleFigures::Mean mean_of(const Ensemble& ensemble, Value value_of) {
  std::vector<double> values;
  for (const ComparedJob& run : ensemble.runs) {
    const std::optional<double> value = value_of(run);
    if (value && std::isfinite(*value)) values.push_back(*value);
  }
  return creep::ensemble_mean(values);
}

std::optional<double> time_to_failure(const ComparedJob& run) {
  if (run.results.text("outcome") != "creep_failure") return std::nullopt;
  return run.results.figure("creep_time_s");
}

std::optional<double> logarithm(std::optional<double> value) {
  return value && *value > 0.0 ? std::optional(std::log(*value)) : std::nullopt;
}

/// Decimals that show two digits of it.
int decimals_of(double half_width) {
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(half_width))), 0, 8);
}

void tell_apart(std::vector<Ensemble>& ensembles) {
  std::map<std::string, int> seen;
  for (Ensemble& ensemble : ensembles) {
    const int number = ++seen[ensemble.label];
    if (number > 1) absl::StrAppend(&ensemble.label, " (", number, ")");
  }
}

}  // namespace

absl::StatusOr<std::vector<std::string>> job_directories(const std::vector<std::string>& given) {
  std::vector<std::string> found;
  std::error_code error;
  for (const std::string& directory : given) {
    const std::size_t before = found.size();
    if (!fs::is_directory(directory, error))
      return absl::NotFoundError(absl::StrCat("no such directory: ", directory));
    if (fs::is_regular_file(fs::path(directory) / "job.toml", error)) {
      found.push_back(directory);
    } else {
      add_jobs_below(directory, 1, found);
    }
    if (found.size() == before) {
      return absl::InvalidArgumentError(absl::StrCat(
          directory,
          " is no job directory and holds none: give the --out of 'creepctl run' or 'creepctl sweep'"));
    }
  }
  return found;
}

bool is_folder_of_jobs(const std::string& directory) {
  std::error_code error;
  if (fs::is_regular_file(fs::path(directory) / "job.toml", error)) return false;
  return job_directories({directory}).ok();
}

absl::StatusOr<std::vector<Ensemble>> read_ensembles(const std::vector<std::string>& given) {
  const auto directories = job_directories(given);
  if (!directories.ok()) return directories.status();
  auto jobs = read_compared_jobs(*directories);
  if (!jobs.ok()) return jobs.status();
  return group_by_seed(*std::move(jobs));
}

std::vector<Ensemble> group_by_seed(std::vector<ComparedJob> jobs) {
  const bool some_creep = std::any_of(jobs.begin(), jobs.end(), [](const ComparedJob& job) {
    return job.hold && !job.hold->stage_rows.empty();
  });
  std::vector<Ensemble> ensembles;
  std::map<std::string, std::size_t> places;
  for (ComparedJob& job : jobs) {
    if (some_creep && (!job.hold || job.hold->stage_rows.empty())) continue;
    const auto [place, is_new] = places.emplace(key_of(job), ensembles.size());
    if (is_new) ensembles.push_back({job.results.name, {}, 0, 0});
    Ensemble& ensemble = ensembles[place->second];
    const bool known = std::any_of(ensemble.runs.begin(), ensemble.runs.end(),
                                   [&](const ComparedJob& run) { return seed_of(run) == seed_of(job); });
    if (!has_ended(job)) {
      ++ensemble.unfinished;
    } else if (known) {
      ++ensemble.repeated;
    } else {
      ensemble.runs.push_back(std::move(job));
    }
  }
  tell_apart(ensembles);
  return ensembles;
}

EnsembleFigures ensemble_figures(const Ensemble& ensemble) {
  EnsembleFigures figures;
  const auto over = [&](auto member) {
    return mean_of(ensemble, [&](const ComparedJob& run) { return compared_figures(run).*member; });
  };
  figures.void_ratio_before = over(&ComparedFigures::void_ratio_before);
  figures.creep_strain = over(&ComparedFigures::creep_strain);
  figures.m = over(&ComparedFigures::m);
  figures.grading_index = over(&ComparedFigures::grading_index);
  figures.ln_rate_10_min =
      mean_of(ensemble, [](const ComparedJob& run) { return logarithm(compared_figures(run).rate_10_min); });
  figures.stages = mean_of(ensemble, [](const ComparedJob& run) {
    return run.hold ? std::optional(static_cast<double>(run.hold->ageing_jumps())) : std::nullopt;
  });
  figures.ln_time_to_failure =
      mean_of(ensemble, [](const ComparedJob& run) { return logarithm(time_to_failure(run)); });
  for (std::size_t i = 0; i < ensemble.runs.size(); ++i) {
    const ComparedJob& run = ensemble.runs[i];
    const auto paper = run.hold ? paper_triaxial_creep(run.results, *run.hold) : std::nullopt;
    const bool same =
        i == 0 || (paper && figures.paper && paper->stress_ratio == figures.paper->stress_ratio);
    figures.paper = same ? paper : std::nullopt;
    const bool fitted = run.hold && run.hold->analysis.primary_fit;
    if (fitted && !run.hold->analysis.primary_fit->covers(kTenMinutes)) ++figures.extrapolated;
  }
  return figures;
}

std::string mean_text(const EnsembleFigures::Mean& mean, double factor) {
  if (!mean) return kNone;
  const double value = factor * mean->mean;
  if (!mean->half_width) return absl::StrFormat("%.4g", value);
  const double half = factor * *mean->half_width;
  if (!(half > 0.0)) return absl::StrFormat("%.4g ± 0", value);
  // Two figures of the interval, five of the mean.
  const int of_mean = value == 0.0 ? 8 : 4 - static_cast<int>(std::floor(std::log10(std::fabs(value))));
  const int decimals = std::min(decimals_of(half), std::max(0, of_mean));
  return absl::StrFormat("%.*f ± %.*f", decimals, value, decimals, half);
}

std::string geometric_mean_text(const EnsembleFigures::Mean& mean) {
  if (!mean) return kNone;
  const std::string value = absl::StrFormat("%.3g", std::exp(mean->mean));
  if (!mean->half_width) return value;
  return absl::StrFormat("%s (%.2g to %.2g)", value, std::exp(mean->low()), std::exp(mean->high()));
}

std::string confidence_note(const std::vector<Ensemble>& ensembles) {
  std::size_t fewest = 0, most = 0, unfinished = 0, repeated = 0;
  for (const Ensemble& ensemble : ensembles) {
    fewest = &ensemble == &ensembles.front() ? ensemble.runs.size() : std::min(fewest, ensemble.runs.size());
    most = std::max(most, ensemble.runs.size());
    unfinished += ensemble.unfinished;
    repeated += ensemble.repeated;
  }
  std::string note;
  if (most < 2) {
    note = "Each is one run. One run has no uncertainty that is known: run more seeds.";
  } else {
    note = absl::StrCat("Means over the seeds (n = ",
                        fewest == most ? absl::StrCat(most) : absl::StrCat(fewest, " to ", most),
                        ") with Student's 95 % interval of the mean; rates and times to failure are "
                        "geometric means with their "
                        "interval in brackets.");
    if (fewest < 2) note += " Where n is 1 there is no interval: one run has no uncertainty that is known.";
    if (fewest == 2 || most == 2) note += " Two seeds make wide intervals: t is 12.7.";
  }
  if (unfinished > 0) absl::StrAppend(&note, " Left out, since they have not ended: ", unfinished, ".");
  if (repeated > 0) absl::StrAppend(&note, " Left out, since their seed is there already: ", repeated, ".");
  return note;
}

}  // namespace creepctl
