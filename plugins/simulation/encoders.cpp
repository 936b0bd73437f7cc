#include "simulation/encoders.h"

#include <algorithm>
#include <cmath>

namespace loopline::simulation {

std::int64_t Encoders::ticks(double rim_m) const {
    return settings_.metres_per_tick_m > 0 ? std::llround(std::floor(rim_m / settings_.metres_per_tick_m))
                                           : 0;
}

/// The ways as the computer on board sees them.
WheelPair Encoders::counted_m(const WheelPair& rim_m) const {
    const auto seen_m = [this](double way_m) {
        return settings_.metres_per_tick_m > 0
                   ? static_cast<double>(ticks(way_m)) * settings_.metres_per_tick_m
                   : way_m;
    };
    return {seen_m(rim_m.left) * settings_.scale_left, seen_m(rim_m.right) * settings_.scale_right};
}

void Encoders::reckon_until(StampNs time_ns) {
    const StampNs step_ns = drive_.motion.step_ns();
    while (time_ns_ < time_ns) {
        time_ns_ = std::min(time_ns, (time_ns_ / step_ns + 1) * step_ns);
        const WheelPair now_m = counted_m(drive_.rim_at(time_ns_));
        const double left_m = now_m.left - counted_m_.left, right_m = now_m.right - counted_m_.right;
        T_odom_base_ =
            T_odom_base_ * exp_se2({(right_m + left_m) / 2, 0, (right_m - left_m) / settings_.track_width_m});
        counted_m_ = now_m;
    }
}

EncoderReading Encoders::read(StampNs time_ns) {
    reckon_until(time_ns);
    const WheelPair rim_m = drive_.rim_at(time_ns);
    EncoderReading reading{ticks(rim_m.left), ticks(rim_m.right), T_odom_base_, {}};
    if (time_ns > last_reading_ns_) {
        const double duration_s = seconds_between(last_reading_ns_, time_ns);
        const double left_mps = (counted_m_.left - last_counted_m_.left) / duration_s;
        const double right_mps = (counted_m_.right - last_counted_m_.right) / duration_s;
        reading.velocity = {(right_mps + left_mps) / 2, 0, (right_mps - left_mps) / settings_.track_width_m};
    }
    last_reading_ns_ = time_ns;
    last_counted_m_ = counted_m_;
    return reading;
}

}  // namespace loopline::simulation
