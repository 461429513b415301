// Normal contact law of rough elastic spheres (eqs 1-7, after Otsubo et al. 2017a): exact, and tabulated for
// kernels.
//
// All thresholds scale with the roughness alone, so for a pair with reduced modulus E' and reduced radius r'
//   F = E' sqrt(r') g(overlap),  dF/d(overlap) = E' sqrt(r') slope(overlap),
// with one g [m^1.5] for a material. Three branches: asperities up to delta_T1, transition up to delta_T2,
// then Hertz with the overlap reduced by the roughness. The force is continuously differentiable; its
// curvature is not.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>

namespace creep {

/// The law itself, immutable. Roughness 0 is smooth Hertz. All functions return 0 for overlap <= 0.
class RoughLaw {
 public:
  /// roughness S_q >= 0 [m], n1 and n2 >= 0 [-] (eqs 6 and 7).
  static RoughLaw make(double roughness, double n1, double n2);

  /// F / (E' sqrt(r')) [m^1.5].
  double g(double overlap) const;
  /// (dF/d overlap) / (E' sqrt(r')) [m^0.5].
  double slope(double overlap) const;
  /// Work of loading from 0 to the overlap, over E' sqrt(r') [m^2.5].
  double energy(double overlap) const;

  double b() const { return b_; }                              ///< exponent of the transition branch [-]
  double c() const { return c_; }                              ///< exponent of the asperity branch [-]
  double delta_1() const { return delta_1_; }                  ///< n1 S_q [m]
  double delta_2() const { return delta_2_; }                  ///< n2 S_q [m]
  double delta_T1() const { return delta_T1_; }                ///< end of the asperity branch [m]
  double delta_T2() const { return delta_T2_; }                ///< start of the Hertz branch [m]
  double g_T1() const { return g_T1_; }                        ///< g at delta_T1 [m^1.5]
  double g_T2() const { return g_T2_; }                        ///< g at delta_T2 [m^1.5]
  double hertz_offset() const { return delta_1_ + delta_2_; }  ///< of the Hertz branch [m]

  /// The transition branch continued beyond its ends: g and slope at an overlap > delta_1.
  double transition_g(double overlap) const;
  double transition_slope(double overlap) const;

 private:
  RoughLaw() = default;
  /// Integral of transition_g from delta_1 [m^2.5].
  double transition_energy(double overlap) const;

  double b_ = 1.5, c_ = 1.5;
  double delta_1_ = 0.0, delta_2_ = 0.0;
  double delta_T1_ = 0.0, delta_T2_ = 0.0;
  double g_T1_ = 0.0, g_T2_ = 0.0;
  double energy_T1_ = 0.0, energy_T2_ = 0.0;
};

/// g and slope of a RoughLaw as cubic Hermite polynomials in cells found from the bits of the overlap.
///
/// CANONICAL EVALUATION. Every kernel reproduces evaluate() operation by operation, so that all give the same
/// bits. With u = overlap x inverse_delta_T1 (so that u = 1 is a cell border) and cells of width 2^-cell_bits
/// of an octave:
///  - cell 0 covers [0, 2^-20), with base 0 (a parabola; at 1e-6 of the asperity overlap forces do not
///  matter);
///  - cell i >= 1 starts at the double whose bits are (before_first_cell + i) << cell_shift, its base.
/// A record is 4 doubles {c0, c1, c2, c3} at cells() + 4 i, 32-byte aligned: g is their polynomial in x = u -
/// base and slope its exact derivative in the overlap. From delta_T2 on the Hertz formula is used. Relative
/// error of g and slope <= 1e-9 for overlap >= 1e-3 S_q.
class LawTable {
 public:
  explicit LawTable(const RoughLaw& law);

  /// overlap >= 0, finite.
  void evaluate(double overlap, double& g, double& slope) const {
    if (overlap >= delta_T2_) {
      const double depth = overlap - hertz_offset_;
      const double root = std::sqrt(depth);
      g = (kFourThirds * depth) * root;
      slope = 2.0 * root;
      return;
    }
    const double u = overlap * inverse_delta_T1_;
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(u);
    std::int64_t cell = static_cast<std::int64_t>(bits >> cell_shift_) - before_first_cell_;
    double base = std::bit_cast<double>(bits & base_mask_);
    if (u < kFirstBorder) {
      cell = 0;
      base = 0.0;
    }
    const double* const record = cells_.get() + 4 * cell;
    const double x = u - base;  // exact
    const double p2 = std::fma(record[3], x, record[2]);
    const double p1 = std::fma(p2, x, record[1]);
    g = std::fma(p1, x, record[0]);
    const double q2 = std::fma(record[3], x, p2);
    slope = std::fma(q2, x, p1) * inverse_delta_T1_;
  }

  static constexpr double kFourThirds = 4.0 / 3.0;
  static constexpr double kFirstBorder = 0x1p-20;  ///< in u; below it cell 0 is used

  double inverse_delta_T1() const { return inverse_delta_T1_; }  ///< [1/m]; 0 for a smooth law
  double delta_T2() const { return delta_T2_; }           ///< [m]; 0 for a smooth law, which is always Hertz
  double hertz_offset() const { return hertz_offset_; }   ///< [m]
  int cell_bits() const { return 52 - cell_shift_; }      ///< 2^cell_bits cells an octave: 7 by default
  int cell_shift() const { return cell_shift_; }          ///< right shift of bits(u): 45 for 128 cells
  std::uint64_t base_mask() const { return base_mask_; }  ///< and-mask that clears the low cell_shift bits
  /// Subtracted from bits(u) >> cell_shift to give the cell; u < kFirstBorder gives 0 or less, to be clamped
  /// to 0.
  std::int64_t before_first_cell() const { return before_first_cell_; }
  std::int64_t cell_count() const { return cell_count_; }
  const double* cells() const { return cells_.get(); }

 private:
  struct Free {
    void operator()(double* cells) const;
  };

  double inverse_delta_T1_ = 0.0;
  double delta_T2_ = 0.0;
  double hertz_offset_ = 0.0;
  int cell_shift_ = 45;
  std::uint64_t base_mask_ = 0;
  std::int64_t before_first_cell_ = 0;
  std::int64_t cell_count_ = 1;
  std::unique_ptr<double[], Free> cells_;
};

}  // namespace creep
