#include "client/sweep/sweep_end.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "client/terminal/table.h"

namespace creepctl {
namespace {

std::string state_word(const SweepEnd& end) {
  if (!end.ended) return "waits";
  if (end.exit_code == kOk) return "done";
  return end.exit_code == kCancelled ? "cancelled" : "failed";
}

}  // namespace

int exit_code_of(const std::vector<SweepEnd>& ends) {
  for (const int code : {kFailed, kInvalidInput, kIoError, kCancelled, kRunAgain}) {
    if (std::any_of(ends.begin(), ends.end(), [&](const SweepEnd& end) { return end.exit_code == code; }))
      return code;
  }
  return kOk;
}

std::string summary_text(const std::vector<SweepEnd>& ends, int width) {
  Table table({{"NOT DONE"}, {"STATE"}, {"WHERE"}, {"WHY"}});
  for (const SweepEnd& end : ends) {
    if (!end.ended || end.exit_code != kOk) table.add({end.name, state_word(end), end.place, end.message});
  }
  const auto done = std::count_if(ends.begin(), ends.end(),
                                  [](const SweepEnd& end) { return end.ended && end.exit_code == kOk; });
  return absl::StrCat(table.empty() ? "" : table.text(width), done, " of ", ends.size(), " jobs are done\n");
}

std::string summary_json(const std::vector<SweepEnd>& ends) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const SweepEnd& end : ends) {
    list.push_back({{"name", end.name},
                    {"place", end.place},
                    {"state", state_word(end)},
                    {"exit_code", end.exit_code},
                    {"message", end.message}});
  }
  return list.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace creepctl
