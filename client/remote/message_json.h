// Messages of the daemon as JSON, field by field under the names of creep.proto.
#pragma once

#include <google/protobuf/message.h>

#include <nlohmann/json.hpp>
#include <string>

namespace creepctl {

/// Numbers as numbers, states by name, instants as "2026-03-01T12:00:00Z", bytes and other text as strings.
/// A message or an optional value that is not set is left out.
nlohmann::ordered_json to_json(const google::protobuf::Message& message);

/// On stdout: with two spaces a level, or on one line. Bytes that are no UTF-8 are replaced.
void print_json(const nlohmann::ordered_json& value);
void print_json_line(const nlohmann::ordered_json& value);

/// "2026-03-01T12:00:00Z" for seconds since 1970.
std::string instant(std::int64_t seconds);

}  // namespace creepctl
