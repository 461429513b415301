#include "core/experiment/job_text.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <optional>

#include "absl/strings/str_cat.h"
#include "core/experiment/document.h"
#include "core/experiment/wording.h"

namespace creep {
namespace {

using Kind = DocumentNode::Kind;

std::string string_text(std::string_view value) {
  std::string out = "\"";
  for (const char letter : value) {
    char escape[8];
    if (letter == '"' || letter == '\\') {
      out += {'\\', letter};
    } else if (static_cast<unsigned char>(letter) < 0x20 || letter == 0x7F) {
      std::snprintf(escape, sizeof escape, "\\u%04X", static_cast<unsigned>(letter));
      out += escape;
    } else {
      out += letter;
    }
  }
  return out + "\"";
}

std::string key_text(const std::string& key) {
  const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
  return bare ? key : string_text(key);
}

/// On one line. A date becomes a string: no job file has either in its place.
std::string value_text(const DocumentNode& node) {
  std::string out;
  switch (node.kind) {
    case Kind::kString:
      return string_text(node.string);
    case Kind::kInteger:
      return std::to_string(node.integer);
    case Kind::kFloat:
      out = shortest(node.floating);
      return out.find_first_of(".einf") == std::string::npos ? out + ".0" : out;
    case Kind::kBoolean:
      return node.boolean ? "true" : "false";
    case Kind::kDate:
      return "\"a date\"";
    case Kind::kArray:
      for (const DocumentNode& item : node.items) out += (out.empty() ? "" : ", ") + value_text(item);
      return "[" + out + "]";
    case Kind::kTable:
      for (const DocumentEntry& entry : node.entries) {
        out += (out.empty() ? " " : ", ") + key_text(entry.key) + " = " + value_text(entry.value);
      }
      return "{" + out + (out.empty() ? "}" : " }");
  }
  return out;
}

bool is_list_of_tables(const DocumentNode& node) {
  return node.kind == Kind::kArray && !node.items.empty() &&
         std::all_of(node.items.begin(), node.items.end(),
                     [](const DocumentNode& item) { return item.kind == Kind::kTable; });
}

void append_entries(const DocumentNode& table, std::string& out) {
  for (const DocumentEntry& entry : table.entries) {
    out += key_text(entry.key) + " = " + value_text(entry.value) + "\n";
  }
}

std::string document_text(const DocumentNode& root) {
  std::string plain, sections;
  for (const DocumentEntry& entry : root.entries) {
    if (entry.value.kind == Kind::kTable) {
      sections += "\n[" + key_text(entry.key) + "]\n";
      append_entries(entry.value, sections);
    } else if (is_list_of_tables(entry.value)) {
      for (const DocumentNode& item : entry.value.items) {
        sections += "\n[[" + key_text(entry.key) + "]]\n";
        append_entries(item, sections);
      }
    } else {
      plain += key_text(entry.key) + " = " + value_text(entry.value) + "\n";
    }
  }
  return plain + sections;
}

absl::StatusOr<DocumentNode> parsed(std::string_view text) {
  ParsedDocument document = parse_document(text);
  if (!document.error) return std::move(document.root);
  return absl::InvalidArgumentError(
      absl::StrCat(document.error->line, ":", document.error->column, ": ", document.error->message));
}

DocumentNode value_of(const std::string& text) {
  const ParsedDocument document = parse_document("value = " + text);
  if (!document.error && document.root.entries.size() == 1 && document.root.entries[0].key == "value") {
    return document.root.entries[0].value;
  }
  DocumentNode node;
  node.kind = Kind::kString;
  node.string = text;
  return node;
}

/// The place of a part of a key in a table or list; null if the list has no such item, or it is neither.
DocumentNode* step_into(DocumentNode& node, const std::string& part) {
  if (node.kind == Kind::kArray) {
    std::size_t index = 0;
    const char* end = part.data() + part.size();
    const auto [stop, error] = std::from_chars(part.data(), end, index);
    return error == std::errc() && stop == end && index < node.items.size() ? &node.items[index] : nullptr;
  }
  if (node.kind != Kind::kTable || part.empty()) return nullptr;
  for (DocumentEntry& entry : node.entries) {
    if (entry.key == part) return &entry.value;
  }
  node.entries.push_back({part, {}, {}, {}});
  return &node.entries.back().value;
}

/// The parts of a key between its dots.
std::vector<std::string> parts_of(const std::string& key) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= key.size();) {
    const std::size_t end = std::min(key.find('.', begin), key.size());
    parts.push_back(key.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

/// The table or list that holds the last of the parts; null if there is no such place. Makes nothing.
DocumentNode* holder_of(DocumentNode& root, const std::vector<std::string>& parts) {
  DocumentNode* node = &root;
  for (std::size_t i = 0; node != nullptr && i + 1 < parts.size(); ++i) {
    if (node->kind == Kind::kTable && node->find(parts[i]) == nullptr) return nullptr;
    node = step_into(*node, parts[i]);
  }
  return node;
}

absl::Status set(DocumentNode& root, const Override& wanted) {
  DocumentNode* node = &root;
  for (const std::string& part : parts_of(wanted.first)) {
    node = step_into(*node, part);
    if (node == nullptr) {
      return absl::InvalidArgumentError(
          absl::StrCat("cannot set ", quoted(wanted.first),
                       ": there is no such place (a key is like numerics.minimum_cycles "
                       "or program.0.duration, stages count from 0)"));
    }
  }
  *node = value_of(wanted.second);
  return absl::OkStatus();
}

}  // namespace

std::optional<Override> parse_override(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos || equals == 0) return std::nullopt;
  return Override(text.substr(0, equals), text.substr(equals + 1));
}

absl::StatusOr<std::string> with_overrides(std::string_view text, const std::vector<Override>& overrides,
                                           std::vector<OverrideFault>* faults) {
  auto root = parsed(text);
  if (!root.ok()) return root.status();
  absl::Status wrong;
  for (const Override& wanted : overrides) {
    const absl::Status status = set(*root, wanted);
    wrong.Update(status);
    if (!status.ok() && faults != nullptr) faults->push_back({wanted.first, std::string(status.message())});
  }
  if (!wrong.ok()) return wrong;
  return document_text(*root);
}

absl::StatusOr<std::string> without_keys(std::string_view text, const std::vector<std::string>& keys) {
  auto root = parsed(text);
  if (!root.ok()) return root.status();
  for (const std::string& key : keys) {
    const std::vector<std::string> parts = parts_of(key);
    DocumentNode* const holder = holder_of(*root, parts);
    if (holder == nullptr) continue;
    std::erase_if(holder->entries, [&](const DocumentEntry& entry) { return entry.key == parts.back(); });
  }
  return document_text(*root);
}

absl::StatusOr<std::string> with_stages(std::string_view text, std::size_t first, std::size_t count) {
  auto root = parsed(text);
  if (!root.ok()) return root.status();
  DocumentNode* const program = holder_of(*root, {"program", ""});
  if (program == nullptr || first + count > program->items.size())
    return absl::InvalidArgumentError("the program has not so many stages");
  const auto begin = program->items.begin() + static_cast<std::ptrdiff_t>(first);
  program->items = std::vector<DocumentNode>(begin, begin + static_cast<std::ptrdiff_t>(count));
  return document_text(*root);
}

std::optional<std::string> string_at(std::string_view text, const std::string& key) {
  auto root = parsed(text);
  if (!root.ok()) return std::nullopt;
  const std::vector<std::string> parts = parts_of(key);
  const DocumentNode* const holder = holder_of(*root, parts);
  const DocumentEntry* const entry = holder == nullptr ? nullptr : holder->find(parts.back());
  if (entry == nullptr || entry->value.kind != Kind::kString) return std::nullopt;
  return entry->value.string;
}

absl::StatusOr<std::string> with_sections_of(std::string_view text, std::string_view source) {
  auto root = parsed(text);
  if (!root.ok()) return root.status();
  const auto from = parsed(source);
  if (!from.ok()) return from.status();
  bool changed = false;
  for (const std::string_view section : {"specimen", "material", "numerics"}) {
    const DocumentEntry* theirs = from->find(section);
    if (theirs == nullptr || root->find(section) != nullptr) continue;
    root->entries.push_back(*theirs);
    changed = true;
  }
  return changed ? document_text(*root) : std::string(text);
}

}  // namespace creep
