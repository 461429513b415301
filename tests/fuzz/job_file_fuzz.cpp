// Job files: any bytes are answered with places and reasons or an experiment, and an accepted file means the
// same however it is laid out.
#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/arithmetic/check.h"
#include "core/experiment/document.h"
#include "core/experiment/experiment_toml.h"
#include "core/experiment/toml_library.h"
#include "tests/fuzz/target.h"

namespace creep::fuzz {
namespace {

constexpr std::size_t kMostText = 1 << 13;

/// A place in the text, and a line that any terminal can show: what may stand in a TOML comment.
void check_diagnostics(const std::vector<Diagnostic>& diagnostics, std::string_view text) {
  const auto lines = std::count(text.begin(), text.end(), '\n') + 1;
  for (const Diagnostic& one : diagnostics) {
    CREEP_CHECK(one.line >= 1 && one.line <= lines && one.column >= 1, "a diagnostic beyond the text");
    CREEP_CHECK(!one.message.empty(), "a diagnostic without a message");
    CREEP_CHECK(!parse_document("# " + one.message).error, "a diagnostic that is no line of UTF-8");
  }
}

/// The same document as the TOML library writes it: other order, spacing, quotes.
std::string rewritten(std::string_view text) {
  const toml::parse_result parsed = toml::parse(text);
  CREEP_CHECK(parsed.succeeded(), "an accepted job file is no TOML");
  std::ostringstream out;
  out << toml::toml_formatter(parsed.table());
  return out.str();
}

void check_same(const std::string& hash, const std::string& text) {
  const ParseResult again = parse_experiment(text);
  CREEP_CHECK(again.experiment, "an accepted job file is refused in another layout");
  CREEP_CHECK(experiment_hash(*again.experiment) == hash, "a job file's meaning depends on its layout");
}

void check_accepted(std::string_view text, const Experiment& experiment) {
  CREEP_CHECK(!experiment.program.empty(), "an experiment without a stage");
  // A job that starts from another's checkpoint may leave its specimen to that one.
  const int sizes = (experiment.specimen.particles ? 1 : 0) + (experiment.specimen.side ? 1 : 0);
  CREEP_CHECK(sizes == 1 || (sizes == 0 && experiment.start), "an experiment without a size, or with two");
  const double median = median_diameter(experiment.specimen.grading);
  CREEP_CHECK(std::isfinite(median) && median > 0.0, "a grading without a median");
  const std::string hash = experiment_hash(experiment);
  check_same(hash, std::string(text) + "\n# and a comment\r\n");
  check_same(hash, rewritten(text));
}

void check_grading_file(std::string_view text) {
  const auto file = find_grading_file(text);
  if (!file) return;
  CREEP_CHECK(file->key_begin < file->key_end && file->key_end <= text.size(), "a key outside the text");
  CREEP_CHECK(file->value_begin < file->value_end && file->value_end <= text.size(),
              "a value outside the text");
}

}  // namespace

std::vector<std::string> seeds() {
  const std::string specimen = "[specimen]\nparticles = 30\nvoid_ratio = 0.8\nseed = 7\n";
  const std::string program =
      "[[program]]\nstage = \"oedometric\"\nuntil = { axial_stress = \"21.7 MPa\" }\n"
      "[[program]]\nstage = \"creep\"\nduration = \"2 d\"\n";
  return {
      specimen + program,
      "name = \"all keys\"\n[specimen]\nside = \"4 mm\"\nisotropic_stress = \"100 kPa\"\n"
      "grading = { points = [[\"0.1 mm\", 0.0], [\"0.2 mm\", 0.4], [\"400 um\", 1.0]] }\n"
      "[material]\npreset = \"fontainebleau-ne34\"\nshear_modulus = \"32 GPa\"\nfriction = 0.3\n"
      "roughness = \"0.6 um\"\nlimit_stress = \"3.75 GPa\"\ndensity = \"2.65 g/cm3\"\n"
      "crack_velocity = \"0.1 m/s\"\nsplit_layout = \"octahedral\"\n" +
          program +
          "[numerics]\nfidelity = \"paper\"\nminimum_cycles = 1000\ntime_step_safety = 0.7\n"
          "inertia_scaling = \"fragments\"\nskin = \"2 um\"\n[output]\nsnapshots = \"per decade of age\"\n",
      "[specimen]\nparticles = 30\ngrading = { file = \"psd.csv\" }\n" + program,
      "specimen = { particles = 300, grading = { preset = \"fontainebleau-ne34\" } }\n"
      "program = [ { stage = 'oedometric', until.axial_stress = '''5 MPa''' } ]\n",
      specimen + program + "[numerics]\nfidelity = { error = 0.5 }\ndrift_tolerance = \"none\"\n",
      specimen + "[[program]]\nstage = \"oedometrik\"\nuntil = { axial_stress = \"21,7 MPa\" }\n",
  };
}

void try_input(std::string_view text) {
  const ParseResult result = parse_experiment(text);
  CREEP_CHECK(result.experiment.has_value() == result.errors.empty(), "neither accepted nor refused");
  check_diagnostics(result.errors, text);
  check_diagnostics(result.warnings, text);
  check_grading_file(text);
  if (result.experiment) check_accepted(text, *result.experiment);
}

std::string altered(std::string_view text, Random& /*random*/) { return mutated(text, kMostText); }

}  // namespace creep::fuzz
