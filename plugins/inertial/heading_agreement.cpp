#include "inertial/heading_agreement.h"

#include <algorithm>
#include <cmath>

#include "api/pose2.h"

namespace loopline::inertial {
namespace {
constexpr StampNs lag_cell_ns = 20'000'000;
constexpr double lag_cell_s = 0.02;
}  // namespace

HeadingAgreement::HeadingAgreement()
    : gyro_({lag_cell_ns, 300'000'000}),
      odometry_({lag_cell_ns, 2'000'000'000}),
      stretches_(10 / lag_cell_s) {}

void HeadingAgreement::add_gyro(StampNs stamp_ns, const Eigen::Vector3d& omega_base_radps) {
    if (gyro_stamp_ns_ && stamp_ns > *gyro_stamp_ns_)
        gyro_angle_rad_ +=
            (gyro_rate_radps_ + omega_base_radps) / 2 * seconds_between(*gyro_stamp_ns_, stamp_ns);
    gyro_stamp_ns_ = stamp_ns;
    gyro_rate_radps_ = omega_base_radps;
    gyro_.add(stamp_ns, gyro_angle_rad_);
    compare();
}

void HeadingAgreement::add_odometry(StampNs stamp_ns, double heading_rad) {
    if (last_heading_rad_) heading_rad_ += wrap_to_pi(heading_rad - *last_heading_rad_);
    last_heading_rad_ = heading_rad;
    odometry_.add(stamp_ns, Eigen::Matrix<double, 1, 1>(heading_rad_));
    compare();
}

/// All cells that have the gyro's rates at all lags around them.
void HeadingAgreement::compare() {
    if (odometry_.empty() || gyro_.empty()) return;
    const std::int64_t from = std::max(odometry_.first(), gyro_.first() + LagSums::reach);
    const std::int64_t to = std::min(odometry_.end(), gyro_.end() - LagSums::reach);
    if (from >= to) return;
    for (std::int64_t cell = from; cell < to; ++cell) compare_cell(cell);
    odometry_.forget_before(to);
    gyro_.forget_before(to - LagSums::reach);
}

void HeadingAgreement::compare_cell(std::int64_t cell) {
    LagSums::Table gyro_radps;
    for (int lag = -LagSums::reach; lag <= LagSums::reach; ++lag)
        gyro_radps.row(lag + LagSums::reach) = gyro_.rate(cell + lag).transpose().array();
    stretches_.open().add(odometry_.rate(cell)(0), gyro_radps);
    stretches_.close_if_full();
}

Agreement HeadingAgreement::result() const {
    const LagSums total = stretches_.total();
    Agreement agreement;
    agreement.compared_s = total.n * lag_cell_s;
    if (total.n < 2) return agreement;
    agreement.peak = find_peak(total);
    agreement.correlation = agreement.peak.correlation(agreement.peak.axis);
    agreement.odometry_rms_radps = std::sqrt(std::max(0.0, total.odometry_squares() / total.n));
    measure_lag(total, agreement);
    return agreement;
}

/// Where the squares of the difference are least; its variance by the scatter of their slope from stretch to
/// stretch
/// ("sandwich" of White 1980): noise that lasts, and models that are not quite right, are in it.
void HeadingAgreement::measure_lag(const LagSums& total, Agreement& agreement) const {
    constexpr std::size_t fewest_stretches = 3;
    const auto middle = middle_of_peak(total, agreement.peak);
    if (!middle || stretches_.closed().size() < fewest_stretches) return;
    const LagParabola parabola = parabola_around(*middle, total, agreement.peak);
    const double from_middle = -parabola.slope / parabola.curvature;
    double squares = 0;
    for (const auto& stretch : stretches_.closed()) {
        const LagParabola part = parabola_around(*middle, stretch, agreement.peak);
        const double slope = part.slope + part.curvature * from_middle;
        squares += slope * slope;
    }
    const auto n = static_cast<double>(stretches_.closed().size());
    agreement.stretches = static_cast<int>(stretches_.closed().size());
    agreement.gyro_later_s = lag_cell_s * (*middle + from_middle);
    agreement.gyro_later_sigma_s = lag_cell_s * std::sqrt(squares * n / (n - 1)) / parabola.curvature;
}

}  // namespace loopline::inertial
