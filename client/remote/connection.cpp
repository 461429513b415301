#include "client/remote/connection.h"

#include <grpcpp/grpcpp.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <thread>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/local/run_folder.h"
#include "client/remote/socket_owner.h"
#include "client/terminal/exit_codes.h"
#include "client/terminal/terminal.h"
#include "creep/v1/creep.grpc.pb.h"
#include "creep/v1/details.pb.h"

namespace creepctl {
namespace {

using Clock = std::chrono::system_clock;
using Stub = api::CreepService::StubInterface;

constexpr std::chrono::seconds kCallDeadline{30};
constexpr std::size_t kLongestSocketPath = 107;  // bytes in sockaddr_un, less the final zero

CallResult result_of(const grpc::Status& status) {
  CallResult result;
  if (status.ok()) return result;
  // The codes of gRPC and of absl::Status are the same numbers.
  result.status = absl::Status(static_cast<absl::StatusCode>(status.error_code()), status.error_message());
  api::details::Status details;
  if (!details.ParseFromString(status.error_details())) return result;
  for (const google::protobuf::Any& detail : details.details()) {
    api::details::ErrorInfo info;
    api::details::BadRequest bad_request;
    if (absl::EndsWith(detail.type_url(), "/google.rpc.ErrorInfo") && info.ParseFromString(detail.value())) {
      result.reason = info.reason();
    } else if (absl::EndsWith(detail.type_url(), "/google.rpc.BadRequest") &&
               bad_request.ParseFromString(detail.value())) {
      for (const auto& violation : bad_request.field_violations()) {
        result.violations.push_back(
            {violation.field(), violation.description(), violation.line(), violation.column()});
      }
    }
  }
  return result;
}

template <typename Message>
class GrpcStream final : public Stream<Message> {
 public:
  template <typename Start>
  GrpcStream(Connection::Deadline deadline, Start start) {
    if (deadline) context_.set_deadline(*deadline);
    reader_ = start(context_);
  }
  ~GrpcStream() override {
    if (!finished_) finish();
  }
  bool read(Message& message) override {
    at_end_ = !reader_->Read(&message);
    return !at_end_;
  }
  CallResult finish() override {
    if (!at_end_) context_.TryCancel();
    for (Message unread; !at_end_;) at_end_ = !reader_->Read(&unread);
    finished_ = true;
    return result_of(reader_->Finish());
  }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderInterface<Message>> reader_;
  bool at_end_ = false;
  bool finished_ = false;
};

class GrpcConnection final : public Connection {
 public:
  GrpcConnection(std::string target, const std::shared_ptr<grpc::ChannelCredentials>& credentials)
      : target_(std::move(target)) {
    grpc::ChannelArguments arguments;
    // The defaults wait up to two minutes before the next attempt to connect.
    arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
    arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 5000);
    arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2000);
    // A forwarded connection can die without a word.
    arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 30000);
    arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 15000);
    arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
    channel_ = grpc::CreateCustomChannel(target_, credentials, arguments);
    stub_ = api::CreepService::NewStub(channel_);
  }

  const std::string& target() const override { return target_; }
  void set_patience(std::chrono::milliseconds patience) override { patience_ = patience; }

  CallResult call(const api::SubmitJobRequest& request, api::SubmitJobResponse& response) override {
    return repeat(&Stub::SubmitJob, request, response);
  }
  CallResult call(const api::ForkJobRequest& request, api::SubmitJobResponse& response) override {
    return repeat(&Stub::ForkJob, request, response);
  }
  CallResult call(const api::PlanJobRequest& request, api::PlanJobResponse& response) override {
    return repeat(&Stub::PlanJob, request, response);
  }
  CallResult call(const api::GetJobRequest& request, api::Job& response) override {
    return repeat(&Stub::GetJob, request, response);
  }
  CallResult call(const api::ListJobsRequest& request, api::ListJobsResponse& response) override {
    return repeat(&Stub::ListJobs, request, response);
  }
  CallResult call(const api::PauseJobRequest& request, api::Job& response) override {
    return repeat(&Stub::PauseJob, request, response);
  }
  CallResult call(const api::ResumeJobRequest& request, api::Job& response) override {
    return repeat(&Stub::ResumeJob, request, response);
  }
  CallResult call(const api::CancelJobRequest& request, api::Job& response) override {
    return repeat(&Stub::CancelJob, request, response);
  }
  CallResult call(const api::DeleteJobRequest& request, api::DeleteJobResponse& response) override {
    return repeat(&Stub::DeleteJob, request, response);
  }
  CallResult call(const api::DeleteJobsRequest& request, api::DeleteJobsResponse& response) override {
    return repeat(&Stub::DeleteJobs, request, response);
  }
  CallResult call(const api::ListAttemptsRequest& request, api::ListAttemptsResponse& response) override {
    return repeat(&Stub::ListAttempts, request, response);
  }
  CallResult call(const api::ListArtifactsRequest& request, api::ListArtifactsResponse& response) override {
    return repeat(&Stub::ListArtifacts, request, response);
  }
  CallResult call(const api::ReadCurvesRequest& request, api::Curves& response) override {
    return repeat(&Stub::ReadCurves, request, response);
  }
  CallResult call(const api::GetServerInfoRequest& request, api::ServerInfo& response) override {
    return repeat(&Stub::GetServerInfo, request, response);
  }

  std::unique_ptr<Stream<api::Event>> watch(const api::WatchJobRequest& request, Deadline deadline) override {
    connect();
    return std::make_unique<GrpcStream<api::Event>>(
        deadline, [&](grpc::ClientContext& context) { return stub_->WatchJob(&context, request); });
  }
  std::unique_ptr<Stream<api::ArtifactChunk>> fetch(const api::FetchArtifactRequest& request) override {
    connect();
    return std::make_unique<GrpcStream<api::ArtifactChunk>>(
        std::nullopt, [&](grpc::ClientContext& context) { return stub_->FetchArtifact(&context, request); });
  }

 private:
  /// Before each call that may find no connection: gRPC looks after one that nobody waits for only every five
  /// seconds.
  void connect() { channel_->WaitForConnected(Clock::now() + std::chrono::milliseconds(200)); }

  /// Every change is idempotent (creep.proto), so an answer that was lost is asked for again.
  template <typename Method, typename Request, typename Response>
  CallResult repeat(Method method, const Request& request, Response& response) {
    const auto give_up = Clock::now() + patience_;
    for (bool said = false;;) {
      grpc::ClientContext context;
      context.set_deadline(Clock::now() + kCallDeadline);
      response.Clear();
      connect();
      CallResult result = result_of(((*stub_).*method)(&context, request, &response));
      if (!result.lost() || Clock::now() >= give_up) return result;
      if (!said && patience_ >= std::chrono::seconds(5)) {
        complain(absl::StrCat("no answer at ", target_, ", trying for ",
                              std::chrono::duration_cast<std::chrono::seconds>(patience_).count(), " s"));
        said = true;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }

  std::string target_;
  std::chrono::milliseconds patience_{10000};
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<Stub> stub_;
};

bool is_loopback(const std::string& target) {
  return absl::StartsWith(target, "localhost:") || absl::StartsWith(target, "127.") ||
         absl::StartsWith(target, "[::1]:");
}

absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> tls_credentials(const ServerOptions& options) {
  if (options.tls_ca.empty() || options.tls_certificate.empty() || options.tls_key.empty()) {
    return absl::InvalidArgumentError("TLS needs all of --tls-ca, --tls-cert and --tls-key");
  }
  grpc::SslCredentialsOptions ssl;
  for (const auto& [path, pem] : {std::pair(&options.tls_ca, &ssl.pem_root_certs),
                                  std::pair(&options.tls_certificate, &ssl.pem_cert_chain),
                                  std::pair(&options.tls_key, &ssl.pem_private_key)}) {
    *pem = read_text(*path);
    if (pem->empty()) return absl::InvalidArgumentError(absl::StrCat(*path, " cannot be read, or is empty"));
  }
  return grpc::SslCredentials(ssl);
}

absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> credentials_for(const std::string& target,
                                                                          const ServerOptions& options) {
  const bool tls = !options.tls_ca.empty() || !options.tls_certificate.empty() || !options.tls_key.empty();
  if (absl::StartsWith(target, "unix:")) {
    const std::string path = target.substr(std::string("unix:").size());
    if (::access(path.c_str(), R_OK | W_OK) != 0 && errno == EACCES) {
      return absl::PermissionDeniedError(
          absl::StrCat(path, " is not yours to use; creepd --allow-user lets others in"));
    }
    std::error_code unknown;
    const auto kind = std::filesystem::status(path, unknown).type();
    if (!unknown && kind != std::filesystem::file_type::not_found &&
        kind != std::filesystem::file_type::socket) {
      return absl::InvalidArgumentError(absl::StrCat(path, " is no socket"));
    }
    if (auto status = check_socket_owner(path, options.server_user); !status.ok()) return status;
    return grpc::InsecureChannelCredentials();  // the kernel tells the daemon who calls
  }
  if (tls) return tls_credentials(options);
  if (is_loopback(target)) return grpc::InsecureChannelCredentials();  // an end of a forwarded socket
  return absl::InvalidArgumentError(
      absl::StrCat(target,
                   " is reached over TLS only: give --tls-ca, --tls-cert and --tls-key, or forward its "
                   "socket by ssh"));
}

}  // namespace

void add_server_options(CLI::App& command, ServerOptions& options) {
  command
      .add_option("--server", options.address,
                  "Socket or HOST:PORT of the daemon (default: $XDG_RUNTIME_DIR/creepd.sock)")
      ->envname("CREEPCTL_SERVER")
      ->group("Daemon");
  command
      .add_option("--server-user", options.server_user,
                  "User, by name or number, whose socket is trusted beside yours and root's")
      ->envname("CREEPCTL_SERVER_USER")
      ->group("Daemon");
  command.add_option("--tls-ca", options.tls_ca, "Certificate of who signed the daemon's")
      ->envname("CREEPCTL_TLS_CA")
      ->group("Daemon");
  command.add_option("--tls-cert", options.tls_certificate, "Your certificate")
      ->envname("CREEPCTL_TLS_CERT")
      ->group("Daemon");
  command.add_option("--tls-key", options.tls_key, "The key of your certificate")
      ->envname("CREEPCTL_TLS_KEY")
      ->group("Daemon");
}

absl::StatusOr<std::string> server_target(const std::string& address) {
  std::string path = address;
  if (address.empty()) {
    const char* folder = std::getenv("XDG_RUNTIME_DIR");
    if (folder == nullptr || *folder == '\0') {
      return absl::InvalidArgumentError(
          "XDG_RUNTIME_DIR is not set, so give --server or set CREEPCTL_SERVER");
    }
    path = absl::StrCat(folder, "/creepd.sock");
  } else if (absl::StartsWith(address, "unix:")) {
    path = address.substr(std::string("unix:").size());
    if (absl::StartsWith(path, "//")) path = path.substr(2);
  } else if (absl::StrContains(address, "://")) {
    return absl::InvalidArgumentError(
        absl::StrCat("\"", address, "\" is a URL; give the path of a socket or HOST:PORT"));
  } else if (!absl::StrContains(address, '/')) {
    const auto colon = address.rfind(':');
    std::uint16_t port = 0;
    const char* const end = address.data() + address.size();
    const char* const digits = colon == std::string::npos ? end : address.data() + colon + 1;
    const auto parsed = std::from_chars(digits, end, port);  // one beyond 16 bits would be cut to another
    if (colon == 0 || parsed.ec != std::errc() || parsed.ptr != end || port == 0) {
      return absl::InvalidArgumentError(
          absl::StrCat("\"", address, "\" is neither the path of a socket nor HOST:PORT"));
    }
    return address;
  }
  std::error_code error;
  path = std::filesystem::absolute(path, error).string();
  if (error || path.size() > kLongestSocketPath) {
    return absl::InvalidArgumentError(
        absl::StrCat("the path of the socket is longer than ", kLongestSocketPath, " bytes: ", path));
  }
  return absl::StrCat("unix:", path);
}

bool CallResult::lost() const {
  if (absl::IsUnavailable(status)) return true;
  // A connection that breaks in the middle of a message, or a call that meets a daemon going down, comes from
  // gRPC itself as one of these. Nobody asks for the end of a stream that was given up here.
  return reason.empty() && (absl::IsInternal(status) || absl::IsUnknown(status) || absl::IsCancelled(status));
}

int exit_code_of(const CallResult& result) {
  switch (result.status.code()) {
    case absl::StatusCode::kOk:
      return kOk;
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kDeadlineExceeded:
    case absl::StatusCode::kCancelled:
    case absl::StatusCode::kPermissionDenied:
    case absl::StatusCode::kUnauthenticated:
    case absl::StatusCode::kUnimplemented:
      return kUnreachable;
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kNotFound:
    case absl::StatusCode::kOutOfRange:
      return kInvalidInput;
    default:
      return kFailed;
  }
}

void print_failure(const CallResult& result, const std::string& job_file) {
  std::string message(result.status.message());
  bool said = false;  // the message of a refused request repeats its first violation
  for (const Violation& violation : result.violations) {
    said = said || absl::StrContains(message, violation.description);
    // By the text: a daemon of before tells no numbers.
    if (absl::StartsWith(violation.field, "spec:") && !job_file.empty()) {
      std::fprintf(stderr, "%s%s: %s %s\n", job_file.c_str(), violation.field.c_str() + 4,
                   red("error:", stderr).c_str(), violation.description.c_str());
    } else {
      complain(absl::StrCat(violation.field, ": ", violation.description));
    }
  }
  if (said) return;
  if (absl::IsUnavailable(result.status) && result.reason.empty()) {
    const char* advice = "";
    // Which of them depends on how much of the greeting was sent when the other side hung up.
    const bool cut = absl::StrContains(message, "Socket closed") ||
                     absl::StrContains(message, "Broken pipe") ||
                     absl::StrContains(message, "Connection reset");
    if (cut) {
      advice = absl::StrContains(message, "unix:")
                   ? " (creepd hangs up on users whom it is not told to allow: creepd --allow-user)"
                   : " (over TLS: another certificate authority, or a certificate it refuses?)";
    }
    message = absl::StrCat("no daemon answers: ", message, advice);
  }
  complain(message.empty() ? absl::StatusCodeToString(result.status.code()) : message);
}

absl::StatusOr<std::unique_ptr<Connection>> Connection::open(const ServerOptions& options) {
  const auto target = server_target(options.address);
  if (!target.ok()) return target.status();
  const auto credentials = credentials_for(*target, options);
  if (!credentials.ok()) return credentials.status();
  return std::make_unique<GrpcConnection>(*target, *credentials);
}

int with_connection(const ServerOptions& options, const std::function<int(Connection&)>& command) {
  const auto connection = Connection::open(options);
  if (connection.ok()) return command(**connection);
  complain(std::string(connection.status().message()));
  return absl::IsPermissionDenied(connection.status()) ? kUnreachable : kUsage;
}

}  // namespace creepctl
