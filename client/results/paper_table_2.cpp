#include "client/results/paper_table_2.h"

#include <cmath>

namespace creepctl {
namespace {

constexpr double kTolerance = 0.02;  // walls hold a sheared specimen within 1 %

double mean_of(const JobResults& results, const Hold& hold, std::string_view column) {
  double sum = 0.0;
  for (const std::size_t row : hold.sample_rows) sum += results.samples.at(row, column);
  return sum / static_cast<double>(hold.sample_rows.size());
}

}  // namespace

std::optional<TriaxialCreepTest> paper_triaxial_creep(const JobResults& results, const Hold& hold) {
  if (hold.sample_rows.empty()) return std::nullopt;
  const double radial = mean_of(results, hold, "radial_stress_Pa");
  const double deviatoric = mean_of(results, hold, "deviatoric_stress_Pa");
  if (!(std::fabs(radial / kPaperRadialStress - 1.0) <= kTolerance)) return std::nullopt;
  for (const TriaxialCreepTest& test : kPaperTriaxialCreep) {
    const double wanted = test.stress_ratio * kPaperDeviatoricStrength;
    if (std::fabs(deviatoric / wanted - 1.0) <= kTolerance) return test;
  }
  return std::nullopt;
}

}  // namespace creepctl
