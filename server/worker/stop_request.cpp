#include "server/worker/stop_request.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/signalfd.h>

#include <cerrno>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "core/folder/durable_file.h"

namespace creepd {

absl::StatusOr<StopRequest> StopRequest::listen(std::optional<int> parent_pipe) {
  sigset_t asked;
  ::sigemptyset(&asked);
  ::sigaddset(&asked, SIGTERM);
  ::sigaddset(&asked, SIGINT);
  struct sigaction hangup {};
  if (::sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN) ::sigaddset(&asked, SIGHUP);
  if (::pthread_sigmask(SIG_BLOCK, &asked, nullptr) != 0) return creep::errno_status("block signals", errno);
  creep::FileDescriptor signals(::signalfd(-1, &asked, SFD_NONBLOCK | SFD_CLOEXEC));
  if (!signals.open()) return creep::errno_status("signalfd", errno);
  creep::FileDescriptor parent(parent_pipe.value_or(-1));
  if (parent_pipe && ::fcntl(*parent_pipe, F_SETFL, O_NONBLOCK) != 0)
    return creep::errno_status("--parent-pipe", errno);
  return StopRequest(std::move(signals), std::move(parent));
}

std::optional<std::string> StopRequest::poll() {
  if (!request_.empty()) return request_;
  signalfd_siginfo signal{};
  if (::read(signals_.get(), &signal, sizeof signal) == sizeof signal) {
    request_ = absl::StrCat("SIG", ::sigabbrev_np(static_cast<int>(signal.ssi_signo)));
  } else if (parent_.open()) {
    char byte = 0;
    const ssize_t got = ::read(parent_.get(), &byte, 1);
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) request_ = "end of the parent's pipe";
  }
  if (request_.empty()) return std::nullopt;
  return request_;
}

}  // namespace creepd
