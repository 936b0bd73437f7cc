/// Wheel encoders and the dead reckoning of the computer on board, which reads them at every step of the
/// vehicle.
#pragma once

#include <cstdint>

#include "api/pose2.h"
#include "api/twist2.h"
#include "simulation/drive.h"

namespace loopline::simulation {

struct EncoderSettings {
    double metres_per_tick_m = 1e-4;  ///< 0: no steps
    double track_width_m = 0.4;       ///< that the computer on board reckons with
    double scale_left = 1;            ///< way that it believes in, by way of the rim
    double scale_right = 1;
};

struct EncoderReading {
    std::int64_t left_ticks = 0;
    std::int64_t right_ticks = 0;
    Pose2 T_odom_base;
    Twist2 velocity;  ///< m/s and rad/s: the mean since the reading before
};

class Encoders {
 public:
    Encoders(const EncoderSettings& settings, const Drive& drive) : settings_(settings), drive_(drive) {}

    /// Times must not go back.
    EncoderReading read(StampNs time_ns);

 private:
    void reckon_until(StampNs time_ns);
    std::int64_t ticks(double rim_m) const;
    WheelPair counted_m(const WheelPair& rim_m) const;

    EncoderSettings settings_;
    const Drive& drive_;
    StampNs time_ns_ = 0, last_reading_ns_ = 0;
    WheelPair counted_m_, last_counted_m_;
    Pose2 T_odom_base_;
};

}  // namespace loopline::simulation
