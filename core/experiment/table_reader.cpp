#include "core/experiment/table_reader.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "core/experiment/wording.h"

namespace creep {
namespace {

using Kind = DocumentNode::Kind;

bool is_number(const DocumentNode& node) { return node.kind == Kind::kInteger || node.kind == Kind::kFloat; }

double number_of(const DocumentNode& node) {
  return node.kind == Kind::kInteger ? static_cast<double>(node.integer) : node.floating;
}

/// ", not a table", or for a string of digits how to write it.
std::string instead_of(const DocumentNode& node) {
  if (node.kind != Kind::kString) return ", not " + std::string(kind_name(node.kind));
  double value = 0.0;
  const char* end = node.string.data() + node.string.size();
  const auto [stop, error] = std::from_chars(node.string.data(), end, value);
  const bool digits = error == std::errc() && stop == end && std::isfinite(value);
  return ", not a string" + (digits ? ": write " + node.string + " without quotes" : "");
}

std::string example_of(double value, Dimension dimension) {
  // A bare number was most likely meant in SI.
  return std::isfinite(value) ? quoted(format_quantity(value, dimension)) : "with its unit";
}

}  // namespace

std::optional<double> read_quantity(const DocumentNode& node, std::string_view what, Dimension dimension,
                                    double least, double most, DiagnosticLog& log) {
  const std::string name(what);
  const std::string kind = "a " + std::string(dimension_name(dimension));
  if (is_number(node)) {
    log.error(node.begin, name + " is " + kind + " and needs its unit: write a string, like " +
                              example_of(number_of(node), dimension) +
                              " (units: " + allowed_units(dimension) + ")");
    return std::nullopt;
  }
  if (node.kind != Kind::kString) {
    log.error(node.begin, name + " must be " + kind + " as a string with its unit, not " +
                              std::string(kind_name(node.kind)) + " (units: " + allowed_units(dimension) +
                              ")");
    return std::nullopt;
  }
  const absl::StatusOr<double> value = parse_quantity(node.string, dimension);
  if (!value.ok()) {
    log.error(node.begin, name + ": " + std::string(value.status().message()));
    return std::nullopt;
  }
  if (!(*value >= least && *value <= most)) {
    log.error(node.begin, name + " = " + quoted(node.string) + " is out of range: allowed " +
                              format_quantity(least, dimension) + " to " + format_quantity(most, dimension));
    return std::nullopt;
  }
  return *value;
}

std::optional<double> read_number(const DocumentNode& node, std::string_view what, double least, double most,
                                  DiagnosticLog& log) {
  const std::string name(what);
  const std::string range = shortest(least) + " to " + shortest(most);
  if (!is_number(node)) {
    log.error(node.begin, name + " must be a plain number, " + range + instead_of(node));
    return std::nullopt;
  }
  const double value = number_of(node);
  if (!std::isfinite(value)) {
    log.error(node.begin, name + " must be a finite number: allowed " + range);
    return std::nullopt;
  }
  if (value < least || value > most) {
    log.error(node.begin, name + " = " + shortest(value) + " is out of range: allowed " + range);
    return std::nullopt;
  }
  return value + 0.0;  // no negative zero
}

TableReader::TableReader(const DocumentNode& table, std::string name, DiagnosticLog& log)
    : table_(table), name_(std::move(name)), log_(log) {}

const DocumentNode* TableReader::find(std::string_view key) {
  known_.push_back(key);
  const DocumentEntry* entry = table_.find(key);
  return entry == nullptr ? nullptr : &entry->value;
}

void TableReader::quantity(std::string_view key, Dimension dimension, double least, double most,
                           double& target) {
  std::optional<double> value;
  quantity(key, dimension, least, most, value);
  if (value) target = *value;
}

void TableReader::quantity(std::string_view key, Dimension dimension, double least, double most,
                           std::optional<double>& target) {
  const DocumentNode* node = find(key);
  if (node == nullptr) return;
  if (const auto value = read_quantity(*node, key, dimension, least, most, log_)) target = value;
}

void TableReader::number(std::string_view key, double least, double most, double& target) {
  std::optional<double> value;
  number(key, least, most, value);
  if (value) target = *value;
}

void TableReader::number(std::string_view key, double least, double most, std::optional<double>& target) {
  const DocumentNode* node = find(key);
  if (node == nullptr) return;
  if (const auto value = read_number(*node, key, least, most, log_)) target = *value;
}

void TableReader::count(std::string_view key, std::int64_t least, std::int64_t most, std::int64_t& target) {
  std::optional<std::int64_t> value;
  count(key, least, most, value);
  if (value) target = *value;
}

void TableReader::count(std::string_view key, std::int64_t least, std::int64_t most,
                        std::optional<std::int64_t>& target) {
  const DocumentNode* node = find(key);
  if (node == nullptr) return;
  const std::string name(key);
  const std::string range = std::to_string(least) + " to " + std::to_string(most);
  if (!is_number(*node)) {
    log_.error(node->begin, name + " must be a whole number, " + range + instead_of(*node));
  } else if (node->kind == Kind::kInteger && node->integer >= least && node->integer <= most) {
    target = node->integer;
  } else if (node->kind == Kind::kFloat && node->floating >= static_cast<double>(least) &&
             node->floating <= static_cast<double>(most)) {
    log_.error(node->begin, name + " must be a whole number, written without point or exponent");
  } else {
    const std::string value =
        node->kind == Kind::kInteger ? std::to_string(node->integer) : shortest(node->floating);
    log_.error(node->begin, name + " = " + value + " is out of range: allowed " + range);
  }
}

void TableReader::flag(std::string_view key, bool& target) {
  const DocumentNode* node = find(key);
  if (node == nullptr) return;
  if (node->kind == Kind::kBoolean) {
    target = node->boolean;
  } else {
    log_.error(node->begin,
               std::string(key) + " must be true or false, not " + std::string(kind_name(node->kind)));
  }
}

bool TableReader::is_string(std::string_view key) const {
  const DocumentEntry* entry = table_.find(key);
  return entry != nullptr && entry->value.kind == Kind::kString && !entry->value.string.empty() &&
         std::isalpha(static_cast<unsigned char>(entry->value.string.front())) != 0;
}

std::optional<std::size_t> TableReader::word(std::string_view key, std::span<const std::string_view> words) {
  const std::optional<std::string> value = string(key);
  if (!value) return std::nullopt;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == *value) return i;
  }
  log_.error(position_of(key),
             "unknown " + std::string(key) + " " + quoted(*value) + guess_or_list(*value, words));
  return std::nullopt;
}

std::optional<std::string> TableReader::string(std::string_view key) {
  const DocumentNode* node = find(key);
  if (node == nullptr) return std::nullopt;
  if (node->kind == Kind::kString) return node->string;
  log_.error(node->begin, std::string(key) + " must be a string, not " + std::string(kind_name(node->kind)));
  return std::nullopt;
}

TextPosition TableReader::position_of(std::string_view key) const {
  const DocumentEntry* entry = table_.find(key);
  return entry == nullptr ? table_.begin : entry->value.begin;
}

void TableReader::unavailable(std::string_view key, std::string_view available) {
  unavailable_.push_back(key);
  if (const DocumentEntry* entry = table_.find(key)) {
    log_.error(entry->key_begin, std::string(key) + " in " + name_ + " is not available in this version" +
                                     (available.empty() ? "" : "; available: " + std::string(available)));
  }
}

void TableReader::finish() {
  for (const DocumentEntry& entry : table_.entries) {
    const auto is_key = [&](std::string_view key) { return key == entry.key; };
    if (std::any_of(known_.begin(), known_.end(), is_key)) continue;
    if (std::any_of(unavailable_.begin(), unavailable_.end(), is_key)) continue;
    log_.error(entry.key_begin,
               "unknown key " + quoted(entry.key) + " in " + name_ + guess_or_list(entry.key, known_));
  }
}

}  // namespace creep
