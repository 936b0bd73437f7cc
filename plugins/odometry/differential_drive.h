/// Dead reckoning of a vehicle with two driven wheels, from encoder ticks and as a growing uncertainty.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "api/pose2.h"
#include "api/twist2.h"

namespace loopline {

/// Cumulative counts; forward is positive on both wheels.
struct WheelTicks {
    std::int64_t left = 0;
    std::int64_t right = 0;
};

struct DifferentialDrive {
    double metres_per_tick_left_m = 0;  ///< way of the left wheel's rim for one tick
    double metres_per_tick_right_m = 0;
    double track_width_m = 0;  ///< between the wheels' points of contact
};

/// The motion of the middle of the axle between two readings, wheels rolling at constant speeds (an arc):
/// forward = (right + left) / 2, turn = (right - left) / track width.
Twist2 motion_from_ticks(const DifferentialDrive& drive, const WheelTicks& before, const WheelTicks& after);

/// Adds 32-bit counts to 64-bit ones, so that a counter that overflows goes on counting.
class TickUnwrapper {
 public:
    WheelTicks operator()(std::int32_t left, std::int32_t right);

 private:
    template <class Archive>
    friend void fields(Archive&, TickUnwrapper&);
    std::optional<WheelTicks> last_;
};

/// Growth of the uncertainty: standard deviations after one metre of way, or one full turn. Variances grow in
/// proportion to the way (a random walk), so the result does not depend on the number of steps.
struct OdometryNoise {
    double along_m = 0.05;
    double across_m = 0.02;
    double heading_rad = 1 * M_PI / 180;            ///< after one metre
    double heading_per_turn_rad = 10 * M_PI / 180;  ///< after one full turn
};

/// Covariance of (x, y, phi) in the map frame at `T_map_b`, after a motion from `T_map_a` where it was
/// `covariance`: F P F^T + G Q G^T, with the noise acting along and across the mean heading of the motion.
Eigen::Matrix3d propagate_covariance(const Eigen::Matrix3d& covariance, const Pose2& T_map_a,
                                     const Pose2& T_map_b, const OdometryNoise& noise);

}  // namespace loopline
