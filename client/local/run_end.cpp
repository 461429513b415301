#include "client/local/run_end.h"

#include <chrono>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <thread>

#include "client/local/run_folder.h"
#include "client/terminal/exit_codes.h"

namespace creepctl {

using nlohmann::ordered_json;

ordered_json read_json(const std::filesystem::path& path) {
  ordered_json value = ordered_json::parse(read_text(path), nullptr, false);
  return value.is_object() ? value : ordered_json::object();
}

std::string word(const ordered_json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

int exit_code_of(const WorkerEnd& end) {
  if (end.signal != 0) return kFailed;
  switch (end.exit_code) {
    case 0:
      return kOk;
    case 65:
      return kInvalidInput;
    case kIoError:
    case kRunAgain:
      return end.exit_code;
    default:
      return kFailed;
  }
}

std::vector<std::string> explanation(const WorkerEnd& end, const std::filesystem::path& folder) {
  const ordered_json verdict = read_json(folder / "verdict.json");
  if (end.signal == 0 && end.exit_code == kRunAgain)
    return {"stopped with a checkpoint; the same command continues from there"};
  // A verdict that could not be written (full disk) may be missing: then the log has the words.
  const auto code = verdict.find("exit_code");
  if (end.signal == 0 && code != verdict.end() && *code == end.exit_code) {
    std::vector<std::string> sentences = {word(verdict, "reason")};
    if (const std::string advice = word(verdict, "advice"); !advice.empty()) sentences.push_back(advice);
    return sentences;
  }
  std::vector<std::string> sentences;
  if (end.signal != 0) {
    sentences.push_back(std::string("creep-worker was killed by signal ") + std::to_string(end.signal) +
                        " (" + ::strsignal(end.signal) +
                        "); the same command continues from the newest checkpoint");
  } else {
    sentences.push_back("creep-worker ended with exit code " + std::to_string(end.exit_code));
  }
  if (const std::string tail = last_lines(read_text(folder / "worker.log"), 5); !tail.empty())
    sentences.push_back("the end of " + (folder / "worker.log").string() + ":\n" + tail);
  return sentences;
}

std::string outcome_sentence(const std::filesystem::path& folder) {
  return word(read_json(folder / "summary.json"), "reason");
}

bool wait_for_orphan(const std::filesystem::path& folder) {
  for (int i = 0; i < 100 && is_worker_at(folder); ++i) {
    if (i == 0) std::fprintf(stderr, "waiting for the worker that is still in %s\n", folder.c_str());
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return !is_worker_at(folder);
}

}  // namespace creepctl
