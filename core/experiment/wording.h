// The words of a diagnostic: quoting what the user wrote, listing what is allowed, guessing what was meant.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace creep {

/// `text` in double quotes, control characters escaped, cut to 60 code points: safe on a terminal.
std::string quoted(std::string_view text);

/// Everything of `text` that a terminal obeys rather than shows is escaped as \xNN, and so is what is no
/// UTF-8: control characters, also those of 8 bits, and the marks that turn the direction of writing. Nothing
/// else is changed.
std::string printable(std::string_view text);

/// The same, with line ends and tabs left.
std::string printable_lines(std::string_view text);

/// "a, b, c"
std::string listed(std::span<const std::string_view> words);

/// The number in the fewest digits that read back as the same double.
std::string shortest(double value);

/// The candidate that a typing slip most likely turned into `word`: least edit distance without regard to
/// case, the first of equals; none when every candidate is too far away.
std::optional<std::string_view> closest(std::string_view word, std::span<const std::string_view> candidates);

/// `; did you mean "x"?` for the closest candidate, else ` (allowed: a, b, c)`.
std::string guess_or_list(std::string_view word, std::span<const std::string_view> candidates);

}  // namespace creep
