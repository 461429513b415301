#include "client/terminal/progress_display.h"

#include "client/terminal/terminal.h"

namespace creepctl {

ProgressDisplay::ProgressDisplay(std::FILE* stream, const creep::Experiment& experiment)
    : stream_(stream),
      experiment_(experiment),
      live_(is_terminal(stream)),
      unicode_(terminal_draws_unicode()) {}

void ProgressDisplay::show(const RunProgress& progress, bool at_the_end) {
  for (; warnings_shown_ < progress.warnings.size(); ++warnings_shown_) {
    warn(progress.warnings[warnings_shown_]);
  }
  const bool stage_began =
      progress.stage_index != shown_stage_ || progress.dynamic_stage != shown_dynamic_stage_;
  if (live_) {
    const int width = terminal_width(stream_) - 1;  // the last column would wrap
    std::fprintf(stream_, "\r\033[K%s", live_line(progress, experiment_, width, unicode_).c_str());
    line_open_ = true;
  } else if (at_the_end || stage_began || Clock::now() - shown_ >= std::chrono::seconds(5)) {
    const double elapsed = std::chrono::duration<double>(Clock::now() - start_).count();
    std::fprintf(stream_, "[%.0f s] %s\n", elapsed, plain_line(progress, experiment_).c_str());
    shown_ = Clock::now();
  }
  shown_stage_ = progress.stage_index;
  shown_dynamic_stage_ = progress.dynamic_stage;
  if (at_the_end) finish();
  std::fflush(stream_);
}

void ProgressDisplay::say(const std::string& line) {
  clear();
  std::fprintf(stream_, "%s\n", line.c_str());
  std::fflush(stream_);
}

void ProgressDisplay::warn(const std::string& line) {
  clear();
  std::fprintf(stderr, "%s %s\n", yellow("warning:", stderr).c_str(), line.c_str());
}

void ProgressDisplay::finish() {
  if (line_open_) std::fputc('\n', stream_);
  line_open_ = false;
  std::fflush(stream_);
}

void ProgressDisplay::clear() {
  if (line_open_) std::fputs("\r\033[K", stream_);
  line_open_ = false;
  std::fflush(stream_);
}

}  // namespace creepctl
