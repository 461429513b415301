// The jobs of a sweep: one job file, over seeds, values of its keys and stress ratios. Pure.
//
// Without stress ratios every combination is a job of its own. With them, the jobs of one seed branch from
// one trunk: the program up to the triaxial stage runs once, to a little beyond the largest ratio, and keeps
// a checkpoint at each; what follows that stage runs from there, once a ratio.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/job_file/job_file.h"
#include "client/sweep/sweep_values.h"

namespace creepctl {

struct SweepRequest {
  std::vector<std::int64_t> seeds;    ///< none: that of the job file
  std::vector<VariedKey> varied;      ///< every combination of their values
  std::vector<double> stress_ratios;  ///< q / q_max [-]; none: no trunk
  std::string q_max;                  ///< "22.6 MPa"; "": that of `until` of the triaxial stage
};

struct SweepJob {
  std::string name;  ///< "seed_1/q_0.2", "seed_1/trunk": also its folder; no two alike
  std::string text;  ///< its job file; of a branch without [start]
  bool is_trunk = false;
  std::optional<std::size_t> trunk;  ///< of a branch: which of the jobs it starts from, one before it
  std::string checkpoint;            ///< of a branch: name of the one kept by its trunk
};

/// At most 1000 jobs. Error: InvalidArgument, which names the option or the job with what is wrong.
absl::StatusOr<std::vector<SweepJob>> plan_sweep(const JobFile& job, const SweepRequest& request);

/// The job file of a branch, started from `trunk`: the id of a job, or the path of its folder.
absl::StatusOr<std::string> started_from(const SweepJob& branch, const std::string& trunk);

}  // namespace creepctl
