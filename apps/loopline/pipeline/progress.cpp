#include "pipeline/progress.h"

#include <unistd.h>

#include <cmath>
#include <cstdio>

#include "commands/terminal.h"
#include "pipeline/log_source.h"

namespace loopline {

Progress::Progress(std::string what, bool wanted)
    : what_(std::move(what)), shown_(wanted && ::isatty(STDERR_FILENO) == 1) {}

void Progress::clear() {
    if (dirty_) clear_line_on_stderr();
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
    const std::size_t columns = columns_of(STDERR_FILENO).value_or(usual_columns);
    std::fprintf(stderr, "\r%s\033[K",
                 progress_text(what_, fraction, left_s, log_s / elapsed_s, columns).c_str());
    dirty_ = true;
}

std::string progress_text(const std::string& what, double fraction, double left_s, double real_time_factor,
                          std::size_t columns) {
    const auto part = [](const char* format, double value) {
        char text[64];
        std::snprintf(text, sizeof(text), format, value);
        return std::string(text);
    };
    constexpr std::size_t echo_of_ctrl_c = 3;  // "^C", and the column that the cursor takes
    const std::size_t room = columns > echo_of_ctrl_c ? columns - echo_of_ctrl_c : 0;
    std::string line = what + part(": %3.0f %%", 100 * fraction);
    for (const auto& more :
         {part(", %.0f s left", std::ceil(left_s)), part(", %.0f x real time", real_time_factor)})
        if (line.size() + more.size() <= room) line += more;
    return line.substr(0, room);
}

}  // namespace loopline
