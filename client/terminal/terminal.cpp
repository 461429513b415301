#include "client/terminal/terminal.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

namespace creepctl {
namespace {

std::string painted(std::string_view escape, std::string_view text, std::FILE* stream) {
  std::string out(text);
  if (colour_wanted(stream)) out = std::string(escape) + out + "\033[0m";
  return out;
}

}  // namespace

bool is_terminal(std::FILE* stream) { return ::isatty(fileno(stream)) == 1; }

int terminal_width(std::FILE* stream) {
  winsize size{};
  if (::ioctl(fileno(stream), TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  return 80;
}

bool terminal_draws_unicode() {
  for (const char* name : {"LC_ALL", "LC_CTYPE", "LANG"}) {
    const char* value = std::getenv(name);
    if (value == nullptr || *value == '\0') continue;
    return std::strstr(value, "UTF-8") != nullptr || std::strstr(value, "utf8") != nullptr;
  }
  return false;
}

void complain(std::string_view message) {
  std::fprintf(stderr, "%s %.*s\n", red("creepctl:", stderr).c_str(), static_cast<int>(message.size()),
               message.data());
}

bool colour_wanted(std::FILE* stream) {
  const char* no_colour = std::getenv("NO_COLOR");  // no-color.org: any non-empty value
  return is_terminal(stream) && (no_colour == nullptr || *no_colour == '\0');
}

std::string red(std::string_view text, std::FILE* stream) { return painted("\033[1;31m", text, stream); }

std::string yellow(std::string_view text, std::FILE* stream) { return painted("\033[1;33m", text, stream); }

}  // namespace creepctl
