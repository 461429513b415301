#include "core/experiment/wording.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <vector>

namespace creep {
namespace {

constexpr std::size_t kLongestQuote = 60;  // code points
constexpr std::size_t kLongestWord = 64;   // bytes; nothing longer is a slip of a word of ours

bool continues_code_point(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U; }

char lower(char letter) {
  return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter;
}

/// Levenshtein distance without regard to case.
std::size_t edit_distance(std::string_view from, std::string_view to) {
  std::vector<std::size_t> row(to.size() + 1);
  for (std::size_t j = 0; j <= to.size(); ++j) row[j] = j;
  for (std::size_t i = 0; i < from.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < to.size(); ++j) {
      const std::size_t replaced = diagonal + (lower(from[i]) == lower(to[j]) ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row[to.size()];
}

}  // namespace

std::string printable(std::string_view text) {
  constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (byte < 0x20 || byte == 0x7F) {
      out += "\\x";
      out += kHex[byte >> 4U];
      out += kHex[byte & 15U];
    } else if (byte == 0xC2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xA0) {
      out += "\\x";  // U+0080 to U+009F: control characters of some terminals
      out += kHex[static_cast<unsigned char>(text[i + 1]) >> 4U];
      out += kHex[static_cast<unsigned char>(text[i + 1]) & 15U];
      ++i;
    } else {
      out += text[i];
    }
  }
  return out;
}

std::string quoted(std::string_view text) {
  std::size_t end = 0;
  for (std::size_t points = 0; end < text.size(); ++end) {
    if (continues_code_point(text[end])) continue;
    if (points++ == kLongestQuote) break;
  }
  std::string out(1, '"');
  out += printable(text.substr(0, end));
  out += end < text.size() ? "...\"" : "\"";
  return out;
}

std::string listed(std::span<const std::string_view> words) {
  std::string out;
  for (const std::string_view word : words) {
    if (!out.empty()) out += ", ";
    out += word;
  }
  return out;
}

std::string shortest(double value) {
  std::array<char, 64> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return std::string(buffer.data(), end);
}

std::optional<std::string_view> closest(std::string_view word, std::span<const std::string_view> candidates) {
  if (word.empty() || word.size() > kLongestWord) return std::nullopt;
  std::optional<std::string_view> best;
  std::size_t best_distance = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string_view candidate : candidates) {
    // A distance as long as the candidate would turn anything into anything.
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance && distance < candidate.size()) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

std::string guess_or_list(std::string_view word, std::span<const std::string_view> candidates) {
  if (const auto guess = closest(word, candidates)) return "; did you mean " + quoted(*guess) + "?";
  return " (allowed: " + listed(candidates) + ")";
}

}  // namespace creep
