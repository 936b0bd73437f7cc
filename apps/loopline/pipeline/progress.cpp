#include "pipeline/progress.h"

#include <unistd.h>

#include <cmath>
#include <cstdio>

#include "pipeline/log_source.h"

namespace loopline {

Progress::Progress(std::string what, bool wanted)
    : what_(std::move(what)), shown_(wanted && ::isatty(STDERR_FILENO) == 1) {}

void Progress::clear() {
    if (dirty_) std::fputs("\r\033[K", stderr);
    dirty_ = false;
}

void Progress::update(const LogSource& source) {
    const auto now = Clock::now();
    if (now - last_ < std::chrono::milliseconds(200)) return;
    last_ = now;
    const double elapsed_s = std::chrono::duration<double>(now - start_).count();
    const double fraction = source.fraction_read();
    const double log_s = seconds_between(source.facts().first_stamp_ns(), source.facts().last_stamp_ns());
    const double left_s = fraction > 0 ? elapsed_s * (1 - fraction) / fraction : 0;
    std::fprintf(stderr, "\r%s: %3.0f %%, %.0f x real time, %.0f s left\033[K", what_.c_str(), 100 * fraction,
                 log_s / elapsed_s, std::ceil(left_s));
    dirty_ = true;
}

}  // namespace loopline
