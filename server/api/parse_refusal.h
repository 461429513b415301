// A request that is no message of ours: gRPC would say UNIMPLEMENTED, as of a call that does not exist.
#pragma once

#include <memory>

#include <grpcpp/support/server_interceptor.h>

namespace creepd {

/// Makes it INVALID_ARGUMENT with the reason BAD_REQUEST.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> refuse_what_does_not_parse();

}  // namespace creepd
