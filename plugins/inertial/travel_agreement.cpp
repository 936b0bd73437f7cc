#include "inertial/travel_agreement.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace loopline::inertial {
namespace {

constexpr StampNs travel_cell_ns = 100'000'000;
constexpr double travel_cell_s = 0.1;

/// Products of f and a as complex numbers, conj(a) f, for rows x and y of `fa`: its angle is that from a to
/// f.
std::complex<double> product(const Eigen::Matrix<double, 3, 2>& fa) {
    return {fa(0, 0) + fa(1, 1), fa(1, 0) - fa(0, 1)};
}

}  // namespace

void TravelSums::add(const Eigen::Vector2d& a_mps2, const Eigen::Vector3d& f_mps2) {
    n += 1;
    a += a_mps2;
    aa += a_mps2.squaredNorm();
    f += f_mps2;
    fa += f_mps2 * a_mps2.transpose();
}

void TravelSums::operator+=(const TravelSums& more) {
    n += more.n;
    a += more.a;
    aa += more.aa;
    f += more.f;
    fa += more.fa;
}

TravelAgreement::TravelAgreement()
    : force_({travel_cell_ns, 300'000'000}),
      odometry_({travel_cell_ns, 2'000'000'000}),
      stretches_(10 / travel_cell_s) {}

void TravelAgreement::add_imu(StampNs stamp_ns, const Eigen::Vector3d& specific_force_base_mps2) {
    if (force_stamp_ns_ && stamp_ns > *force_stamp_ns_)
        force_integral_mps_ +=
            (force_mps2_ + specific_force_base_mps2) / 2 * seconds_between(*force_stamp_ns_, stamp_ns);
    force_stamp_ns_ = stamp_ns;
    force_mps2_ = specific_force_base_mps2;
    force_.add(stamp_ns, force_integral_mps_);
    compare();
}

void TravelAgreement::add_odometry(StampNs stamp_ns, const Pose2& T_odom_base) {
    if (last_pose_) {
        const Pose2 step = last_pose_->inverse() * T_odom_base;
        const double half_rad = step.phi_rad / 2;  // the chord of an arc points half of the turn aside
        way_and_heading_ +=
            Eigen::Vector2d(step.x_m * std::cos(half_rad) + step.y_m * std::sin(half_rad), step.phi_rad);
    }
    last_pose_ = T_odom_base;
    odometry_.add(stamp_ns, way_and_heading_);
    compare();
}

/// All cells that have the force, and the odometry of both neighbours.
void TravelAgreement::compare() {
    if (odometry_.empty() || force_.empty()) return;
    const std::int64_t from = std::max(odometry_.first() + 1, force_.first());
    const std::int64_t to = std::min(odometry_.end() - 1, force_.end());
    if (from >= to) return;
    for (std::int64_t cell = from; cell < to; ++cell) {
        const Eigen::Vector2d& now = odometry_.rate(cell);
        const double speeding_up_mps2 =
            (odometry_.rate(cell + 1)(0) - odometry_.rate(cell - 1)(0)) / (2 * travel_cell_s);
        stretches_.open().add({speeding_up_mps2, now(0) * now(1)}, force_.rate(cell));
        stretches_.close_if_full();
    }
    odometry_.forget_before(to - 1);
    force_.forget_before(to);
}

std::optional<MountYaw> TravelAgreement::mount_yaw(const Eigen::Matrix3d& righting) const {
    constexpr std::size_t fewest_stretches = 3;
    if (stretches_.closed().size() < fewest_stretches) return std::nullopt;
    const TravelSums total = stretches_.total();
    const Eigen::Vector2d mean_a = total.a / total.n;
    const Eigen::Vector3d mean_f = total.f / total.n;
    const double squares = total.aa - total.n * mean_a.squaredNorm();
    const auto about_means = [&](const TravelSums& s) {
        return product(righting * (s.fa - mean_f * s.a.transpose() - s.f * mean_a.transpose() +
                                   s.n * mean_f * mean_a.transpose()));
    };
    const std::complex<double> sum = about_means(total);
    if (squares <= 0 || std::abs(sum) == 0) return std::nullopt;
    const std::complex<double> direction = sum / std::abs(sum);
    double scatter = 0;
    for (const auto& stretch : stretches_.closed()) {
        const double aside = std::imag(about_means(stretch) * std::conj(direction));
        scatter += aside * aside;
    }
    const auto n = static_cast<double>(stretches_.closed().size());
    return MountYaw{-std::arg(direction), std::sqrt(scatter * n / (n - 1)) / std::abs(sum),
                    static_cast<int>(stretches_.closed().size()), std::abs(sum) / squares};
}

}  // namespace loopline::inertial
