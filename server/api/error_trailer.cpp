#include "server/api/error_trailer.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "creep/v1/details.pb.h"
#include "server/rules/refusal.h"

namespace creepd {
namespace {

namespace details = creep::v1::details;

// gRPC refuses trailers of more than 8 KiB, in which binary values count a third more, texts that are not
// ASCII three times: 4/3 (4096 + 768 + 256 + 128) + 3 x 256 + names < 8192.
constexpr std::size_t kMostViolationBytes = 4096;  // all of them, serialized
constexpr std::size_t kMostFactBytes = 768;        // all of them, serialized
constexpr std::size_t kMostMessage = 256;
constexpr std::size_t kMostField = 200;
constexpr std::size_t kLeastDescription = 120;  // what is wrong; what would be right comes behind
constexpr std::size_t kMostDescription = 1000;
constexpr std::size_t kMostFact = 300;
constexpr std::size_t kRoomForTheLast = 300;  // "and N more", with its field

bool continues_letter(char byte) { return (static_cast<unsigned char>(byte) & 0xC0u) == 0x80; }

/// Bytes of the UTF-8 letter that begins there, or 0.
std::size_t letter_at(std::string_view text) {
  const auto first = static_cast<unsigned char>(text[0]);
  const std::size_t size = first < 0x80   ? 1
                           : first < 0xC2 ? 0
                           : first < 0xE0 ? 2
                           : first < 0xF0 ? 3
                           : first < 0xF5 ? 4
                                          : 0;
  if (size == 0 || size > text.size()) return 0;
  for (std::size_t i = 1; i < size; ++i) {
    if (!continues_letter(text[i])) return 0;
  }
  const auto second = size > 1 ? static_cast<unsigned char>(text[1]) : 0u;
  const bool overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
  const bool no_letter = (first == 0xED && second > 0x9F) || (first == 0xF4 && second > 0x8F);
  return overlong || no_letter ? 0 : size;
}

/// No text of a message may be anything but UTF-8.
std::string readable(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t size = letter_at(text);
    size == 0 ? out.append("?") : out.append(text.substr(0, size));
    text.remove_prefix(size == 0 ? 1 : size);
  }
  return out;
}

template <class Message>
void add(const Message& detail, std::string_view name, details::Status& status) {
  auto& any = *status.add_details();
  any.set_type_url(absl::StrCat("type.googleapis.com/google.rpc.", std::string(name)));
  any.set_value(detail.SerializeAsString());
}

details::ErrorInfo info_of(const Refusal& refusal) {
  details::ErrorInfo info;
  info.set_reason(refusal.reason.empty() ? "STORAGE_FAILED" : refusal.reason);
  info.set_domain("creepd");
  std::size_t room = kMostFactBytes;
  for (const auto& [key, value] : refusal.facts) {
    const std::string told = shortened(value, kMostFact);
    if (key.size() + told.size() + 8 > room) break;
    room -= key.size() + told.size() + 8;
    (*info.mutable_metadata())[key] = told;
  }
  return info;
}

details::BadRequest bad_request_of(const std::vector<Violation>& violations, std::size_t beyond) {
  details::BadRequest request;
  const std::size_t share = kMostViolationBytes / violations.size();
  const std::size_t longest =
      std::clamp(share - std::min<std::size_t>(share, 60), kLeastDescription, kMostDescription);
  std::size_t room = kMostViolationBytes - kRoomForTheLast;
  std::size_t told = 0;
  for (const Violation& violation : violations) {
    details::BadRequest::FieldViolation message;
    message.set_field(shortened(violation.field, kMostField));
    message.set_description(shortened(violation.description, longest));
    if (violation.line > 0) message.set_line(violation.line);
    if (violation.column > 0) message.set_column(violation.column);
    const std::size_t size = message.ByteSizeLong() + 4;
    if (size > room) break;
    room -= size;
    ++told;
    *request.add_field_violations() = std::move(message);
  }
  const std::size_t left_out = violations.size() - told + beyond;
  if (left_out == 0) return request;
  const std::string& field = violations[std::min(told, violations.size() - 1)].field;
  auto& last = *request.add_field_violations();
  last.set_field(shortened(field.substr(0, field.find_first_of(":[")), kMostField));
  last.set_description(absl::StrCat("and ", left_out, " more"));
  request.set_left_out(static_cast<std::int32_t>(left_out));
  return request;
}

}  // namespace

std::string shortened(std::string_view text, std::size_t most) {
  if (text.size() <= most) return readable(text);
  std::size_t end = most - 3;
  while (end > 0 && continues_letter(text[end])) --end;
  return readable(text.substr(0, end)) + "...";
}

std::string error_message(const absl::Status& status) {
  return shortened(std::string(status.message()), kMostMessage);
}

std::string error_details(const absl::Status& status) {
  const Refusal refusal = refusal_of(status);
  details::Status all;
  all.set_code(static_cast<int>(status.code()));
  all.set_message(error_message(status));
  add(info_of(refusal), "ErrorInfo", all);
  if (!refusal.violations.empty())
    add(bad_request_of(refusal.violations, refusal.left_out), "BadRequest", all);
  if (refusal.retry_seconds) {
    details::RetryInfo retry;
    retry.mutable_retry_delay()->set_seconds(*refusal.retry_seconds);
    add(retry, "RetryInfo", all);
  }
  return all.SerializeAsString();
}

}  // namespace creepd
