// creep-worker: computes the job of one directory. One process, no network.
#include <signal.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <thread>

#include <CLI/CLI.hpp>

#include "core/folder/ending.h"
#include "server/worker/worker.h"

namespace {

constexpr const char* kFooter =
    "Exit codes: 0 done; 75 checkpointed after SIGTERM, SIGINT or the end of the parent's pipe, run again; "
    "65 bad\n"
    "input; 74 input or output failed, the last good checkpoint stands; 70 stopped by a guard, a sample "
    "mismatch or a\n"
    "refused resume; 69 another worker holds the directory; 64 usage; anything else is a crash.\n\n"
    "Example:\n  creep-worker /var/tmp/job --threads 2";

/// A closed terminal or a file size limit is reported by the call that meets it.
void report_instead_of_dying() {
  struct sigaction ignore {};
  ignore.sa_handler = SIG_IGN;
  ::sigaction(SIGPIPE, &ignore, nullptr);
  ::sigaction(SIGXFSZ, &ignore, nullptr);
}

}  // namespace

int main(int argument_count, char** arguments) {
  CLI::App app{"Computes the job of one directory: DIR/job.toml, continued from its newest checkpoint.",
               "creep-worker"};
  app.footer(kFooter);
  creepd::WorkerOptions options;
  options.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  if (const char* wish = std::getenv("CREEP_ISA")) options.instruction_set = wish;
  std::string directory;
  std::optional<int> parent_pipe;
  app.add_option("DIR", directory, "Job directory")->required()->check(CLI::ExistingDirectory);
  app.add_option("--threads", options.threads, "Threads")->check(CLI::Range(1, 1024))->capture_default_str();
  app.add_option("--instruction-set", options.instruction_set,
                 "portable, avx2 or avx512 (default: CREEP_ISA, else the widest the processor has)");
  app.add_flag("--allow-inexact", options.allow_inexact,
               "Continue although this machine computes other bits; is recorded");
  app.add_option("--attempt", options.attempt, "Number of this attempt (default: one more than the last)")
      ->check(CLI::PositiveNumber);
  app.add_option("--parent-pipe", parent_pipe,
                 "Descriptor of a pipe whose end means: checkpoint and exit 75");
  app.add_option("--checkpoint-interval", options.checkpoint_interval, "Most seconds between checkpoints")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str();
  app.add_flag("--profile", options.profile, "Look where the time goes: profile.csv; never changes a result");
  app.add_option("--rebuild-every", options.rebuild_every, "Search neighbours every so many cycles")
      ->check(CLI::NonNegativeNumber)
      ->group("");
  try {
    app.parse(argument_count, arguments);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? creep::kDone : creep::kUsage;
  }
  options.directory = directory;
  report_instead_of_dying();
  auto stop = creepd::StopRequest::listen(parent_pipe);
  if (!stop.ok()) {
    std::fprintf(stderr, "creep-worker: %s\n", std::string(stop.status().message()).c_str());
    return creep::kUsage;
  }
  return creepd::work(options, *stop);
}
