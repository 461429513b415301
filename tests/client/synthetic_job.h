// A job directory as a run leaves it, made from formulas: the right answers are known.
#pragma once

#include <filesystem>
#include <string>

namespace creepctl {

struct SyntheticJob {
  std::string axial_stress = "21.7 MPa";  ///< as written in job.toml
  std::string duration = "2 d";
  double m = 0.8;           ///< the creep rate is 2e-4 / s x (t / 1 s)^-m
  int dynamic_stages = 15;  ///< after the initial one; 0 leaves the run in its initial dynamic stage
  bool loaded = true;       ///< false leaves it in packing
  bool finished = true;     ///< with summary.json
  double noise = 0.0;       ///< standard deviation of ln of the strain increments
  unsigned noise_seed = 1;
  int seed = 7;  ///< as written in job.toml
};

/// Files of such a job in `directory`, which is made.
void write_synthetic_job(const std::filesystem::path& directory, const SyntheticJob& job);

/// Axial creep strain of that law at creep_time [s], from the end of the initial dynamic stage.
double synthetic_creep_strain(const SyntheticJob& job, double creep_time);

}  // namespace creepctl
