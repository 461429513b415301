// What a terminal shows beyond plain text.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>

namespace creepctl {

bool is_terminal(std::FILE* stream);

/// Columns of the terminal; 80 if the stream is none.
int terminal_width(std::FILE* stream);

/// Whether the locale is UTF-8.
bool terminal_draws_unicode();

/// Prints "creepctl: MESSAGE" on stderr.
void complain(std::string_view message);

/// Whether the stream is a terminal that wants colour: not a pipe, and NO_COLOR is not set.
bool colour_wanted(std::FILE* stream);

/// `text` in bold red or bold yellow where colour is wanted, else as it is.
std::string red(std::string_view text, std::FILE* stream);
std::string yellow(std::string_view text, std::FILE* stream);

}  // namespace creepctl
