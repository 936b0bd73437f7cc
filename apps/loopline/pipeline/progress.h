/// One line on a terminal that tells how far a pass over the log is; nothing in a pipe.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "api/stamp.h"

namespace loopline {

class LogSource;

/// What stands in the line, in at most `columns` less the room that an echoed ^C takes: what does not fit is
/// left out, so that the line never wraps.
std::string progress_text(const std::string& what, double fraction, double left_s, double real_time_factor,
                          std::size_t columns);

class Progress {
 public:
    /// Shows only if `wanted` and stderr is a terminal.
    Progress(std::string what, bool wanted);
    ~Progress() { clear(); }
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// After each item; looks at the clock now and then, and writes five times a second at most.
    void tick(const LogSource& source) {
        if (shown_ && ++ticks_ % 32 == 0) update(source);
    }
    void clear();

 private:
    using Clock = std::chrono::steady_clock;
    void update(const LogSource& source);

    std::string what_;
    bool shown_;
    bool dirty_ = false;
    std::uint64_t ticks_ = 0;
    Clock::time_point start_ = Clock::now(), last_ = start_;
};

}  // namespace loopline
