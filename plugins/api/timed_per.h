/// A module that takes observations of several classes, and whose time is worth telling per those of some.
#pragma once

#include <string>
#include <vector>

#include "api/sweep_classes.h"

namespace loopline {

class TimedPer {
 public:
    virtual ~TimedPer() = default;
    /// Class names of the observations that `calls` in metrics.json counts, and that mean_ms is the time per:
    /// all that the module took, over these.
    virtual std::vector<std::string> timed_per() const = 0;
};

/// One that follows a spinning lidar: its time is told per sweep, whatever drives it.
class TimedPerSweep : public TimedPer {
 public:
    std::vector<std::string> timed_per() const override { return sweep_classes(); }
};

}  // namespace loopline
