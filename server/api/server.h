// The open doors of the daemon: a unix socket whose callers the kernel names and, if asked for, TCP with
// certificates on both sides. No gRPC in this header.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/folders/sample_index.h"
#include "server/jobs/jobs.h"
#include "server/store/job_changes.h"
#include "server/store/job_store.h"

namespace creepd {

struct TlsOptions {
  std::string address;  ///< HOST:PORT
  std::filesystem::path certificate;
  std::filesystem::path key;
  std::filesystem::path client_ca;  ///< who signs the certificates of callers
};

struct ServerOptions {
  std::filesystem::path socket;
  std::vector<uid_t> users;  ///< beside root and the daemon's own
  std::optional<TlsOptions> tls;
  // Told by GetServerInfo:
  std::filesystem::path state;
  int slots = 1;
  int threads_per_job = 1;
  double checkpoint_interval = 30.0;
};

class Server {
 public:
  /// Errors: InvalidArgument (socket path, certificates), AlreadyExists (somebody listens there),
  /// Unavailable.
  static absl::StatusOr<std::unique_ptr<Server>> start(const ServerOptions& options, Jobs& jobs,
                                                       JobStore& store, SampleLibrary& samples,
                                                       JobChanges& changes);
  ~Server();

  /// Calls are refused from now on; watch streams go on, so that they show how jobs are stopped.
  void refuse_calls();
  /// Ends the streams, closes the doors.
  void stop();

 private:
  struct Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace creepd
