// How a run in a job directory ended, for scripts and in words.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "client/local/worker_process.h"

namespace creepctl {

/// A file that the worker left, like verdict.json; an empty object if it is not there or no object.
nlohmann::ordered_json read_json(const std::filesystem::path& path);

/// The string under a key; "" if there is none.
std::string word(const nlohmann::ordered_json& object, const char* key);

/// Of exit_codes.h: 74 and 75 are passed on; the other codes of a worker are translated.
int exit_code_of(const WorkerEnd& end);

/// Why it did not end well, from what the worker left: sentences, the most telling first.
std::vector<std::string> explanation(const WorkerEnd& end, const std::filesystem::path& folder);

/// The sentence of summary.json on how it ended: "completed"; "" if there is none.
std::string outcome_sentence(const std::filesystem::path& folder);

/// A worker whose parent was killed checkpoints and ends by itself: waits ten seconds for that. False if it
/// is still there.
bool wait_for_orphan(const std::filesystem::path& folder);

}  // namespace creepctl
