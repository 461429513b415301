#include "client/local/worker_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace creepctl {
namespace {

constexpr int kPipeInWorker = 3;

absl::Status cannot(const std::string& what, int error_number) {
  return absl::UnavailableError(absl::StrCat("cannot ", what, ": ", std::strerror(error_number)));
}

std::filesystem::path worker_program() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / "creep-worker";
}

/// The child's descriptors: nothing to read, stderr to the log, the pipe.
absl::StatusOr<pid_t> spawn(const std::filesystem::path& program, std::vector<std::string>& arguments,
                            const std::filesystem::path& log, int pipe_end, const sigset_t& signal_mask) {
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_APPEND,
                                     0644);
  ::posix_spawn_file_actions_adddup2(&actions, pipe_end, kPipeInWorker);  // without close-on-exec
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  ::posix_spawnattr_setsigmask(&attributes, &signal_mask);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);

  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  pid_t process = -1;
  const int result =
      ::posix_spawn(&process, program.c_str(), &actions, &attributes, pointers.data(), environ);
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&actions);
  if (result != 0) return cannot(absl::StrCat("start ", program.string()), result);
  return process;
}

}  // namespace

absl::StatusOr<WorkerProcess> WorkerProcess::start(std::vector<std::string> arguments,
                                                   const std::filesystem::path& log) {
  const auto program = worker_program();
  if (::access(program.c_str(), X_OK) != 0) return cannot(absl::StrCat("start ", program.string()), errno);
  WorkerProcess worker;
  sigset_t watched;
  sigset_t before;
  ::sigemptyset(&watched);
  for (const int signal : {SIGINT, SIGTERM, SIGCHLD}) ::sigaddset(&watched, signal);
  struct sigaction hangup {};
  if (::sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN)
    ::sigaddset(&watched, SIGHUP);
  if (::sigprocmask(SIG_BLOCK, &watched, &before) != 0) return cannot("block signals", errno);
  // An earlier worker had them blocked already: this one must be able to take them too.
  for (const int signal : {SIGINT, SIGTERM, SIGCHLD, SIGHUP}) ::sigdelset(&before, signal);
  worker.signals_ = ::signalfd(-1, &watched, SFD_CLOEXEC | SFD_NONBLOCK);
  if (worker.signals_ < 0) return cannot("watch signals", errno);
  int ends[2] = {-1, -1};
  if (::pipe2(ends, O_CLOEXEC) != 0) return cannot("make a pipe", errno);
  worker.parent_pipe_ = ends[1];
  arguments.insert(arguments.begin(), "creep-worker");
  arguments.push_back("--parent-pipe");
  arguments.push_back(std::to_string(kPipeInWorker));
  const auto process = spawn(program, arguments, log, ends[0], before);
  ::close(ends[0]);
  if (!process.ok()) return process.status();
  worker.process_ = *process;
  return worker;
}

WorkerProcess::WorkerProcess(WorkerProcess&& other) noexcept
    : process_(std::exchange(other.process_, -1)),
      parent_pipe_(std::exchange(other.parent_pipe_, -1)),
      signals_(std::exchange(other.signals_, -1)),
      stopping_(other.stopping_) {}

WorkerProcess::~WorkerProcess() {
  if (parent_pipe_ >= 0) ::close(parent_pipe_);
  if (signals_ >= 0) ::close(signals_);
}

void WorkerProcess::stop() {
  if (process_ > 0) ::kill(process_, SIGTERM);
  stopping_ = true;
}

std::optional<WorkerEnd> WorkerProcess::wait(std::chrono::milliseconds patience) {
  pollfd watched{signals_, POLLIN, 0};
  ::poll(&watched, 1, static_cast<int>(patience.count()));
  signalfd_siginfo signal{};
  while (::read(signals_, &signal, sizeof signal) == sizeof signal) {
    if (signal.ssi_signo == SIGCHLD) continue;
    stop();
  }
  int status = 0;
  if (process_ <= 0 || ::waitpid(process_, &status, WNOHANG) != process_) return std::nullopt;
  process_ = -1;
  if (WIFSIGNALED(status)) return WorkerEnd{128 + WTERMSIG(status), WTERMSIG(status)};
  return WorkerEnd{WEXITSTATUS(status), 0};
}

}  // namespace creepctl
