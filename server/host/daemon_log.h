// Plain lines on standard error, where a service manager or a terminal picks them up.
#pragma once

#include <cstdio>
#include <string>

namespace creepd {

inline void log_line(const std::string& text) { std::fputs(("creepd: " + text + "\n").c_str(), stderr); }

}  // namespace creepd
