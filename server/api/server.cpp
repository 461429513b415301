#include "server/api/server.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/security/auth_metadata_processor.h>
#include <grpcpp/security/server_credentials.h>

#include "absl/strings/str_cat.h"
#include "core/folder/durable_file.h"
#include "core/folder/file_descriptor.h"
#include "core/folder/sample_log.h"
#include "core/run/self_test.h"
#include "core/state/checkpoint.h"
#include "core/state/program_version.h"
#include "server/api/answer.h"
#include "server/api/parse_refusal.h"
#include "server/api/service.h"
#include "server/host/daemon_log.h"
#include "server/jobs/spec_check.h"

namespace creepd {
namespace {

namespace v1 = creep::v1;
using Acceptor = grpc::experimental::ExternalConnectionAcceptor;

constexpr int kMostMessageBytes = 4 << 20;
constexpr int kPing = 30'000;       // [ms]
constexpr int kLeastPing = 10'000;  // [ms] that a client must wait between two
constexpr uid_t kNobody = 65534;    // whoever has no number here; never one user

/// Writes into a connection, at its first call, which user the kernel found at its other end. All calls of a
/// connection share its properties, and gRPC guards them with nothing: once a handler may read them they
/// never change again.
class NameUser final : public grpc::AuthMetadataProcessor {
 public:
  // Locked, so that the order of this before the first call can be seen: gRPC's own hand-over between its
  // threads is in libraries that ThreadSanitizer does not look into.
  explicit NameUser(uid_t user) {
    const std::lock_guard<std::mutex> lock(first_call_);
    user_ = std::to_string(user);
  }
  bool IsBlocking() const override { return false; }
  grpc::Status Process(const InputMetadata& /*metadata*/, grpc::AuthContext* context,
                       OutputMetadata* /*consumed*/, OutputMetadata* /*answer*/) override {
    const std::lock_guard<std::mutex> lock(first_call_);
    if (context->FindPropertyValues(kUserProperty).empty()) {
      context->AddProperty(kUserProperty, user_);
      context->SetPeerIdentityPropertyName(kUserProperty);
    }
    return grpc::Status::OK;
  }

 private:
  std::mutex first_call_;
  std::string user_;
};

absl::StatusOr<sockaddr_un> address_of(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.native().size() >= sizeof address.sun_path) {
    return absl::InvalidArgumentError(absl::StrCat("the socket path ", path.string(), " has ",
                                                   path.native().size(), " characters; at most ",
                                                   sizeof address.sun_path - 1, " are possible"));
  }
  std::memcpy(address.sun_path, path.c_str(), path.native().size());
  return address;
}

/// Listens, in the place of a socket that a killed daemon left behind.
absl::StatusOr<creep::FileDescriptor> listen_on(const std::filesystem::path& path, bool for_others) {
  const auto address = address_of(path);
  if (!address.ok()) return address.status();
  const auto* const where = reinterpret_cast<const sockaddr*>(&*address);
  const creep::FileDescriptor probe(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (::connect(probe.get(), where, sizeof *address) == 0) {
    return absl::AlreadyExistsError(absl::StrCat("another daemon listens on ", path.string()));
  }
  struct stat about {};
  if (::lstat(path.c_str(), &about) == 0) {
    if (!S_ISSOCK(about.st_mode))
      return absl::AlreadyExistsError(absl::StrCat(path.string(), " is no socket"));
    ::unlink(path.c_str());
  }
  creep::FileDescriptor listener(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const mode_t before = ::umask(for_others ? 0111 : 0177);
  const int bound = ::bind(listener.get(), where, sizeof *address);
  ::umask(before);
  if (bound != 0 || ::listen(listener.get(), 128) != 0)
    return creep::errno_status(absl::StrCat("listen on ", path.string()), errno);
  return listener;
}

absl::StatusOr<std::shared_ptr<grpc::ServerCredentials>> tls_credentials(const TlsOptions& tls) {
  const auto certificate = creep::read_file(tls.certificate, 1 << 20);
  const auto key = creep::read_file(tls.key, 1 << 20);
  const auto client_ca = creep::read_file(tls.client_ca, 1 << 20);
  for (const auto* file : {&certificate, &key, &client_ca}) {
    if (!file->ok()) return absl::InvalidArgumentError(std::string(file->status().message()));
  }
  grpc::SslServerCredentialsOptions options(GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  options.pem_root_certs = *client_ca;
  options.pem_key_cert_pairs.push_back({*key, *certificate});
  return grpc::SslServerCredentials(options);
}

}  // namespace

struct Server::Impl {
  Impl(const ServerOptions& options, Jobs& jobs, JobStore& store, SampleLibrary& samples, JobChanges& changes)
      : options(options),
        changes(changes),
        hub(jobs, store, samples),
        service(jobs, store, samples, hub, [this, &jobs](v1::ServerInfo& info) { fill(info, jobs); }) {}

  ~Impl() { stop(); }

  void fill(v1::ServerInfo& info, const Jobs& jobs) const {
    info.set_version(std::string(creep::program_version()));
    info.set_checkpoint_format(creep::kCheckpointVersion);
    info.set_sample_log_format(creep::kSampleLogVersion);
    info.set_arithmetic_id(arithmetic);
    info.mutable_start_time()->set_seconds(std::chrono::system_clock::to_time_t(started));
    info.set_slots(options.slots);
    info.set_threads_per_job(options.threads_per_job);
    info.set_memory_limit_bytes(jobs.limits().memory);
    info.set_free_bytes(free_bytes(options.state));
    info.set_max_unfinished_jobs(jobs.limits().most_unfinished);
    info.set_max_particles(kMostParticles);
    info.set_max_spec_bytes(kMostSpecBytes);
    info.mutable_checkpoint_interval()->set_seconds(static_cast<std::int64_t>(options.checkpoint_interval));
    info.set_state_directory(options.state.string());
  }

  absl::Status start() {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
    grpc::ServerBuilder builder;
    builder.RegisterService(&service);
    builder.SetMaxReceiveMessageSize(kMostMessageBytes);
    // gRPC inflates a message before it looks at its size: 1 MB of gzip would take 1 GB.
    builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
    builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
    std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> interceptors;
    interceptors.push_back(refuse_what_does_not_parse());
    builder.experimental().SetInterceptorCreators(std::move(interceptors));
    builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
    builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, kPing);
    builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
    builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, kLeastPing);
    std::vector<uid_t> users = options.users;
    users.insert(users.end(), {uid_t{0}, ::geteuid()});
    for (const uid_t user : users) {
      if (user == kNobody || acceptors.contains(user)) continue;
      auto credentials = grpc::experimental::LocalServerCredentials(UDS);
      credentials->SetAuthMetadataProcessor(std::make_shared<NameUser>(user));
      acceptors[user] = builder.experimental().AddExternalConnectionAcceptor(
          grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD, credentials);
    }
    int port = 0;
    if (options.tls) {
      const auto credentials = tls_credentials(*options.tls);
      if (!credentials.ok()) return credentials.status();
      builder.AddListeningPort(options.tls->address, *credentials, &port);
    }
    auto socket = listen_on(options.socket, !options.users.empty());
    if (!socket.ok()) return socket.status();
    listener = *std::move(socket);
    server = builder.BuildAndStart();
    if (!server || (options.tls && port == 0)) {
      return absl::UnavailableError(options.tls
                                        ? absl::StrCat("cannot listen on ", options.tls->address,
                                                       ": the port is taken, or the certificates are wrong")
                                        : "gRPC does not start");
    }
    server->GetHealthCheckService()->SetServingStatus("creep.v1.CreepService", true);
    changes.listen([this](const std::string& job) { hub.changed(job); });
    end = creep::FileDescriptor(::eventfd(0, EFD_CLOEXEC));
    accepting = std::thread([this] { accept_connections(); });
    return absl::OkStatus();
  }

  void accept_connections() {
    for (;;) {
      pollfd news[] = {{listener.get(), POLLIN, 0}, {end.get(), POLLIN, 0}};
      ::poll(news, 2, -1);
      if (news[1].revents != 0) return;
      creep::FileDescriptor connection(
          ::accept4(listener.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
      if (!connection.open()) {
        if (errno == EMFILE || errno == ENFILE) ::poll(nullptr, 0, 100);  // until somebody hangs up
        continue;
      }
      ucred peer{};
      socklen_t size = sizeof peer;
      if (::getsockopt(connection.get(), SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) continue;
      const auto acceptor = acceptors.find(peer.uid);
      if (acceptor == acceptors.end()) {
        log_line(absl::StrCat("refused a connection of user ", peer.uid, ", process ", peer.pid));
        continue;
      }
      Acceptor::NewConnectionParameters parameters;
      parameters.listener_fd = listener.get();
      parameters.fd = ::fcntl(connection.get(), F_DUPFD_CLOEXEC, 0);  // gRPC closes its own
      acceptor->second->HandleNewConnection(&parameters);
    }
  }

  void stop() {
    if (accepting.joinable()) {
      const std::uint64_t one = 1;
      if (::write(end.get(), &one, sizeof one) == sizeof one) accepting.join();
      ::unlink(options.socket.c_str());
    }
    service.refuse_calls();
    hub.stop();
    if (!server) return;
    // Streams were told to finish; what is stuck in a dead connection is cut off.
    server->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(3));
    server->Wait();
    changes.listen(nullptr);
    server.reset();
  }

  ServerOptions options;
  JobChanges& changes;
  WatchHub hub;
  CreepService service;
  std::chrono::system_clock::time_point started = std::chrono::system_clock::now();
  const std::string arithmetic = creep::arithmetic_id("");
  std::map<uid_t, std::unique_ptr<Acceptor>> acceptors;
  creep::FileDescriptor listener;
  creep::FileDescriptor end;
  std::unique_ptr<grpc::Server> server;
  std::thread accepting;
};

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Server::~Server() = default;

absl::StatusOr<std::unique_ptr<Server>> Server::start(const ServerOptions& options, Jobs& jobs,
                                                      JobStore& store, SampleLibrary& samples,
                                                      JobChanges& changes) {
  auto impl = std::make_unique<Impl>(options, jobs, store, samples, changes);
  if (auto status = impl->start(); !status.ok()) return status;
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

void Server::refuse_calls() {
  impl_->server->GetHealthCheckService()->SetServingStatus(false);
  impl_->service.refuse_calls();
}

void Server::stop() { impl_->stop(); }

}  // namespace creepd
