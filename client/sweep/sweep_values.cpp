#include "client/sweep/sweep_values.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <string_view>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "core/experiment/wording.h"

namespace creepctl {
namespace {

constexpr std::size_t kMostSeeds = 1000;
constexpr double kLargestRatio = 2.0;

template <typename Number>
bool read_number(std::string_view text, Number& number) {
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && stop == end && !text.empty();
}

std::string trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return "";
  return std::string(text.substr(first, text.find_last_not_of(" \t") - first + 1));
}

template <typename Value>
absl::Status check_once_each(std::vector<Value> values) {
  std::sort(values.begin(), values.end());
  const auto twice = std::adjacent_find(values.begin(), values.end());
  if (twice == values.end()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(*twice, " is given twice"));
}

/// Cuts at the commas that stand outside of quotes and brackets.
std::vector<std::string> split_values(std::string_view text) {
  std::vector<std::string> values(1);
  int depth = 0;
  char quote = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char letter = text[i];
    if (quote != 0) {
      if (letter == '\\' && quote == '"' && i + 1 < text.size()) values.back() += text[i++];
      if (text[i] == quote && letter == quote) quote = 0;
    } else if (letter == '"' || letter == '\'') {
      quote = letter;
    } else if (letter == '[' || letter == '{') {
      ++depth;
    } else if (letter == ']' || letter == '}') {
      --depth;
    } else if (letter == ',' && depth <= 0) {
      values.emplace_back();
      continue;
    }
    values.back() += text[i];
  }
  for (std::string& value : values) value = trimmed(value);
  return values;
}

}  // namespace

absl::StatusOr<std::vector<std::int64_t>> parse_seeds(const std::string& text) {
  const auto wrong = [&](std::string_view part) {
    return absl::InvalidArgumentError(
        absl::StrCat(creep::quoted(part), " is no seed: give whole numbers of 0 and up, like 5 (1 to 5), ",
                     "1..5 or 1,3,7; at most ", kMostSeeds));
  };
  std::vector<std::int64_t> seeds;
  const std::string plain = trimmed(text);
  for (const std::string& raw : std::vector<std::string>(absl::StrSplit(plain, ','))) {
    const std::string part = trimmed(raw);
    const auto dots = part.find("..");
    std::int64_t first = 1, last = 0;
    if (dots != std::string::npos) {
      if (!read_number(part.substr(0, dots), first) || !read_number(part.substr(dots + 2), last))
        return wrong(part);
    } else {
      if (!read_number(part, last)) return wrong(part);
      if (part != plain) first = last;  // one of a list
    }
    if (first < 0 || last < first || last - first >= static_cast<std::int64_t>(kMostSeeds))
      return wrong(part);
    for (std::int64_t offset = 0; offset <= last - first; ++offset) seeds.push_back(first + offset);
    if (seeds.size() > kMostSeeds) return wrong(part);
  }
  if (auto once = check_once_each(seeds); !once.ok()) return once;
  return seeds;
}

absl::StatusOr<std::vector<double>> parse_stress_ratios(const std::string& text) {
  std::vector<double> ratios;
  for (const std::string& raw : std::vector<std::string>(absl::StrSplit(text, ','))) {
    const std::string part = trimmed(raw);
    double ratio = 0.0;
    if (!read_number(part, ratio) || !(ratio > 0.0 && ratio <= kLargestRatio)) {
      return absl::InvalidArgumentError(absl::StrCat(
          creep::quoted(part), " is no stress ratio: give shares of q_max like 0.2,0.4,0.75, above ",
          "0 and at most ", kLargestRatio));
    }
    ratios.push_back(ratio);
  }
  if (auto once = check_once_each(ratios); !once.ok()) return once;
  return ratios;
}

absl::StatusOr<VariedKey> parse_varied_key(const std::string& text) {
  const auto equals = text.find('=');
  VariedKey varied;
  varied.key = trimmed(text.substr(0, equals));
  if (equals == std::string::npos || varied.key.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        creep::quoted(text), " is not KEY=VALUE,VALUE: give e.g. numerics.minimum_cycles=20000,40000"));
  }
  if (varied.key == "specimen.seed") return absl::InvalidArgumentError("specimen.seed is varied by --seeds");
  varied.values = split_values(std::string_view(text).substr(equals + 1));
  for (const std::string& value : varied.values) {
    if (value.empty())
      return absl::InvalidArgumentError(absl::StrCat(creep::quoted(text), " has an empty value"));
  }
  if (auto once = check_once_each(varied.values); !once.ok()) return once;
  return varied;
}

}  // namespace creepctl
