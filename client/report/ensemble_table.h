// The figures of ensembles as a table, for pages, terminals and programs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "client/results/ensemble.h"
#include "client/results/paper_table_2.h"

namespace creepctl {

/// Titles of the columns of ensemble_row(); "_{...}" is lowered on pages. The last three are the paper's.
std::vector<std::string> ensemble_head();

/// Cells: means with half widths, "–" where there is none.
std::vector<std::string> ensemble_row(const Ensemble& ensemble);

/// ensemble_row() of each; last the paper's oedometer, if one of them is a trial of it.
std::vector<std::vector<std::string>> ensemble_rows(const std::vector<Ensemble>& ensembles);

/// All rows in columns, lines cut to `width`; 0: none is.
std::string ensemble_table_text(const std::vector<Ensemble>& ensembles, int width);

/// Of the paper's Table 2; null where a job is no trial of it.
nlohmann::ordered_json paper_json(const std::optional<TriaxialCreepTest>& test);

/// One object an ensemble; each figure with mean, low, high (null for one run) and n, SI or as its name says.
nlohmann::ordered_json ensembles_json(const std::vector<Ensemble>& ensembles);

}  // namespace creepctl
