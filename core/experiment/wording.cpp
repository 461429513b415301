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

/// The bytes of the code point at the start of `text`; 0 if they are no UTF-8.
std::size_t bytes_of_code_point(std::string_view text) {
  const auto lead = static_cast<unsigned char>(text.front());
  const std::size_t bytes = lead < 0x80   ? 1
                            : lead < 0xC2 ? 0
                            : lead < 0xE0 ? 2
                            : lead < 0xF0 ? 3
                            : lead < 0xF5 ? 4
                                          : 0;
  if (bytes > text.size()) return 0;
  for (std::size_t i = 1; i < bytes; ++i) {
    if (!continues_code_point(text[i])) return 0;
  }
  return bytes;
}

/// Whether a terminal obeys these bytes rather than shows them: U+0000 to U+001F, U+007F to U+009F, the
/// marks, embeddings, overrides and isolates of right-to-left writing, line and paragraph separators.
bool is_obeyed(std::string_view bytes) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  if (bytes.size() == 1) return byte(0) < 0x20 || byte(0) == 0x7F;
  if (bytes.size() == 2) return (byte(0) == 0xC2 && byte(1) < 0xA0) || bytes == "\xD8\x9C";
  if (bytes.size() != 3 || byte(0) != 0xE2) return false;
  if (byte(1) == 0x80) return byte(2) == 0x8E || byte(2) == 0x8F || (byte(2) >= 0xA8 && byte(2) <= 0xAE);
  return byte(1) == 0x81 && byte(2) >= 0xA6 && byte(2) <= 0xA9;
}

std::string escaped(std::string_view text, std::string_view kept) {
  constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string out;
  while (!text.empty()) {
    const std::size_t known = bytes_of_code_point(text);
    const std::string_view bytes = text.substr(0, std::max<std::size_t>(1, known));
    text.remove_prefix(bytes.size());
    if (kept.find(bytes) != std::string_view::npos || (known != 0 && !is_obeyed(bytes))) {
      out += bytes;
      continue;
    }
    // Of U+0080 to U+009F the second byte is the number.
    for (const char byte : bytes[0] == '\xC2' && bytes.size() == 2 ? bytes.substr(1) : bytes) {
      out += "\\x";
      out += kHex[static_cast<unsigned char>(byte) >> 4U];
      out += kHex[static_cast<unsigned char>(byte) & 15U];
    }
  }
  return out;
}

}  // namespace

std::string printable(std::string_view text) { return escaped(text, ""); }

std::string printable_lines(std::string_view text) { return escaped(text, "\n\t"); }

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
