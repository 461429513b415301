#include "client/sweep/sweep_plan.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>

#include "absl/strings/str_cat.h"
#include "core/experiment/experiment_toml.h"
#include "core/experiment/job_text.h"
#include "core/experiment/stage_text.h"
#include "core/experiment/units.h"
#include "core/experiment/wording.h"

namespace creepctl {
namespace {

constexpr std::size_t kMostJobs = 1000;
constexpr double kRatioGrid = 1e6;              // ratios are taken to six decimals
constexpr std::int64_t kMostCheckpoints = 200;  // of one trunk
constexpr double kBeyond = 0.1;                 // steps by which a trunk goes beyond the largest ratio
constexpr std::size_t kLongestName = 200;       // bytes, of `name` in a job file

absl::Status wrong(const std::string& what) { return absl::InvalidArgumentError(what); }

std::string toml_string(const std::string& text) {
  std::string out = "\"";
  for (const char letter : text) {
    if (letter == '"' || letter == '\\') out += '\\';
    out += static_cast<unsigned char>(letter) < 0x20 ? ' ' : letter;
  }
  return out + "\"";
}

std::string pascal(double stress) { return absl::StrCat("\"", creep::shortest(stress), " Pa\""); }

/// One combination of the varied values.
struct Variant {
  std::vector<creep::Override> overrides;
  std::string words;   ///< "minimum_cycles = 20000, ..."
  std::string folder;  ///< "minimum_cycles_20000/..."
};

std::string last_part(const std::string& key) { return key.substr(key.rfind('.') + 1); }

std::string folder_of(const std::string& key, const std::string& value) {
  std::string name = last_part(key) + "_";
  for (const char letter : value) {
    const bool plain = (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') ||
                       (letter >= '0' && letter <= '9') || letter == '.' || letter == '-';
    if (plain) name += letter;
  }
  return name.substr(0, 60);
}

std::vector<Variant> variants(const std::vector<VariedKey>& varied) {
  std::vector<Variant> all(1);
  for (const VariedKey& one : varied) {
    std::vector<Variant> longer;
    for (const Variant& variant : all) {
      for (const std::string& value : one.values) {
        Variant next = variant;
        next.overrides.emplace_back(one.key, value);
        absl::StrAppend(&next.words, next.words.empty() ? "" : ", ", last_part(one.key), " = ", value);
        absl::StrAppend(&next.folder, "/", folder_of(one.key, value));
        longer.push_back(std::move(next));
      }
    }
    all = std::move(longer);
  }
  return all;
}

/// Where a program is cut into trunk and branch.
struct Cut {
  std::size_t triaxial = 0;  ///< the stage in which the trunk keeps its checkpoints
  std::size_t stages = 0;    ///< of the whole program
  std::string q_max;         ///< as written
  double strength = 0.0;     ///< q_max [Pa]
  std::int64_t unit = 0;     ///< the step of the checkpoints, of q_max / kRatioGrid
  std::int64_t most = 0;     ///< steps to the largest ratio

  double step() const { return static_cast<double>(unit) / kRatioGrid * strength; }
  std::int64_t steps_to(double ratio) const { return std::llround(ratio * kRatioGrid) / unit; }
};

absl::StatusOr<Cut> cut_of(const JobFile& job, const SweepRequest& request) {
  const auto& program = job.experiment->program;
  Cut cut;
  cut.stages = program.size();
  bool found = false;
  for (std::size_t i = 0; i < program.size(); ++i) {
    const auto* stage = std::get_if<creep::TriaxialStage>(&program[i]);
    if (stage == nullptr || stage->until.measure != creep::Target::Measure::kDeviatoricStress) continue;
    cut.triaxial = i;
    found = true;
  }
  if (!found)
    return wrong(absl::StrCat("--stress-ratio: ", job.path,
                              " has no triaxial stage until a q_ratio or deviatoric_stress to branch from"));
  if (cut.triaxial + 1 == program.size())
    return wrong(absl::StrCat("--stress-ratio: nothing follows the triaxial stage of ", job.path,
                              ": put there what is to run at each ratio, such as a creep stage"));
  cut.q_max = request.q_max;
  if (cut.q_max.empty())
    cut.q_max =
        creep::string_at(job.text, absl::StrCat("program.", cut.triaxial, ".until.q_max")).value_or("");
  if (cut.q_max.empty())
    return wrong(absl::StrCat("--stress-ratio needs the shear strength: give --q-max, or until = { q_ratio, ",
                              "q_max } in the triaxial stage of ", job.path));
  const auto strength = creep::parse_quantity(cut.q_max, creep::Dimension::kStress);
  if (!strength.ok()) return wrong(absl::StrCat("--q-max: ", std::string(strength.status().message())));
  cut.strength = *strength;
  for (const double ratio : request.stress_ratios) {
    cut.unit = std::gcd(cut.unit, static_cast<std::int64_t>(std::llround(ratio * kRatioGrid)));
  }
  for (const double ratio : request.stress_ratios) {
    if (cut.unit == 0) return wrong("--stress-ratio: too small a ratio");
    cut.most = std::max(cut.most, cut.steps_to(ratio));
  }
  if (cut.most > kMostCheckpoints)
    return wrong(
        absl::StrCat("--stress-ratio: the trunk keeps a checkpoint at each multiple of the largest step ",
                     "that all ratios are multiples of, here ", creep::shortest(cut.step() / cut.strength),
                     ": ", cut.most, " of them, at most ", kMostCheckpoints, "; give rounder ratios"));
  return cut;
}

/// The program up to the triaxial stage, which goes to the largest ratio.
absl::StatusOr<std::string> trunk_text(const std::string& whole, const Cut& cut) {
  auto text = creep::with_stages(whole, 0, cut.triaxial + 1);
  if (!text.ok()) return text;
  const std::string stage = absl::StrCat("program.", cut.triaxial);
  const double until = (static_cast<double>(cut.most) + kBeyond) * cut.step();
  return creep::with_overrides(
      *text, {{stage + ".until", absl::StrCat("{ deviatoric_stress = ", pascal(until), " }")},
              {stage + ".keep", absl::StrCat("{ every_deviatoric_stress = ", pascal(cut.step()), " }")}});
}

/// What follows the triaxial stage, its creep at the stress ratio.
absl::StatusOr<std::string> branch_text(const std::string& whole, const std::vector<creep::Stage>& program,
                                        const Cut& cut, double ratio) {
  const std::size_t first = cut.triaxial + 1;
  auto text = creep::with_stages(whole, first, cut.stages - first);
  for (std::size_t i = first; text.ok() && i < cut.stages; ++i) {
    const auto* hold = std::get_if<creep::CreepStage>(&program[i]);
    if (hold == nullptr || !(hold->deviatoric_stress || (i == first && !hold->axial_stress))) continue;
    const std::string stage = absl::StrCat("program.", i - first);
    text = creep::without_keys(*text, {stage + ".deviatoric_stress"});
    if (!text.ok()) break;
    text = creep::with_overrides(
        *text, {{stage + ".q_ratio", creep::shortest(ratio)}, {stage + ".q_max", toml_string(cut.q_max)}});
  }
  return text;
}

/// Of the text alone, and of a branch with some source.
absl::Status check(const SweepJob& job) {
  auto text = job.trunk ? started_from(job, "trunk") : absl::StatusOr<std::string>(job.text);
  if (!text.ok()) return text.status();
  const creep::ParseResult parsed = creep::parse_experiment(*text);
  if (parsed.errors.empty()) return absl::OkStatus();
  return wrong(absl::StrCat(job.name, ": ", parsed.errors.front().message));
}

/// The job files of one seed, added to `jobs`.
class SeedPlanner {
 public:
  SeedPlanner(const JobFile& job, const std::optional<Cut>& cut, std::vector<SweepJob>& jobs)
      : job_(job), cut_(cut), jobs_(jobs), first_(jobs.size()) {}

  absl::Status add(std::int64_t seed, const Variant& variant, const std::vector<double>& ratios) {
    std::vector<creep::Override> overrides = variant.overrides;
    overrides.emplace_back("specimen.seed", absl::StrCat(seed));
    auto whole = creep::with_overrides(job_.text, overrides);
    if (!whole.ok()) return wrong(absl::StrCat("--set: ", std::string(whole.status().message())));
    const creep::ParseResult parsed = creep::parse_experiment(*whole);
    if (!parsed.experiment)
      return wrong(absl::StrCat(job_.path, " with ", variant.words.empty() ? "the seed" : variant.words, ": ",
                                parsed.errors.front().message));
    const std::string folder = absl::StrCat("seed_", seed);
    if (!cut_) return put({folder + variant.folder, *whole, false, {}, ""}, variant.words);
    if (parsed.experiment->program.size() != cut_->stages)
      return wrong("--set program= cannot be joined with --stress-ratio");
    const auto trunk = trunk_for(folder, *whole);
    if (!trunk.ok()) return trunk.status();
    const creep::ParseResult trunk_experiment = creep::parse_experiment(jobs_[*trunk].text);
    const creep::Stage& shear = trunk_experiment.experiment->program[cut_->triaxial];
    for (const double ratio : ratios) {
      auto text = branch_text(*whole, parsed.experiment->program, *cut_, ratio);
      if (!text.ok()) return text.status();
      const std::string word = creep::shortest(ratio);
      const std::string checkpoint =
          creep::kept_checkpoint_name(cut_->triaxial, shear, cut_->steps_to(ratio));
      auto put_in = put(
          {absl::StrCat(folder, variant.folder, "/q_", word), *std::move(text), false, *trunk, checkpoint},
          absl::StrCat("q/q_max = ", word, variant.words.empty() ? "" : ", ", variant.words));
      if (!put_in.ok()) return put_in;
    }
    return absl::OkStatus();
  }

 private:
  /// The trunk with this text; made if there is none yet.
  absl::StatusOr<std::size_t> trunk_for(const std::string& folder, const std::string& whole) {
    auto text = trunk_text(whole, *cut_);
    if (!text.ok()) return text.status();
    auto named = named_text(*text, "trunk");
    if (!named.ok()) return named.status();
    for (std::size_t i = first_; i < jobs_.size(); ++i) {
      if (jobs_[i].is_trunk && jobs_[i].text == *named) return i;
    }
    auto made = put({folder + "/trunk", *std::move(text), true, {}, ""}, "trunk");
    if (!made.ok()) return made;
    return jobs_.size() - 1;
  }

  absl::StatusOr<std::string> named_text(const std::string& text, const std::string& words) const {
    std::string name = job_.experiment->name;
    if (name.empty()) name = std::filesystem::path(job_.path).stem().string();
    if (!words.empty()) absl::StrAppend(&name, ", ", words);
    if (name.size() > kLongestName) return text;
    return creep::with_overrides(text, {{"name", toml_string(name)}});
  }

  absl::Status put(SweepJob job, const std::string& words) {
    auto text = named_text(job.text, words);
    if (!text.ok()) return text.status();
    job.text = *std::move(text);
    const std::string wanted = job.name;
    const auto taken = [&](const SweepJob& other) { return other.name == job.name; };
    for (int number = 2; std::any_of(jobs_.begin(), jobs_.end(), taken); ++number)
      job.name = absl::StrCat(wanted, "-", number);
    if (auto good = check(job); !good.ok()) return good;
    if (jobs_.size() == kMostJobs)
      return wrong(absl::StrCat("the sweep has more than ", kMostJobs, " jobs: give fewer values"));
    jobs_.push_back(std::move(job));
    return absl::OkStatus();
  }

  const JobFile& job_;
  const std::optional<Cut>& cut_;
  std::vector<SweepJob>& jobs_;
  std::size_t first_;  ///< of this seed
};

}  // namespace

absl::StatusOr<std::vector<SweepJob>> plan_sweep(const JobFile& job, const SweepRequest& request) {
  if (job.experiment->start) {
    return wrong(
        absl::StrCat(job.path,
                     " has [start]: a sweep prepares its own specimens; give a job file with the whole "
                     "program"));
  }
  std::optional<Cut> cut;
  if (!request.stress_ratios.empty()) {
    auto found = cut_of(job, request);
    if (!found.ok()) return found.status();
    cut = *std::move(found);
  } else if (!request.q_max.empty()) {
    return wrong("--q-max is for --stress-ratio, which is not given");
  }
  std::vector<std::int64_t> seeds = request.seeds;
  if (seeds.empty()) seeds.push_back(static_cast<std::int64_t>(job.experiment->specimen.seed));
  std::vector<SweepJob> jobs;
  for (const std::int64_t seed : seeds) {
    SeedPlanner planner(job, cut, jobs);
    for (const Variant& variant : variants(request.varied)) {
      if (auto added = planner.add(seed, variant, request.stress_ratios); !added.ok()) return added;
    }
  }
  return jobs;
}

absl::StatusOr<std::string> started_from(const SweepJob& branch, const std::string& trunk) {
  return creep::with_overrides(
      branch.text, {{"start.job", toml_string(trunk)}, {"start.checkpoint", toml_string(branch.checkpoint)}});
}

}  // namespace creepctl
