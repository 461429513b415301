// What a creep curve says: strain rates, the Singh-Mitchell slope of primary creep, the onset of tertiary
// creep.
//
// The curve is taken at the ends of the dynamic stages, where the specimen is in equilibrium, and is
// piecewise linear in ln(creep_time) between them. Pure functions; what cannot be told from the points given
// is nullopt.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace creep {

/// The ends of the dynamic stages of one hold, in order; both arrays have the same length.
struct CreepCurve {
  std::vector<double> creep_time;    ///< [s]; points at or before 0 have no logarithm and are not used
  std::vector<double> axial_strain;  ///< since the hold began [-], compression positive
};

struct StrainRate {
  double creep_time = 0.0;  ///< geometric middle of the interval [s]
  double rate = 0.0;        ///< (d strain / d ln creep_time) / creep_time [1/s]; may be zero or negative
};

/// Rates between neighbouring points of the curve, of those that lie a factor of 2 apart in creep_time; the
/// last interval ends with the curve. Points that do not advance creep_time are skipped.
///
/// Failures come at random: of n of them between two points, ln(rate) lies above ln of the true rate by
/// ln n - psi(n) on average (psi: digamma), 0.58 of one, 0.13 of four. Closer points would make the rate
/// that a line through ln(rate) gives a question of how often the curve was sampled.
std::vector<StrainRate> strain_rates(const CreepCurve& curve);

/// The same over sliding windows, each the shortest that spans 3 intervals and a factor of 2 in creep_time:
/// what the phases of creep are told from. Empty if the curve is shorter than a window.
std::vector<StrainRate> smoothed_strain_rates(const CreepCurve& curve);

/// rate = rate_at_1_s (creep_time / 1 s)^-m, by least squares of ln rate on ln creep_time (Singh & Mitchell
/// 1968).
struct SinghMitchellFit {
  double m = 0.0;                   ///< [-]; positive for a falling rate
  double m_standard_error = 0.0;    ///< of the regression [-]; says nothing of the scatter between specimens
  std::optional<double> r_squared;  ///< nullopt when all rates are equal
  double ln_rate_scatter = 0.0;     ///< standard deviation of ln rate about the line [-]
  double ln_rate_at_1_s = 0.0;      ///< ln of the fitted rate in 1/s at creep_time = 1 s
  double window_begin = 0.0;        ///< creep_time of the first rate used [s]
  double window_end = 0.0;          ///< creep_time of the last rate used [s]
  std::size_t points = 0;           ///< rates used
  std::size_t omitted = 0;          ///< rates in the window that are not positive and have no logarithm

  /// Fitted rate [1/s].
  double rate(double creep_time) const;
  bool covers(double creep_time) const { return window_begin <= creep_time && creep_time <= window_end; }
};

/// Fit over the rates with window_begin <= creep_time <= window_end [s]. nullopt with fewer than 3 positive
/// rates: a line through two points leaves nothing to judge it by.
std::optional<SinghMitchellFit> fit_singh_mitchell(const std::vector<StrainRate>& rates, double window_begin,
                                                   double window_end);

/// strain = strain_at_1_s + strain_per_decade log10(creep_time / 1 s).
struct LogTimeFit {
  double strain_per_decade = 0.0;   ///< [-]
  double strain_at_1_s = 0.0;       ///< [-]
  std::optional<double> r_squared;  ///< nullopt when all strains are equal
  std::size_t points = 0;
};

/// Linearity of the creep curve in log time. nullopt with fewer than 3 points.
std::optional<LogTimeFit> fit_log_time(const CreepCurve& curve);

enum class CreepPhase { kPrimary, kSecondary, kTertiary };

/// Time to failure: where the smoothed rate is least, with the range in which it stays within a factor
/// of 1.25 of it.
struct TertiaryOnset {
  double creep_time = 0.0;    ///< [s]
  double earliest = 0.0;      ///< [s]
  double latest = 0.0;        ///< [s]
  double minimum_rate = 0.0;  ///< smoothed [1/s]
};

struct CreepAnalysis {
  std::vector<StrainRate> rates;
  std::vector<StrainRate> smoothed_rates;
  /// The last phase reached. Tertiary: the smoothed rate rose to twice its minimum. Secondary: at the end it
  /// stayed within a factor of 1.25 of its minimum while creep_time at least doubled. nullopt with too few
  /// points.
  std::optional<CreepPhase> phase;
  std::optional<TertiaryOnset> tertiary;
  std::optional<SinghMitchellFit> primary_fit;  ///< over primary creep only
  std::optional<LogTimeFit> log_time_fit;
};

CreepAnalysis analyse_creep(const CreepCurve& curve);

}  // namespace creep
