/// Does the gyro turn when the odometry turns: about which axis, how much, and how much later?
///
/// Both become rates on one grid of time; running sums of products at 101 delays are all that is kept, so
/// that a day's log takes no more memory than a minute's.
#pragma once

#include <optional>

#include "inertial/lag_sums.h"
#include "inertial/rate_on_grid.h"
#include "inertial/stretches.h"

namespace loopline::inertial {

struct Agreement {
    double compared_s = 0;          ///< time in which both were there
    double odometry_rms_radps = 0;  ///< about its mean
    LagPeak peak;
    double correlation = 0;  ///< of the axis that agrees best, signed
    /// Gyro stamps less odometry stamps, and its standard error; none if it is a second or more, or not seen
    /// at all.
    std::optional<double> gyro_later_s;
    double gyro_later_sigma_s = 0;
    int stretches = 0;  ///< from whose scatter that is
};

class HeadingAgreement {
 public:
    HeadingAgreement();
    void add_gyro(StampNs stamp_ns, const Eigen::Vector3d& omega_base_radps);
    void add_odometry(StampNs stamp_ns, double heading_rad);
    Agreement result() const;

 private:
    void compare();
    void compare_cell(std::int64_t cell);
    void measure_lag(const LagSums& total, Agreement& agreement) const;

    RateOnGrid<3> gyro_;
    RateOnGrid<1> odometry_;
    std::optional<StampNs> gyro_stamp_ns_;
    Eigen::Vector3d gyro_rate_radps_, gyro_angle_rad_ = Eigen::Vector3d::Zero();
    std::optional<double> last_heading_rad_;
    double heading_rad_ = 0;  ///< unwrapped
    Stretches<LagSums> stretches_;
};

}  // namespace loopline::inertial
