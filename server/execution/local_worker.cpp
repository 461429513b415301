#include "server/execution/local_worker.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/folder/durable_file.h"
#include "core/folder/job_directory.h"

namespace creepd {
namespace {

constexpr int kPipeInWorker = 3;
constexpr int kNicer = 5;

absl::StatusOr<pid_t> spawn(const std::filesystem::path& program, std::vector<std::string> arguments,
                            int output, int pipe_end) {
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, output, STDERR_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, pipe_end, kPipeInWorker);  // without close-on-exec
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  // Blocked until the worker listens: one that is asked to stop at once hears of it, and dies of nothing.
  sigset_t stops;
  sigset_t all;
  ::sigemptyset(&stops);
  ::sigaddset(&stops, SIGTERM);
  ::sigfillset(&all);
  ::posix_spawnattr_setsigmask(&attributes, &stops);
  ::posix_spawnattr_setsigdefault(&attributes, &all);
  ::posix_spawnattr_setpgroup(&attributes, 0);
  ::posix_spawnattr_setflags(&attributes,
                             POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  std::vector<char*> pointers;
  pointers.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  pid_t process = -1;
  const int result =
      ::posix_spawn(&process, program.c_str(), &actions, &attributes, pointers.data(), environ);
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&actions);
  if (result != 0) return creep::errno_status(absl::StrCat("start ", program.string()), result);
  return process;
}

}  // namespace

absl::StatusOr<LocalWorker> LocalWorker::start(const WorkerCommand& command) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return creep::errno_status("pipe", errno);
  creep::FileDescriptor reading(ends[0]);
  creep::FileDescriptor writing(ends[1]);
  auto output =
      creep::open_file(creep::JobDirectory(command.folder).worker_log(), O_WRONLY | O_CREAT | O_APPEND);
  if (!output.ok())
    output = creep::open_file("/dev/null", O_WRONLY);  // a full disk: the worker will say so by its exit code
  if (!output.ok()) return output.status();
  const auto id =
      spawn(command.program,
            {command.program.string(), command.folder.string(), "--attempt", absl::StrCat(command.attempt),
             "--threads", absl::StrCat(command.threads), "--parent-pipe", absl::StrCat(kPipeInWorker),
             "--checkpoint-interval", absl::StrCat(command.checkpoint_interval)},
            output->get(), reading.get());
  if (!id.ok()) return id.status();
  // By number: the header of Debian 12 declares pidfd_open() without C linkage. Close-on-exec by itself.
  creep::FileDescriptor process(static_cast<int>(::syscall(SYS_pidfd_open, *id, 0)));
  const int niceness = ::getpriority(PRIO_PROCESS, 0);
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(*id), std::min(19, niceness + kNicer));
  return LocalWorker(*id, std::move(process), std::move(writing));
}

void LocalWorker::send(int signal_number) const { ::kill(id_, signal_number); }

std::optional<ProcessEnd> LocalWorker::poll() {
  int status = 0;
  const pid_t ended = ::waitpid(id_, &status, WNOHANG);
  if (ended == 0 || (ended < 0 && errno == EINTR)) return std::nullopt;
  if (ended < 0) return ProcessEnd{};
  if (WIFEXITED(status)) return ProcessEnd{WEXITSTATUS(status), std::nullopt};
  return ProcessEnd{std::nullopt, WTERMSIG(status)};
}

}  // namespace creepd
