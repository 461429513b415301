// A job file as a tree of values with their places in the text. The TOML library stays behind this header.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/experiment/diagnostic.h"

namespace creep {

struct DocumentEntry;

/// One value of a document; the member that `kind` names holds it.
struct DocumentNode {
  enum class Kind { kString, kInteger, kFloat, kBoolean, kDate, kArray, kTable };
  Kind kind = Kind::kTable;
  TextPosition begin;
  TextPosition end;  ///< one past the last character; only meaningful for strings
  std::string string;
  std::int64_t integer = 0;
  double floating = 0.0;
  bool boolean = false;
  std::vector<DocumentNode> items;
  std::vector<DocumentEntry> entries;  ///< in the order of the text

  const DocumentEntry* find(std::string_view key) const;
};

struct DocumentEntry {
  std::string key;
  TextPosition key_begin;
  TextPosition key_end;  ///< one past the last character
  DocumentNode value;
};

/// "a string", "a table", ...
std::string_view kind_name(DocumentNode::Kind kind);

/// The tree of a TOML text, or the first thing that is not TOML. Takes at most 1 MiB, bounded nesting, UTF-8.
struct ParsedDocument {
  DocumentNode root;
  std::optional<Diagnostic> error;
};
ParsedDocument parse_document(std::string_view text);

}  // namespace creep
