// Rows of text in aligned columns. Pure.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace creepctl {

enum class Align { kLeft, kRight };

class Table {
 public:
  struct Column {
    std::string title;
    Align align = Align::kLeft;
  };

  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

  /// As many cells as columns. A control character in one is shown as '?', so that a label cannot move the
  /// cursor.
  void add(std::vector<std::string> cells);

  bool empty() const { return rows_.empty(); }

  /// The titles and the rows, two spaces between columns, no space at the end of a line. Lines longer than
  /// `width` columns are cut; 0: none is.
  std::string text(int width) const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

/// Terminal columns of a text, one a code point.
int columns_of(std::string_view utf8);

}  // namespace creepctl
