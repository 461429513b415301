#include "client/commands/commands.h"

#include <array>
#include <chrono>
#include <cstdio>
#include <memory>
#include <system_error>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "client/remote/connection.h"
#include "client/remote/message_json.h"
#include "client/remote/remote_job.h"
#include "client/terminal/exit_codes.h"
#include "client/terminal/terminal.h"
#include "core/folder/sample_log.h"
#include "core/run/self_test.h"
#include "core/state/checkpoint.h"
#include "core/state/program_version.h"

namespace creepctl {
namespace {

constexpr double kGibibyte = 1024.0 * 1024.0 * 1024.0;
constexpr std::uint64_t kLittleRoom = 2ull
                                      << 30;  // [bytes]; three checkpoints and the log of a large job fit

enum class Grade { kGood, kWarning, kBad };

struct Finding {
  Grade grade;
  std::string what;
  std::string advice;
};

struct Options {
  ServerOptions server;
  bool json = false;
};

void look_at_programs(std::vector<Finding>& findings) {
  std::error_code error;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  const bool worker = std::filesystem::exists(folder / "creep-worker", error);
  findings.push_back({worker ? Grade::kGood : Grade::kWarning,
                      absl::StrCat("creep-worker ", worker ? "is" : "is not", " in ", folder.string()),
                      worker ? "" : "'creepctl run' needs it there; a remote daemon does not"});
}

/// "0.10.2" as numbers; parts that are none count as 0.
std::array<int, 3> numbers_of(const std::string& version) {
  std::array<int, 3> numbers{};
  std::size_t k = 0;
  for (const absl::string_view part : absl::StrSplit(version, '.')) {
    if (k == numbers.size() || !absl::SimpleAtoi(part, &numbers[k])) break;
    ++k;
  }
  return numbers;
}

/// What another version there means for who works from here.
void look_at_versions(const api::ServerInfo& info, std::vector<Finding>& findings) {
  const std::string here(creep::program_version());
  if (info.version() == here) {
    findings.push_back({Grade::kGood, absl::StrCat("creepctl ", here, ", the same version"), ""});
  } else if (numbers_of(info.version()) < numbers_of(here)) {
    findings.push_back(
        {Grade::kWarning, absl::StrCat("creepctl ", here, " is newer than the daemon, ", info.version()),
         "it refuses keys, options and calls that it does not know; jobs compute as its version does"});
  } else {
    findings.push_back(
        {Grade::kWarning, absl::StrCat("creepctl ", here, " is older than the daemon, ", info.version()),
         "checks made here may refuse what the daemon takes; files fetched from there may be of "
         "formats that only the newer creepctl reads"});
  }
  if (info.checkpoint_format() == 0) return;  // a daemon before 0.2.0 does not tell
  if (info.checkpoint_format() > creep::kCheckpointVersion ||
      info.sample_log_format() > creep::kSampleLogVersion) {
    findings.push_back(
        {Grade::kWarning,
         absl::StrCat("the daemon writes checkpoint format ", info.checkpoint_format(),
                      " and sample log format ", info.sample_log_format()),
         absl::StrCat("this creepctl reads up to ", creep::kCheckpointVersion, " and ",
                      creep::kSampleLogVersion, ": upgrade it before it is to use what it fetches")});
  }
  if (info.arithmetic_id() != creep::arithmetic_id("")) {
    findings.push_back({Grade::kWarning,
                        absl::StrCat("the daemon computes with arithmetic ", info.arithmetic_id()),
                        "digests of runs here and there differ; a run does not go on from one to the other"});
  }
}

void look_at_server(const api::ServerInfo& info, double milliseconds, std::vector<Finding>& findings) {
  findings.push_back({Grade::kGood,
                      absl::StrFormat("creepd %s answers in %.1f ms, up since %s", info.version(),
                                      milliseconds, instant(info.start_time().seconds())),
                      ""});
  look_at_versions(info, findings);
  findings.push_back(
      {Grade::kGood,
       absl::StrFormat("%d of %d slots in use, %d threads each, %d queued, %d watchers", info.running(),
                       info.slots(), info.threads_per_job(), info.queued(), info.watchers()),
       ""});
  findings.push_back({Grade::kGood,
                      absl::StrFormat("memory for running jobs: %.1f GiB",
                                      static_cast<double>(info.memory_limit_bytes()) / kGibibyte),
                      ""});
  const bool room = info.free_bytes() >= kLittleRoom;
  findings.push_back(
      {room ? Grade::kGood : Grade::kBad,
       absl::StrFormat("%.1f GiB free in %s", static_cast<double>(info.free_bytes()) / kGibibyte,
                       info.state_directory()),
       room ? "" : "jobs are paused when it is full: delete old ones ('creepctl delete')"});
}

void look_at_jobs(Connection& connection, std::vector<Finding>& findings) {
  api::ListJobsRequest request;
  request.add_states(api::PAUSED);
  request.add_states(api::FAILED);
  std::vector<api::Job> jobs;
  if (!list_jobs(connection, request, 0, jobs).ok()) return;
  std::size_t failed = 0, storage = 0;
  for (const api::Job& job : jobs) {
    if (job.state() == api::FAILED) ++failed;
    if (job.state_reason() == api::DISK_FULL || job.state_reason() == api::IO_ERROR) ++storage;
  }
  if (failed > 0) {
    findings.push_back({Grade::kWarning, absl::StrCat(failed, " failed jobs"), "creepctl ls --state failed"});
  }
  if (storage > 0) {
    findings.push_back({Grade::kBad, absl::StrCat(storage, " jobs paused because the storage failed"),
                        "make room, or repair it and 'creepctl resume' them"});
  }
}

int look_at_daemon(const Options& options, std::vector<Finding>& findings) {
  const auto connection = Connection::open(options.server);
  if (!connection.ok()) {
    findings.push_back({Grade::kBad, std::string(connection.status().message()), ""});
    return kUnreachable;
  }
  (*connection)->set_patience(std::chrono::seconds(2));
  api::ServerInfo info;
  CallResult result = (*connection)->call(api::GetServerInfoRequest(), info);
  if (!result.ok()) {
    findings.push_back({Grade::kBad,
                        absl::StrCat("no daemon at ", (*connection)->target(), ": ", result.status.message()),
                        "start it with 'creepd', or name another with --server"});
    return exit_code_of(result);
  }
  const auto asked = std::chrono::steady_clock::now();  // now that the connection stands
  result = (*connection)->call(api::GetServerInfoRequest(), info);
  const std::chrono::duration<double, std::milli> answered = std::chrono::steady_clock::now() - asked;
  look_at_server(info, answered.count(), findings);
  look_at_jobs(**connection, findings);
  return kOk;
}

void print(const std::vector<Finding>& findings) {
  for (const Finding& finding : findings) {
    const std::string mark = finding.grade == Grade::kGood      ? "ok  "
                             : finding.grade == Grade::kWarning ? yellow("warn", stdout)
                                                                : red("BAD ", stdout);
    std::printf("%s  %s\n", mark.c_str(), finding.what.c_str());
    if (!finding.advice.empty()) std::printf("      %s\n", finding.advice.c_str());
  }
}

void print_as_json(const std::vector<Finding>& findings) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Finding& finding : findings) {
    const char* grade = finding.grade == Grade::kGood      ? "ok"
                        : finding.grade == Grade::kWarning ? "warning"
                                                           : "bad";
    list.push_back({{"grade", grade}, {"what", finding.what}, {"advice", finding.advice}});
  }
  print_json(list);
}

int doctor(const Options& options) {
  std::vector<Finding> findings;
  look_at_programs(findings);
  const int exit_code = look_at_daemon(options, findings);
  options.json ? print_as_json(findings) : print(findings);
  if (exit_code != kOk) return exit_code;
  for (const Finding& finding : findings) {
    if (finding.grade == Grade::kBad) return kFailed;
  }
  return kOk;
}

}  // namespace

void add_doctor(CLI::App& app, int& exit_code) {
  CLI::App* command =
      app.add_subcommand("doctor", "Looks whether everything is in order here and at the daemon");
  auto options = std::make_shared<Options>();
  command->add_flag("--json", options->json, "Print JSON");
  add_server_options(*command, options->server);
  command->footer(
      "Exit code 0: all is well; 1: something is bad; 4: no daemon.\n\n"
      "Example:\n  creepctl doctor");
  command->callback([options, &exit_code] { exit_code = doctor(*options); });
}

}  // namespace creepctl
