#include <cmath>
#include <numbers>

#include "core/experiment/presets.h"
#include "core/experiment/sections.h"
#include "core/experiment/table_reader.h"
#include "core/experiment/wording.h"

namespace creep {
namespace {

constexpr std::int64_t kFewestParticles = 20;
constexpr std::int64_t kMostParticles = 10'000'000;
constexpr std::int64_t kWallEffectBelow = 1500;  // with fewer, no friction is low enough for e = 0.65
constexpr double kSmallestGrain = 1e-6;          // [m]
constexpr double kLargestGrain = 0.1;            // [m]
constexpr double kWidestGrading = 100.0;         // largest over smallest diameter
constexpr std::size_t kMostPoints = 1000;

/// Grains per volume of solid [1/m3]: a rough mean of 6/(pi d^3) by mass, to catch absurd cubes before a run
/// does.
double grains_per_solid_volume(const Grading& grading) {
  const double sphere = 6.0 / std::numbers::pi;
  if (const auto* lognormal = std::get_if<LognormalGrading>(&grading)) {
    const double spread = lognormal->log_standard_deviation;
    return sphere / std::pow(lognormal->median_diameter, 3) * std::exp(4.5 * spread * spread);
  }
  double sum = 0.0;
  const std::vector<GradingPoint>& points = std::get<GradingPoints>(grading).points;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double middle = std::sqrt(points[i - 1].diameter * points[i].diameter);
    sum += (points[i].passing - points[i - 1].passing) * sphere / std::pow(middle, 3);
  }
  return sum;
}

/// One [diameter, passing] pair.
std::optional<GradingPoint> read_point(const DocumentNode& node, DiagnosticLog& log) {
  if (node.kind != DocumentNode::Kind::kArray || node.items.size() != 2) {
    log.error(node.begin, "a grading point is [diameter, mass fraction passing], like [\"0.21 mm\", 0.5]");
    return std::nullopt;
  }
  const auto diameter =
      read_quantity(node.items[0], "diameter", Dimension::kLength, kSmallestGrain, kLargestGrain, log);
  const auto passing = read_number(node.items[1], "mass fraction passing", 0.0, 1.0, log);
  if (!diameter || !passing) return std::nullopt;
  return GradingPoint{*diameter, *passing};
}

/// The rules that make the points a curve.
void check_curve(const DocumentNode& node, const std::vector<GradingPoint>& points, DiagnosticLog& log) {
  const std::size_t errors_before = log.errors.size();
  for (std::size_t i = 1; i < points.size(); ++i) {
    const TextPosition at = node.items[i].begin;
    if (points[i].diameter <= points[i - 1].diameter)
      log.error(at, "diameters must rise from point to point");
    if (points[i].passing < points[i - 1].passing) {
      log.error(at, "the mass fraction passing must not fall from point to point");
    }
  }
  if (points.front().passing != 0.0) {
    log.error(node.items.front().begin,
              "the first point must pass 0: nothing is finer than the finest grain");
  }
  if (points.back().passing != 1.0) log.error(node.items.back().begin, "the last point must pass 1");
  if (log.errors.size() > errors_before) return;
  if (points.back().diameter > kWidestGrading * points.front().diameter) {
    log.error(node.begin,
              "the largest diameter may be at most " + shortest(kWidestGrading) + " times the smallest");
  }
}

std::optional<GradingPoints> read_points(const DocumentNode& node, DiagnosticLog& log) {
  if (node.kind != DocumentNode::Kind::kArray || node.items.size() < 2 || node.items.size() > kMostPoints) {
    log.error(node.begin,
              "points must be an array of 2 to 1000 pairs, like [[\"0.1 mm\", 0.0], [\"0.4 mm\", 1.0]]");
    return std::nullopt;
  }
  GradingPoints result;
  for (const DocumentNode& item : node.items) {
    if (const auto point = read_point(item, log)) result.points.push_back(*point);
  }
  if (result.points.size() < node.items.size()) return std::nullopt;
  const std::size_t errors_before = log.errors.size();
  check_curve(node, result.points, log);
  if (log.errors.size() > errors_before) return std::nullopt;
  return result;
}

std::optional<Grading> read_grading(const DocumentNode& node, DiagnosticLog& log) {
  if (node.kind != DocumentNode::Kind::kTable) {
    log.error(node.begin, "grading must be a table, like { preset = \"fontainebleau-ne34\" }");
    return std::nullopt;
  }
  TableReader reader(node, "grading", log);
  const int given =
      (reader.has("preset") ? 1 : 0) + (reader.has("points") ? 1 : 0) + (reader.has("file") ? 1 : 0);
  if (given != 1) reader.error(node.begin, "grading needs exactly one of preset, points, file");

  std::optional<Grading> grading;
  if (const auto preset = reader.word("preset", grading_preset_names())) grading = grading_preset(*preset);
  if (const DocumentNode* points = reader.find("points")) {
    if (const auto curve = read_points(*points, log)) grading = *curve;
  }
  if (const auto file = reader.string("file")) {
    reader.error(reader.position_of("file"),
                 "grading file " + quoted(*file) + " is not part of the job; creepctl puts its points here");
  }
  reader.finish();
  return grading;
}

/// That the cube holds a number of grains that a run can have.
void check_side(TableReader& reader, const SpecimenSpec& specimen) {
  const double side = *specimen.side;
  const double solid = side * side * side / (1.0 + specimen.void_ratio);
  const double estimate = solid * grains_per_solid_volume(specimen.grading);
  if (estimate >= static_cast<double>(kFewestParticles) && estimate <= static_cast<double>(kMostParticles)) {
    return;
  }
  reader.error(reader.position_of("side"),
               "side = " + quoted(format_quantity(side, Dimension::kLength)) + " holds about " +
                   shortest(std::round(estimate)) + " particles of this grading; allowed " +
                   std::to_string(kFewestParticles) + " to " + std::to_string(kMostParticles));
}

}  // namespace

SpecimenSpec read_specimen(const DocumentNode& table, DiagnosticLog& log) {
  TableReader reader(table, "[specimen]", log);
  SpecimenSpec specimen;
  if (reader.has("particles") && reader.has("side")) {
    reader.error(reader.position_of("side"),
                 "give either particles or side, not both: one follows from the other");
  } else if (!reader.has("particles") && !reader.has("side")) {
    reader.error(table.begin, "[specimen] needs particles (like 3000) or side (like \"4 mm\")");
  }
  reader.count("particles", kFewestParticles, kMostParticles, specimen.particles);
  reader.quantity("side", Dimension::kLength, 10e-6, 10.0, specimen.side);
  bool good_grading = true;
  if (const DocumentNode* node = reader.find("grading")) {
    const auto grading = read_grading(*node, log);
    good_grading = grading.has_value();
    if (grading) specimen.grading = *grading;
  }
  reader.number("void_ratio", 0.2, 2.0, specimen.void_ratio);
  reader.quantity("isotropic_stress", Dimension::kStress, 1e3, 100e6, specimen.isotropic_stress);
  std::int64_t seed = 1;
  reader.count("seed", 0, std::numeric_limits<std::int64_t>::max(), seed);
  specimen.seed = static_cast<std::uint64_t>(seed);

  if (specimen.particles && *specimen.particles < kWallEffectBelow) {
    reader.warning(
        reader.position_of("particles"),
        "below about 1500 particles the walls keep the packing loose: the target void ratio may not be "
        "reached (0.66 at 1000, 0.73 at 300 at best); the run then takes the densest state");
  }
  if (specimen.side && good_grading) check_side(reader, specimen);
  reader.finish();
  return specimen;
}

}  // namespace creep
