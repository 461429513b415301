// Reads the keys of one table of a job file, each with its type, range and default. Asking for a key makes it
// known; finish() reports the keys that nobody asked for.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/experiment/document.h"
#include "core/experiment/units.h"

namespace creep {

class TableReader {
 public:
  /// `name` is how messages call the table, e.g. "[specimen]". Keeps references to `table` and `log`.
  TableReader(const DocumentNode& table, std::string name, DiagnosticLog& log);

  const DocumentNode& table() const { return table_; }

  /// The value of a key, whatever its type; null if absent.
  const DocumentNode* find(std::string_view key);
  bool has(std::string_view key) const { return table_.find(key) != nullptr; }

  /// Each reads a key if it is there and good, and otherwise leaves `target`; what is not good becomes an
  /// error. Ranges include both ends. quantity() is in SI.
  void quantity(std::string_view key, Dimension dimension, double least, double most, double& target);
  void quantity(std::string_view key, Dimension dimension, double least, double most,
                std::optional<double>& target);
  void number(std::string_view key, double least, double most, double& target);
  void number(std::string_view key, double least, double most, std::optional<double>& target);
  void count(std::string_view key, std::int64_t least, std::int64_t most, std::int64_t& target);
  void count(std::string_view key, std::int64_t least, std::int64_t most,
             std::optional<std::int64_t>& target);

  void flag(std::string_view key, bool& target);

  /// Whether the key has a string of letters: a word, where a number may stand as well.
  bool is_string(std::string_view key) const;

  /// The index in `words` of the word given; none if the key is absent or its value is no such word (an
  /// error).
  std::optional<std::size_t> word(std::string_view key, std::span<const std::string_view> words);

  /// The string given; none if the key is absent or no string (an error).
  std::optional<std::string> string(std::string_view key);

  /// Where the key's value is, or the table if it is absent.
  TextPosition position_of(std::string_view key) const;

  /// Makes a key known that only gives an error here: "not available in this version".
  void unavailable(std::string_view key, std::string_view available);

  void error(TextPosition at, std::string message) { log_.error(at, std::move(message)); }
  void warning(TextPosition at, std::string message) { log_.warning(at, std::move(message)); }

  /// Reports unknown keys. Call last.
  void finish();

 private:
  const DocumentNode& table_;
  std::string name_;
  DiagnosticLog& log_;
  std::vector<std::string_view> known_;
  std::vector<std::string_view> unavailable_;  ///< known, but never suggested
};

/// The quantity in a string node: error messages name `what`.
std::optional<double> read_quantity(const DocumentNode& node, std::string_view what, Dimension dimension,
                                    double least, double most, DiagnosticLog& log);

/// The plain number in a node: error messages name `what`.
std::optional<double> read_number(const DocumentNode& node, std::string_view what, double least, double most,
                                  DiagnosticLog& log);

}  // namespace creep
