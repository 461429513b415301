#include "client/terminal.h"

#include <unistd.h>

#include <cstdlib>

namespace creepctl {
namespace {

std::string painted(std::string_view escape, std::string_view text, std::FILE* stream) {
  std::string out(text);
  if (colour_wanted(stream)) out = std::string(escape) + out + "\033[0m";
  return out;
}

}  // namespace

bool colour_wanted(std::FILE* stream) {
  const char* no_colour = std::getenv("NO_COLOR");  // no-color.org: any non-empty value
  return isatty(fileno(stream)) == 1 && (no_colour == nullptr || *no_colour == '\0');
}

std::string red(std::string_view text, std::FILE* stream) { return painted("\033[1;31m", text, stream); }

std::string yellow(std::string_view text, std::FILE* stream) { return painted("\033[1;33m", text, stream); }

}  // namespace creepctl
