// The report of a job: one HTML page that needs nothing else, and its headline beside the paper's figures.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/results/hold.h"
#include "client/results/job_results.h"

namespace creepctl {

/// One line of "this run | paper | difference".
struct Comparison {
  std::string quantity;
  std::string run;         ///< "–" while unknown
  std::string paper;       ///< "–" if this scene is not the paper's
  std::string difference;  ///< "–" if there is nothing to compare
  std::string scatter;     ///< how far one packing may lie from another, "" if not known
};

std::vector<Comparison> comparisons(const JobResults& results, const std::optional<Hold>& hold);

/// A sentence on what one packing can tell.
std::string one_packing_note();

std::string report_page(const JobResults& results, const std::optional<Hold>& hold);

}  // namespace creepctl
