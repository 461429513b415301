#include "client/terminal/table.h"

#include <algorithm>

#include "core/arithmetic/check.h"

namespace creepctl {
namespace {

bool continues_a_code_point(char byte) { return (byte & 0xc0) == 0x80; }

/// The first `width` columns.
std::string cut(const std::string& line, int width) {
  if (columns_of(line) <= width) return line;
  std::size_t end = 0;
  for (int columns = 0; end < line.size(); ++end) {
    if (!continues_a_code_point(line[end]) && columns++ == width) break;
  }
  return line.substr(0, end);
}

}  // namespace

int columns_of(std::string_view utf8) {
  return static_cast<int>(
      std::count_if(utf8.begin(), utf8.end(), [](char byte) { return !continues_a_code_point(byte); }));
}

void Table::add(std::vector<std::string> cells) {
  CREEP_CHECK(cells.size() == columns_.size(), "one cell a column");
  for (std::string& cell : cells) {
    for (char& byte : cell) {
      if (static_cast<unsigned char>(byte) < ' ' || byte == '\x7f') byte = '?';
    }
  }
  rows_.push_back(std::move(cells));
}

std::string Table::text(int width) const {
  std::vector<int> widths;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    int widest = columns_of(columns_[i].title);
    for (const auto& row : rows_) widest = std::max(widest, columns_of(row[i]));
    widths.push_back(widest);
  }
  std::string text;
  const auto put_line = [&](const auto& cell_of) {
    std::string line;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const std::string& cell = cell_of(i);
      const std::string padding(static_cast<std::size_t>(widths[i] - columns_of(cell)), ' ');
      if (i > 0) line += "  ";
      line += columns_[i].align == Align::kRight ? padding + cell : cell + padding;
    }
    if (width > 0) line = cut(line, width);
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  };
  put_line([&](std::size_t i) -> const std::string& { return columns_[i].title; });
  for (const auto& row : rows_) put_line([&](std::size_t i) -> const std::string& { return row[i]; });
  return text;
}

}  // namespace creepctl
