/// What a module that closes loops offers beside Module, so that a state can be kept before each loop, and a
/// person can reject it afterwards. The host finds it by a cast.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "api/stamp.h"

namespace loopline {

class LoopCloser {
 public:
    virtual ~LoopCloser() = default;

    /// Number of the loop, its place in Results::loops from 1, that will be closed with the next item unless
    /// the .ini refuses it; 0 mostly.
    virtual std::uint64_t loop_at_hand() const = 0;
    /// Of its later scan.
    virtual StampNs loop_at_hand_ns() const = 0;

    /// The key of the module's section that names loops to refuse, and its value.
    virtual std::string refusals_key() const = 0;
    virtual std::string refusals() const = 0;
    /// Whether two values of that key, both in order, refuse the same up to the loop at hand at a stamp, that
    /// one not included: a state of then serves both.
    virtual bool refuse_alike_before(const std::string& a, const std::string& b, StampNs loop_ns) const = 0;

    /// After finish(): what a person must know about the loops that the .ini names.
    virtual std::vector<std::string> loop_warnings() const { return {}; }
};

/// A loop as the .ini and metrics.json name it: the later scan, and the earlier one whose place it is.
inline std::string loop_name(StampNs stamp_ns, StampNs old_stamp_ns) {
    return seconds_text(stamp_ns) + " - " + seconds_text(old_stamp_ns);
}

}  // namespace loopline
