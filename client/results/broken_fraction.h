// Broken fraction by size class: cumulative broken of the class over its current number (figure 18 of the
// paper).
#pragma once

#include <string>
#include <vector>

#include "client/results/job_results.h"

namespace creepctl {

struct BrokenFraction {
  double smallest = 0.0;  ///< class [smallest, largest) of particle diameter [m]
  double largest = 0.0;
  std::vector<double> creep_time;  ///< [s], at the grading curves of the hold
  std::vector<double> fraction;    ///< broken since the start of the test over the number now [-]
};

/// Numbers come from the grading curves: the mass between two points of a curve is in particles of their
/// geometric mean size, and the sum over the first curve is the number of particles after packing. Four
/// classes between the smallest size broken and the largest present. Empty if the job has no grading curves,
/// no samples or no breakage.
std::vector<BrokenFraction> broken_fractions(const JobResults& results);

}  // namespace creepctl
