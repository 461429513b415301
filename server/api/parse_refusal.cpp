#include "server/api/parse_refusal.h"

#include <string>

#include "creep/v1/creep.pb.h"
#include "server/api/answer.h"

namespace creepd {
namespace {

using grpc::experimental::InterceptionHookPoints;

bool is_a_call(const std::string& path) {
  const auto* service = creep::v1::SubmitJobRequest::descriptor()->file()->FindServiceByName("CreepService");
  const std::string before = "/" + service->full_name() + "/";
  return path.starts_with(before) && service->FindMethodByName(path.substr(before.size())) != nullptr;
}

/// Of a call that exists: its handlers never say UNIMPLEMENTED, so gRPC itself could not read the request.
class ParseRefusal final : public grpc::experimental::Interceptor {
 public:
  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS) &&
        methods->GetSendStatus().error_code() == grpc::StatusCode::UNIMPLEMENTED) {
      methods->ModifySendStatus(to_grpc(
          bad_request({{"", "the request cannot be parsed (a text that is no UTF-8, or other bytes)"}})));
    }
    methods->Proceed();
  }
};

class Factory final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  /// Null: gRPC leaves the call alone.
  grpc::experimental::Interceptor* CreateServerInterceptor(grpc::experimental::ServerRpcInfo* call) override {
    return is_a_call(call->method()) ? new ParseRefusal : nullptr;
  }
};

}  // namespace

std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> refuse_what_does_not_parse() {
  return std::make_unique<Factory>();
}

}  // namespace creepd
