#include "core/experiment/document.h"

#include <algorithm>
#include <tuple>

#include "core/experiment/toml_library.h"
#include "core/experiment/wording.h"

namespace creep {
namespace {

constexpr std::size_t kLargestText = 1024 * 1024;  // bytes
constexpr int kMostDottedKeys = 16;                // TOML_MAX_NESTED_VALUES does not count these

TextPosition position_of(const toml::source_position& position) {
  return {std::max(1, static_cast<int>(position.line)), std::max(1, static_cast<int>(position.column))};
}

bool continues_code_point(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U; }

/// The bytes of the code point that begins at `at`; 0 if there is none in UTF-8 (RFC 3629: no surrogates, no
/// overlong forms, nothing above U+10FFFF).
std::size_t code_point_length(std::string_view text, std::size_t at) {
  const auto first = static_cast<unsigned char>(text[at]);
  if (first < 0x80) return 1;
  const std::size_t length = first < 0xC2 ? 0 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : first < 0xF5 ? 4 : 0;
  if (length == 0 || at + length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if (!continues_code_point(text[at + i])) return 0;
  }
  const auto second = static_cast<unsigned char>(text[at + 1]);
  const bool overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
  const bool beyond = (first == 0xED && second >= 0xA0) || (first == 0xF4 && second >= 0x90);
  return overlong || beyond ? 0 : length;
}

/// The first place that is not UTF-8. The parser checks too, but is a column off.
std::optional<TextPosition> find_bad_utf8(std::string_view text) {
  TextPosition here;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = code_point_length(text, at);
    if (length == 0) return here;
    here = text[at] == '\n' ? TextPosition{here.line + 1, 1} : TextPosition{here.line, here.column + 1};
    at += length;
  }
  return std::nullopt;
}

/// Steps over the string that begins at `at`; returns the index after it.
std::size_t skip_string(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const std::string triple(3, quote);
  const bool multi_line = text.substr(at, 3) == triple;
  at += multi_line ? 3 : 1;
  while (at < text.size()) {
    if (text[at] == '\\' && quote == '"') {
      at += 2;
    } else if (multi_line && text.substr(at, 3) == triple) {
      return at + 3;
    } else if (!multi_line && (text[at] == quote || text[at] == '\n')) {
      return at + 1;
    } else {
      ++at;
    }
  }
  return text.size();
}

/// The place where a.b.c... has more parts than any job file needs; the parser would recurse on each.
std::optional<TextPosition> find_deep_key(std::string_view text) {
  TextPosition here;
  int dots = 0;
  for (std::size_t at = 0; at < text.size();) {
    const char letter = text[at];
    const std::size_t begin = at;
    if (letter == '"' || letter == '\'') {
      at = std::min(skip_string(text, at), text.size());
    } else if (letter == '#') {
      at = std::min(text.find('\n', at), text.size());
    } else {
      ++at;
      if (letter == '.' && ++dots > kMostDottedKeys) return here;
      if (std::string_view("=,[]{}\n").find(letter) != std::string_view::npos) dots = 0;
    }
    for (std::size_t i = begin; i < at; ++i) {
      if (text[i] == '\n')
        here = {here.line + 1, 1};
      else if (!continues_code_point(text[i]))
        ++here.column;
    }
  }
  return std::nullopt;
}

DocumentNode convert(const toml::node& node);

void convert_table(const toml::table& table, DocumentNode& result) {
  result.kind = DocumentNode::Kind::kTable;
  for (const auto& [key, value] : table) {
    result.entries.push_back({std::string(key.str()), position_of(key.source().begin),
                              position_of(key.source().end), convert(value)});
  }
  std::sort(result.entries.begin(), result.entries.end(), [](const DocumentEntry& a, const DocumentEntry& b) {
    return std::tie(a.key_begin.line, a.key_begin.column, a.key) <
           std::tie(b.key_begin.line, b.key_begin.column, b.key);
  });
}

DocumentNode convert(const toml::node& node) {
  DocumentNode result;
  result.begin = position_of(node.source().begin);
  result.end = position_of(node.source().end);
  if (const auto* table = node.as_table()) {
    convert_table(*table, result);
  } else if (const auto* array = node.as_array()) {
    result.kind = DocumentNode::Kind::kArray;
    for (const toml::node& item : *array) result.items.push_back(convert(item));
  } else if (const auto* string = node.as_string()) {
    result.kind = DocumentNode::Kind::kString;
    result.string = string->get();
  } else if (const auto* integer = node.as_integer()) {
    result.kind = DocumentNode::Kind::kInteger;
    result.integer = integer->get();
  } else if (const auto* floating = node.as_floating_point()) {
    result.kind = DocumentNode::Kind::kFloat;
    result.floating = floating->get();
  } else if (const auto* boolean = node.as_boolean()) {
    result.kind = DocumentNode::Kind::kBoolean;
    result.boolean = boolean->get();
  } else {
    result.kind = DocumentNode::Kind::kDate;
  }
  return result;
}

}  // namespace

const DocumentEntry* DocumentNode::find(std::string_view key) const {
  for (const DocumentEntry& entry : entries) {
    if (entry.key == key) return &entry;
  }
  return nullptr;
}

std::string_view kind_name(DocumentNode::Kind kind) {
  switch (kind) {
    case DocumentNode::Kind::kString:
      return "a string";
    case DocumentNode::Kind::kInteger:
      return "a whole number";
    case DocumentNode::Kind::kFloat:
      return "a number";
    case DocumentNode::Kind::kBoolean:
      return "true or false";
    case DocumentNode::Kind::kDate:
      return "a date";
    case DocumentNode::Kind::kArray:
      return "an array";
    case DocumentNode::Kind::kTable:
      return "a table";
  }
  return "";
}

ParsedDocument parse_document(std::string_view text) {
  ParsedDocument result;
  if (text.size() > kLargestText) {
    result.error = Diagnostic{1, 1, "the file has more than 1 MiB; this is not a job file"};
    return result;
  }
  if (const auto bad = find_bad_utf8(text)) {
    result.error = Diagnostic{bad->line, bad->column, "not UTF-8 text; a job file is a TOML text in UTF-8"};
    return result;
  }
  if (const auto deep = find_deep_key(text)) {
    result.error = Diagnostic{deep->line, deep->column, "a key with this many dots is in no job file"};
    return result;
  }
  const toml::parse_result parsed = toml::parse(text);
  if (!parsed) {
    const TextPosition at = position_of(parsed.error().source().begin);
    const std::string_view description = parsed.error().description();
    const bool bare_unit = description.find("expected a comment or whitespace") != std::string_view::npos;
    result.error = Diagnostic{at.line, at.column,
                              "not valid TOML: " + printable(description) +
                                  (bare_unit ? " (a quantity is written in quotes: \"21.7 MPa\")" : "")};
    return result;
  }
  convert_table(parsed.table(), result.root);
  return result;
}

}  // namespace creep
