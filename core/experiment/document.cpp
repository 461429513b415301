#include "core/experiment/document.h"

#include <algorithm>
#include <tuple>

#include "core/experiment/wording.h"

// Bounds the recursion of the parser, of its destructors and of convert() for any input.
#define TOML_MAX_NESTED_VALUES 16
#define TOML_EXCEPTIONS 0
#define TOML_HEADER_ONLY 1
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#include <toml++/toml.h>
#pragma GCC diagnostic pop

namespace creep {
namespace {

constexpr std::size_t kLargestText = 1024 * 1024;  // bytes
constexpr int kMostDottedKeys = 16;                // TOML_MAX_NESTED_VALUES does not count these

TextPosition position_of(const toml::source_position& position) {
  return {std::max(1, static_cast<int>(position.line)), std::max(1, static_cast<int>(position.column))};
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
      else if ((static_cast<unsigned char>(text[i]) & 0xC0U) != 0x80U)
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
