#include "core/physics/contact_law.h"

#include <new>

#include "core/arithmetic/check.h"
#include "core/arithmetic/elementary.h"

namespace creep {
namespace {

constexpr double kForceRatio = 100.0;  // F_T2 / F_T1
constexpr int kLeastCellBits = 7;
constexpr int kMostCellBits = 12;
constexpr std::align_val_t kCellAlignment{64};

/// d^1.5.
double power_three_halves(double d) { return d * std::sqrt(d); }

/// Bound on the relative error of the slope of a cubic Hermite interpolant of y^p over cells at most h y
/// wide: sqrt(3)/216 h^3 |f''''/f'|.
double slope_error(double p, double h) {
  return std::sqrt(3.0) / 216.0 * h * h * h * std::fabs((p - 1.0) * (p - 2.0) * (p - 3.0));
}

/// Smallest number of bits for which the table keeps its promise of 1e-9, with a margin for rounding.
int choose_cell_bits(const RoughLaw& law) {
  constexpr double kGoal = 0.95e-9;
  const double stretch =
      law.delta_T1() / (law.delta_T1() - law.delta_1());  // of a cell relative to overlap - delta_1
  for (int bits = kLeastCellBits; bits < kMostCellBits; ++bits) {
    const double width = std::ldexp(1.0, -bits);  // of a cell at the start of an octave, relative to u
    if (slope_error(law.c(), width) <= kGoal && slope_error(law.b(), width * stretch) <= kGoal) return bits;
  }
  return kMostCellBits;
}

}  // namespace

RoughLaw RoughLaw::make(double roughness, double n1, double n2) {
  CREEP_CHECK(roughness >= 0.0 && n1 >= 0.0 && n2 >= 0.0, "negative roughness");
  RoughLaw law;
  if (roughness == 0.0) return law;
  law.delta_1_ = n1 * roughness;
  law.delta_2_ = n2 * roughness;
  law.g_T1_ = roughness * std::sqrt(2.0 * roughness);  // F_T1 = S_q E' sqrt(2 r' S_q)
  law.g_T2_ = kForceRatio * law.g_T1_;
  // Continuity of the force and of its derivative at both thresholds.
  const double hertz_depth = elementary::pow(0.75 * law.g_T2_, 2.0 / 3.0);
  law.delta_T2_ = law.hertz_offset() + hertz_depth;
  const double transition_depth = law.delta_T2_ - law.delta_1_;
  law.b_ = 1.5 * transition_depth / hertz_depth;
  law.delta_T1_ = law.delta_1_ + transition_depth * elementary::pow(1.0 / kForceRatio, 1.0 / law.b_);
  law.c_ = law.b_ * law.delta_T1_ / (law.delta_T1_ - law.delta_1_);
  law.energy_T1_ = law.g_T1_ * law.delta_T1_ / (law.c_ + 1.0);
  law.energy_T2_ =
      law.energy_T1_ + (law.transition_energy(law.delta_T2_) - law.transition_energy(law.delta_T1_));
  return law;
}

double RoughLaw::transition_g(double overlap) const {
  return g_T2_ * elementary::pow((overlap - delta_1_) / (delta_T2_ - delta_1_), b_);
}

double RoughLaw::transition_slope(double overlap) const {
  const double depth = delta_T2_ - delta_1_;
  return g_T2_ * b_ / depth * elementary::pow((overlap - delta_1_) / depth, b_ - 1.0);
}

double RoughLaw::transition_energy(double overlap) const {
  return transition_g(overlap) * (overlap - delta_1_) / (b_ + 1.0);
}

double RoughLaw::g(double overlap) const {
  if (!(overlap > 0.0)) return 0.0;
  if (overlap >= delta_T2_) return 4.0 / 3.0 * power_three_halves(overlap - hertz_offset());
  if (overlap > delta_T1_) return transition_g(overlap);
  return g_T1_ * elementary::pow(overlap / delta_T1_, c_);
}

double RoughLaw::slope(double overlap) const {
  if (!(overlap > 0.0)) return 0.0;
  if (overlap >= delta_T2_) return 2.0 * std::sqrt(overlap - hertz_offset());
  if (overlap > delta_T1_) return transition_slope(overlap);
  return g_T1_ * c_ / delta_T1_ * elementary::pow(overlap / delta_T1_, c_ - 1.0);
}

double RoughLaw::energy(double overlap) const {
  if (!(overlap > 0.0)) return 0.0;
  if (overlap >= delta_T2_) {
    const auto hertz = [this](double d) {
      const double depth = d - hertz_offset();
      return 8.0 / 15.0 * depth * power_three_halves(depth);
    };
    return energy_T2_ + (hertz(overlap) - hertz(delta_T2_));
  }
  if (overlap > delta_T1_) {
    return energy_T1_ + (transition_energy(overlap) - transition_energy(delta_T1_));
  }
  return g(overlap) * overlap / (c_ + 1.0);
}

void LawTable::Free::operator()(double* cells) const { ::operator delete[](cells, kCellAlignment); }

LawTable::LawTable(const RoughLaw& law) : delta_T2_(law.delta_T2()), hertz_offset_(law.hertz_offset()) {
  const auto cell_at = [this](double u) {
    return static_cast<std::int64_t>(std::bit_cast<std::uint64_t>(u) >> cell_shift_);
  };
  const bool rough = delta_T2_ > 0.0;
  if (rough) {
    inverse_delta_T1_ = 1.0 / law.delta_T1();
    cell_shift_ = 52 - choose_cell_bits(law);
  }
  base_mask_ = ~((std::uint64_t{1} << cell_shift_) - 1);
  before_first_cell_ = cell_at(kFirstBorder) - 1;
  if (rough) cell_count_ = cell_at(delta_T2_ * inverse_delta_T1_) - before_first_cell_ + 1;
  const auto doubles = static_cast<std::size_t>(4 * cell_count_);
  cells_.reset(new (kCellAlignment) double[doubles]());
  if (!rough) return;

  const double delta_T1 = law.delta_T1();
  const double first_g = law.g(kFirstBorder * delta_T1);
  cells_[2] = first_g / (kFirstBorder * kFirstBorder);
  for (std::int64_t cell = 1; cell < cell_count_; ++cell) {
    const auto border = [&](std::int64_t index) {
      return std::bit_cast<double>(static_cast<std::uint64_t>(before_first_cell_ + index) << cell_shift_);
    };
    const double start = border(cell), end = border(cell + 1);
    const double width = end - start;  // a power of two
    // Both ends on one branch: 1 is a border, and the cell of delta_T2 continues the transition.
    const bool asperity = end <= 1.0;
    const double g0 = asperity ? law.g(start * delta_T1) : law.transition_g(start * delta_T1);
    const double g1 = asperity ? law.g(end * delta_T1) : law.transition_g(end * delta_T1);
    const double rise = g1 - g0;
    const double s0 =
        width * delta_T1 * (asperity ? law.slope(start * delta_T1) : law.transition_slope(start * delta_T1));
    const double s1 =
        width * delta_T1 * (asperity ? law.slope(end * delta_T1) : law.transition_slope(end * delta_T1));
    double* const record = cells_.get() + 4 * cell;
    record[0] = g0;
    record[1] = s0 / width;
    record[2] = (3.0 * rise - 2.0 * s0 - s1) / (width * width);
    record[3] = (s0 + s1 - 2.0 * rise) / (width * width * width);
  }
}

}  // namespace creep
