// The way to a daemon: the one file of the client that knows gRPC. Messages are those of creep.proto, whose
// comments say what each call does and how it fails.
#pragma once

#include <CLI/CLI.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "creep/v1/creep.pb.h"

namespace creepctl {

namespace api = creep::v1;

struct ServerOptions {
  std::string address;      ///< "" = the daemon of this user
  std::string server_user;  ///< whose socket is trusted beside those of root and of this user; "" = nobody's
  std::string tls_ca, tls_certificate, tls_key;
};

/// --server, --server-user, --tls-ca, --tls-cert and --tls-key, with their environment variables.
void add_server_options(CLI::App& command, ServerOptions& options);

/// "unix:/run/...", or HOST:PORT as given. Errors: InvalidArgument (no address can be made of it).
absl::StatusOr<std::string> server_target(const std::string& address);

/// One thing that is wrong with a request: "spec:3:12", "must be ...".
struct Violation {
  std::string field;
  std::string description;
  int line = 0;  ///< of the job file, from 1; 0 = not a place in it
  int column = 0;
};

/// How a call ended.
struct CallResult {
  absl::Status status;
  std::string reason;  ///< of ErrorInfo (details.proto); "" if the answer did not come from creepd itself
  std::vector<Violation> violations;

  bool ok() const { return status.ok(); }
  /// The daemon went away or could not be reached: trying again can help.
  bool lost() const;
};

/// What a call that failed means for scripts (exit_codes.h).
int exit_code_of(const CallResult& result);

/// The error and all violations on stderr. Violations of the job file read FILE:LINE:COL with `job_file`.
void print_failure(const CallResult& result, const std::string& job_file = "");

/// One stream of messages of the daemon.
template <typename Message>
class Stream {
 public:
  virtual ~Stream() = default;
  /// Waits for the next message; false at the end.
  virtual bool read(Message& message) = 0;
  /// Why it ended; cuts it if it has not.
  virtual CallResult finish() = 0;
};

class Connection {
 public:
  using Deadline = std::optional<std::chrono::system_clock::time_point>;

  /// Connects with the first call. Errors: InvalidArgument (address or certificates), PermissionDenied (the
  /// socket is somebody else's).
  static absl::StatusOr<std::unique_ptr<Connection>> open(const ServerOptions& options);
  virtual ~Connection() = default;

  virtual const std::string& target() const = 0;

  /// A daemon that is not there (UNAVAILABLE) is waited for so long in each call: it may be restarting.
  virtual void set_patience(std::chrono::milliseconds patience) = 0;

  virtual CallResult call(const api::SubmitJobRequest& request, api::SubmitJobResponse& response) = 0;
  virtual CallResult call(const api::ForkJobRequest& request, api::SubmitJobResponse& response) = 0;
  virtual CallResult call(const api::PlanJobRequest& request, api::PlanJobResponse& response) = 0;
  virtual CallResult call(const api::GetJobRequest& request, api::Job& response) = 0;
  virtual CallResult call(const api::ListJobsRequest& request, api::ListJobsResponse& response) = 0;
  virtual CallResult call(const api::PauseJobRequest& request, api::Job& response) = 0;
  virtual CallResult call(const api::ResumeJobRequest& request, api::Job& response) = 0;
  virtual CallResult call(const api::CancelJobRequest& request, api::Job& response) = 0;
  virtual CallResult call(const api::DeleteJobRequest& request, api::DeleteJobResponse& response) = 0;
  virtual CallResult call(const api::DeleteJobsRequest& request, api::DeleteJobsResponse& response) = 0;
  virtual CallResult call(const api::ListAttemptsRequest& request, api::ListAttemptsResponse& response) = 0;
  virtual CallResult call(const api::ListArtifactsRequest& request, api::ListArtifactsResponse& response) = 0;
  virtual CallResult call(const api::ReadCurvesRequest& request, api::Curves& response) = 0;
  virtual CallResult call(const api::GetServerInfoRequest& request, api::ServerInfo& response) = 0;

  /// Streams are not repeated by themselves.
  virtual std::unique_ptr<Stream<api::Event>> watch(const api::WatchJobRequest& request,
                                                    Deadline deadline) = 0;
  virtual std::unique_ptr<Stream<api::ArtifactChunk>> fetch(const api::FetchArtifactRequest& request) = 0;
};

/// Opens the connection and runs the command with it; a failure to open is printed. Gives the exit code.
int with_connection(const ServerOptions& options, const std::function<int(Connection&)>& command);

}  // namespace creepctl
