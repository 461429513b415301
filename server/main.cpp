// creepd: serves the queue of creep jobs until it is told to stop.
#include <pwd.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "absl/strings/str_cat.h"
#include "core/state/program_version.h"
#include "server/api/server.h"
#include "server/execution/local_executor.h"
#include "server/execution/supervisor.h"
#include "server/folders/sample_index.h"
#include "server/host/daemon_log.h"
#include "server/host/service_state.h"
#include "server/host/state_folder.h"
#include "server/jobs/jobs.h"
#include "server/store/job_changes.h"
#include "server/store/job_store.h"

namespace {

namespace fs = std::filesystem;

constexpr int kFailed = 1;
constexpr int kUsage = 2;

constexpr const char* kFooter =
    "Jobs survive: kill creepd, its workers or the machine, and every job that was acknowledged goes on from "
    "its\n"
    "newest good checkpoint. SIGTERM has the workers checkpoint first; a second one does not wait for them.\n"
    "Over TCP only callers with a certificate of --tls-client-ca are served; their jobs belong to its "
    "name.\n\n"
    "Example:\n  creepd --state /var/lib/creepd --slots 2";

struct Options {
  fs::path state;
  std::vector<std::string> users;
  creepd::LocalExecutorOptions executor;
  creepd::SupervisorOptions supervisor;
  creepd::JobLimits limits;
  creepd::ServerOptions server;
};

/// $NAME, or nothing if it is not set or empty.
std::optional<fs::path> environment(const char* name) {
  const char* const value = std::getenv(name);
  if (value == nullptr || *value == '\0') return std::nullopt;
  return fs::path(value);
}

fs::path home() { return environment("HOME").value_or("/"); }

fs::path default_socket() {
  if (const auto runtime = environment("XDG_RUNTIME_DIR")) return *runtime / "creepd.sock";
  if (::access("/run/creepd", W_OK) == 0) return "/run/creepd/creepd.sock";
  return home() / ".creepd" / "creepd.sock";
}

fs::path default_state() {
  if (const auto state = environment("XDG_STATE_HOME")) return *state / "creepd";
  return home() / ".local" / "state" / "creepd";
}

std::uint64_t machine_memory() {
  return static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
         static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

/// As whom the kernel shows a caller whose number has no place in our user namespace; man 5 proc.
uid_t overflow_user() {
  uid_t number = 65534;
  std::ifstream("/proc/sys/kernel/overflowuid") >> number;
  return number;
}

absl::StatusOr<uid_t> user_number(const std::string& name) {
  if (!name.empty() && name.find_first_not_of("0123456789") == std::string::npos) {
    uid_t number = 0;
    const auto parsed = std::from_chars(name.data(), name.data() + name.size(), number);
    if (parsed.ec == std::errc() && number != static_cast<uid_t>(-1)) return number;
    return absl::InvalidArgumentError(absl::StrCat("--allow-user: ", name, " is no number of a user"));
  }
  const passwd* const entry = ::getpwnam(name.c_str());
  if (entry == nullptr)
    return absl::InvalidArgumentError(absl::StrCat("--allow-user: there is no user ", name));
  return entry->pw_uid;
}

absl::StatusOr<uid_t> user_id(const std::string& name) {
  const auto number = user_number(name);
  if (!number.ok() || *number != overflow_user()) return number;
  return absl::InvalidArgumentError(absl::StrCat(
      "--allow-user: ", name, " is who the kernel says for every user whose number it cannot map, as from ",
      "another user namespace: that would let in many, each to the jobs of the others"));
}

/// Of a number given as an option: more is a slip of the keyboard.
constexpr std::int64_t kMost = std::int64_t{1} << 50;

void set_defaults(Options& options) {
  std::error_code error;
  const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  options.state = default_state();
  options.server.socket = default_socket();
  options.executor.worker = fs::read_symlink("/proc/self/exe", error).parent_path() / "creep-worker";
  options.supervisor.threads_per_job = std::min(2, cores);
  options.executor.slots = std::max(1, cores / options.supervisor.threads_per_job);
  options.limits.memory = machine_memory() / 5 * 4;
}

void add_options(CLI::App& app, Options& options, creepd::TlsOptions& tls) {
  app.add_option("--state", options.state, "Folder of the queue and of all jobs")->capture_default_str();
  app.add_option("--socket", options.server.socket, "Unix socket to serve")->capture_default_str();
  app.add_option(
      "--allow-user", options.users,
      "User, by name or number, who may use the socket beside root and the user of creepd; repeatable");
  app.add_option("--slots", options.executor.slots, "Jobs that run at once")->check(CLI::Range(1, 1024));
  app.add_option("--threads-per-job", options.supervisor.threads_per_job, "Threads of each worker")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--checkpoint-interval", options.supervisor.checkpoint_interval,
                 "Most seconds between checkpoints")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str();
  app.add_option("--memory", options.limits.memory,
                 "Bytes for all running jobs together (default: 80 % of the machine)")
      ->check(CLI::Range(std::int64_t{0}, kMost));
  app.add_option("--stall-limit", options.supervisor.stall_limit,
                 "Seconds without progress after which a worker is killed and its job tried again")
      ->check(CLI::Range(1.0, 1e6))
      ->capture_default_str();
  app.add_option("--least-free", options.limits.least_free, "Bytes of free space below which no job is taken")
      ->check(CLI::Range(std::int64_t{0}, kMost))
      ->capture_default_str();
  app.add_option("--max-jobs", options.limits.most_unfinished, "Most jobs that are not finished")
      ->check(CLI::Range(std::int64_t{0}, kMost))
      ->capture_default_str();
  app.add_option("--listen", tls.address, "HOST:PORT to serve over TCP too, with certificates on both sides");
  app.add_option("--tls-cert", tls.certificate, "Certificate of this daemon (PEM)");
  app.add_option("--tls-key", tls.key, "Key of the certificate (PEM)");
  app.add_option("--tls-client-ca", tls.client_ca, "Who signs the certificates of callers (PEM)");
  app.add_option("--worker", options.executor.worker, "Program that computes a job")->group("");
  app.set_version_flag("--version", "creepd " + std::string(creep::program_version()));
}

absl::Status make_absolute(const char* option, fs::path& path) {
  if (path.empty()) return absl::InvalidArgumentError(absl::StrCat(option, " needs a path, and got none"));
  std::error_code error;
  fs::path absolute = fs::absolute(path, error);
  if (error) {
    return absl::InvalidArgumentError(absl::StrCat(option, " ", path.string(), ": the working directory: ",
                                                   error.message(), "; give a path that begins with /"));
  }
  path = std::move(absolute);
  return absl::OkStatus();
}

absl::Status complete(Options& options, const creepd::TlsOptions& tls, bool slots_given) {
  if (!slots_given) {
    const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    options.executor.slots = std::max(1, cores / options.supervisor.threads_per_job);
  }
  for (const std::string& name : options.users) {
    const auto user = user_id(name);
    if (!user.ok()) return user.status();
    options.server.users.push_back(*user);
  }
  const bool certificates = !tls.certificate.empty() && !tls.key.empty() && !tls.client_ca.empty();
  const bool any = !tls.certificate.empty() || !tls.key.empty() || !tls.client_ca.empty();
  if (!tls.address.empty() && !certificates) {
    return absl::InvalidArgumentError(
        "--listen needs --tls-cert, --tls-key and --tls-client-ca: there is no TCP without them");
  }
  if (tls.address.empty() && any)
    return absl::InvalidArgumentError("--tls-... is of use only with --listen HOST:PORT");
  if (!tls.address.empty()) options.server.tls = tls;
  if (::access(options.executor.worker.c_str(), X_OK) != 0) {
    return absl::InvalidArgumentError(absl::StrCat("there is no program ", options.executor.worker.string()));
  }
  for (const auto& [option, path] :
       {std::pair("--state", &options.state), std::pair("--socket", &options.server.socket)}) {
    if (auto status = make_absolute(option, *path); !status.ok()) return status;
  }
  options.supervisor.jobs = options.state / "jobs";
  options.executor.memory_limit = options.limits.memory;
  options.limits.threads = options.supervisor.threads_per_job;
  options.server.state = options.state;
  options.server.slots = options.executor.slots;
  options.server.threads_per_job = options.supervisor.threads_per_job;
  options.server.checkpoint_interval = options.supervisor.checkpoint_interval;
  return absl::OkStatus();
}

sigset_t stop_signals() {
  sigset_t signals;
  ::sigemptyset(&signals);
  ::sigaddset(&signals, SIGTERM);
  ::sigaddset(&signals, SIGINT);
  return signals;
}

void wait_and_stop(creepd::Supervisor& supervisor, creepd::Server& server,
                   const creepd::ServiceState& service) {
  const sigset_t signals = stop_signals();
  int number = 0;
  while (::sigwait(&signals, &number) != 0) {
  }
  creepd::log_line("stopping: workers write a checkpoint");
  service.stopping();
  std::atomic<bool> stopped = false;
  std::thread stopping([&] {
    server.refuse_calls();
    supervisor.stop();
    server.stop();
    stopped = true;
  });
  const timespec moment{0, 100'000'000};
  while (!stopped) {
    if (::sigtimedwait(&signals, nullptr, &moment) > 0) supervisor.hurry();
  }
  stopping.join();
}

absl::Status serve(const Options& options) {
  std::error_code ignored;
  if (fs::create_directories(options.server.socket.parent_path(), ignored)) {
    ::chmod(options.server.socket.parent_path().c_str(), 0700);
  }
  creepd::JobChanges changes;
  const auto store = creepd::JobStore::open(options.state / "creepd.db",
                                            [&changes](const std::string& job) { changes.tell(job); });
  if (!store.ok()) return store.status();
  creepd::SampleLibrary samples(options.supervisor.jobs);
  creepd::ServiceState service;
  service.recovering();
  creepd::SupervisorOptions supervision = options.supervisor;
  supervision.turned = [&](int running) { service.turned(running, options.executor.slots); };
  creepd::LocalExecutor executor(options.executor);
  creepd::Supervisor supervisor(std::move(supervision), **store, samples, executor);
  // Only then may anybody ask: what they are told is true.
  if (auto status = supervisor.recover(); !status.ok()) return status;
  creepd::Jobs jobs(options.supervisor.jobs, options.limits, **store, samples, [&] { supervisor.wake(); });
  const auto server = creepd::Server::start(options.server, jobs, **store, samples, changes);
  if (!server.ok()) return server.status();
  supervisor.start();
  creepd::log_line(absl::StrCat("ready on ", options.server.socket.string(),
                                options.server.tls ? " and " + options.server.tls->address : "",
                                ", state in ", options.state.string(), ", ", options.executor.slots,
                                " slots of ", options.supervisor.threads_per_job, " threads"));
  service.ready();
  wait_and_stop(supervisor, **server, service);
  creepd::log_line("stopped");
  return absl::OkStatus();
}

}  // namespace

int main(int argument_count, char** arguments) {
  CLI::App app{
      "Queues creep jobs, runs each in a worker of its own, keeps them across crashes and streams their "
      "progress.",
      "creepd"};
  app.footer(kFooter);
  Options options;
  creepd::TlsOptions tls;
  set_defaults(options);
  add_options(app, options, tls);
  try {
    app.parse(argument_count, arguments);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsage;
  }
  if (auto status = complete(options, tls, app.count("--slots") > 0); !status.ok()) {
    creepd::log_line(std::string(status.message()));
    return kUsage;
  }
  const sigset_t signals = stop_signals();
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);  // before any thread: they are taken in one place
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGXFSZ, SIG_IGN);
  ::umask(0077);  // what is made is nobody else's to read, wherever the folder is moved later
  const auto state = creepd::StateFolder::take(options.state);
  if (!state.ok()) {
    creepd::log_line(std::string(state.status().message()));
    return absl::IsFailedPrecondition(state.status()) ? kUsage : kFailed;
  }
  if (auto status = serve(options); !status.ok()) {
    creepd::log_line(std::string(status.message()));
    return kFailed;
  }
  return 0;
}
