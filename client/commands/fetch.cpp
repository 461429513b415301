#include "client/commands/commands.h"

#include <cstdio>
#include <memory>

#include "client/remote/artifacts.h"
#include "client/remote/connection.h"
#include "client/remote/message_json.h"
#include "client/remote/remote_job.h"
#include "client/terminal/exit_codes.h"
#include "client/terminal/terminal.h"

namespace creepctl {
namespace {

struct Options {
  ServerOptions server;
  std::string id;
  std::string out;
  bool json = false;
};

void print_files(const std::string& id, const Options& options, const std::vector<FetchedFile>& files) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const FetchedFile& file : files) {
    list.push_back(
        {{"name", file.name}, {"size_bytes", file.size_bytes}, {"fetched_bytes", file.fetched_bytes}});
  }
  print_json({{"job", id}, {"directory", options.out}, {"files", list}});
}

int fetch(const Options& options, Connection& connection) {
  api::Job job;
  CallResult result = find_job(connection, options.id, job);
  if (!result.ok()) {
    print_failure(result);
    return exit_code_of(result);
  }
  std::vector<FetchedFile> files;
  const auto say = [&](const FetchedFile& file) {
    if (options.json) return;
    std::printf("%12llu  %s%s\n", static_cast<unsigned long long>(file.size_bytes), file.name.c_str(),
                file.fetched_bytes == 0 && file.size_bytes > 0 ? "  (there already)" : "");
  };
  result = fetch_all(connection, job.id(), options.out, say, files);
  if (!result.ok()) {
    print_failure(result);
    const bool disk = absl::IsResourceExhausted(result.status) && result.reason.empty();
    return disk ? kIoError : exit_code_of(result);
  }
  if (options.json) print_files(job.id(), options, files);
  const std::vector<std::string> faults = verify_fetched(job, options.out);
  for (const std::string& fault : faults) complain(fault);
  if (!faults.empty()) return kFailed;
  if (!options.json) std::printf("All there and verified. Next: creepctl report %s\n", options.out.c_str());
  return kOk;
}

}  // namespace

void add_fetch(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("fetch", "Brings all files of a job");
  auto options = std::make_shared<Options>();
  command->add_option("ID", options->id, "The job, or the beginning of its id")->required();
  command->add_option("--out", options->out, "The directory to bring them to")->required();
  command->add_flag("--json", options->json, "Print the files as JSON");
  add_server_options(*command, options->server);
  command->footer(
      "Cut short, the same command goes on where it stopped; of a running job, it brings what is new. The\n"
      "directory can then be plotted and reported like that of 'creepctl run'.\n"
      "Exit code 0: all there and verified; 1: something is damaged; 4: no daemon; 5: no such job, or DIR\n"
      "holds something else; 74: DIR cannot be written.\n\n"
      "Example:\n  creepctl fetch 3f2a --out creep-2d && creepctl report creep-2d");
  command->callback([options, &exit_code] {
    exit_code =
        with_connection(options->server, [&](Connection& connection) { return fetch(*options, connection); });
  });
}

}  // namespace creepctl
