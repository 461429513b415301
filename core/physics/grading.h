// Gradings by mass and the particles that make them up; grading index and breakage indices.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/experiment/experiment.h"

namespace creep {

/// Mass fraction finer than `diameter` [m]: 0 up to the finest, 1 from the coarsest diameter on.
double passing_at_diameter(const Grading& grading, double diameter);

/// Diameter [m] below which the mass fraction `passing` in [0, 1] lies. Inverse of passing_at_diameter.
double diameter_at_passing(const Grading& grading, double passing);

/// Finest and coarsest diameter [m].
double finest_diameter(const Grading& grading);
double coarsest_diameter(const Grading& grading);

/// Mean of d^3 over the particles, by number [m3]: pi/6 of it is the mean volume of a particle.
double mean_cubed_diameter(const Grading& grading);

/// `count` diameters [m], ascending: the mid-quantiles (i + 1/2)/count of the distribution by NUMBER whose
/// distribution by mass is the grading.
std::vector<double> stratified_diameters(const Grading& grading, std::int64_t count);

/// Passing at `diameter` of a fractal distribution between min_diameter and max_diameter, cut to [0, 1]:
/// (d^a - d_min^a)/(d_max^a - d_min^a) with a = 3 - fractal dimension; logarithmic for a = 0.
double fractal_passing(double diameter, double max_diameter, double min_diameter, double a);

/// Grading index I_G (eq 13): area under the passing curve over the area under the fractal limit, both on a
/// ln d axis from d_min to d_max. The area is linear in mass, so
///   I_G = (sum of particle mass x particle_area + sum of fines mass x fines_area) / (all mass x
///   limit_area()).
class GradingIndex {
 public:
  /// Limits and fractal dimension of the material, d_min < d_max.
  explicit GradingIndex(const Material& material);

  /// Area per unit mass at one diameter [m]: ln(d_max/d), 0 for coarser than d_max, ln(d_max/d_min) for finer
  /// than d_min.
  double particle_area(double diameter) const;
  /// Area per unit mass of fines that are fractal between d_min and the smallest sibling of their event [m].
  double fines_area(double smallest_sibling_diameter) const;
  /// Area of the fractal limit.
  double limit_area() const { return fines_area(max_diameter_); }

 private:
  double min_diameter_;
  double max_diameter_;
  double exponent_;
};

/// Hardin's (1985) relative breakage B_r [-]: mass-weighted ln size lost, over what there was above 0.074 mm
/// (silt). Curves are passing fractions at the common ascending `diameters` [m], straight in ln d between
/// them; they must reach 1 at the last. 0 if nothing was coarser than silt.
double breakage_hardin(std::span<const double> diameters, std::span<const double> initial,
                       std::span<const double> current);

/// Einav's (2007) relative breakage B_r* [-]: area between the current and the initial curve over that
/// between the ultimate (fractal) and the initial one, on a ln d axis. Curves as for breakage_hardin.
double breakage_einav(std::span<const double> diameters, std::span<const double> initial,
                      std::span<const double> current, std::span<const double> ultimate);

}  // namespace creep
