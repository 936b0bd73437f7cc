/// The wish of a user that the program ends: SIGINT or SIGTERM.
#pragma once

#include <chrono>

namespace loopline {

/// Tells a second wish from the same one delivered twice: `timeout` signals its program and then the
/// program's whole group, a shell that is itself ended passes on what the terminal has sent already. May be
/// used in a signal handler.
class Interruption {
 public:
    enum class Wish { stop, stop_at_once };
    Wish received() {
        const auto now = std::chrono::steady_clock::now();
        if (!asked_) first_ = now;
        asked_ = true;
        return now - first_ < same_wish ? Wish::stop : Wish::stop_at_once;
    }

 private:
    static constexpr std::chrono::milliseconds same_wish{300};
    bool asked_ = false;
    std::chrono::steady_clock::time_point first_{};
};

}  // namespace loopline
