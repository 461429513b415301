// What the calls of the service have in common: who calls, and how an error leaves.
#pragma once

#include <unistd.h>

#include <optional>
#include <string>

#include <grpcpp/grpcpp.h>

#include "server/api/error_trailer.h"
#include "server/jobs/jobs.h"
#include "server/rules/refusal.h"

namespace creepd {

/// Property of the connection that server.cpp sets from the kernel's answer.
inline constexpr const char* kUserProperty = "uid";

inline grpc::Status to_grpc(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  // Errors of the file system come with codes of their own; to a caller they are one thing.
  absl::StatusCode code = status.code();
  if (refusal_of(status).reason.empty()) code = absl::StatusCode::kUnavailable;
  return {static_cast<grpc::StatusCode>(code), error_message(status), error_details(status)};
}

/// Over the unix socket the user that the kernel names; over TLS the name in the certificate.
inline std::optional<Caller> caller_of(const grpc::CallbackServerContext& context) {
  const auto connection = context.auth_context();
  for (const grpc::string_ref& uid : connection->FindPropertyValues(kUserProperty)) {
    const std::string user(uid.data(), uid.size());
    return Caller{"uid:" + user, user == "0" || user == std::to_string(::geteuid())};
  }
  if (!connection->IsPeerAuthenticated()) return std::nullopt;
  for (const grpc::string_ref& name : connection->GetPeerIdentity()) {
    if (!name.empty()) return Caller{"tls:" + std::string(name.data(), name.size()), false};
  }
  return std::nullopt;
}

inline absl::Status unknown_user() {
  return refuse(absl::StatusCode::kPermissionDenied, "it is not known who calls",
                {"UNKNOWN_USER", {}, {}, {}});
}

inline absl::Status shutting_down() {
  return refuse(absl::StatusCode::kUnavailable, "creepd is going down", {"SHUTTING_DOWN", {}, {}, 5});
}

}  // namespace creepd
