/// Where the path lies on the Earth, before any filter can know: the search for the heading.
#include <cmath>

#include "fusion/earth_path.h"

namespace loopline::fusion {
namespace {

constexpr double first_sigma_m = 100;  // nothing is known
/// The search's heading counts so many times less than it says: the filter uses the same fixes again.
constexpr double heading_sigma_factor = 5;
constexpr double path_sigma_m = 0.02;  // of a place by the odometry against its neighbours
constexpr double seen_every_m = 0.3;   // way between fixes that the heading is sought by
constexpr std::size_t most_seen = 80;
constexpr double largest_misfit = 4;
constexpr std::size_t enough_to_judge = 12;

}  // namespace

void EarthPath::look_for_heading(const gnss::GnssFix& fix) {
    early_.push_back(fix);
    if (!see(fix)) return;
    const auto found = find_heading(seen_);
    if (!found) return;
    if (found->misfit > largest_misfit) {
        // The path has bent since by what its odometry does not know: look at its last part only.
        if (seen_.size() >= enough_to_judge)
            seen_.erase(seen_.begin(), seen_.begin() + static_cast<std::ptrdiff_t>(seen_.size() / 2));
        return;
    }
    if (found->sigma_rad > settings_.heading_sigma_rad) return;
    heading_found_sigma_rad_ = found->sigma_rad;
    heading_way_m_ = pose(pose_before(fix.stamp_ns)).way_m;
    begin(found->T_enu_local);
}

/// False where that tells nothing new: the vehicle has hardly moved.
bool EarthPath::see(const gnss::GnssFix& fix) {
    const Eigen::Vector3d p_local_m =
        T_odom_at(pose_before(fix.stamp_ns), fix.stamp_ns) * fix.p_base_antenna_m;
    if (!seen_.empty() && (p_local_m - seen_.back().p_local_m).norm() < seen_every_m) return false;
    if (seen_.size() >= most_seen) {  // every second one
        std::size_t kept = 0;
        for (std::size_t i = 0; i < seen_.size(); i += 2) seen_[kept++] = seen_[i];
        seen_.resize(kept);
    }
    SigmaOfFix sigma = sigma_of(fix, settings_.noise);
    // Wheels' scale, and a bend that they do not tell: a chord's error and an arc's height.
    const double way_m = seen_.empty() ? 0 : (p_local_m - seen_.front().p_local_m).norm();
    const Eigen::Vector3d wheels = poses_.back().by_wheels ? settings_.wheels.first : Eigen::Vector3d::Zero();
    const double path_m = path_sigma_m + way_m * (wheels[way_scale] / 2 + wheels[bend] * way_m / 8);
    for (double& white_m : sigma.white_m) white_m = std::hypot(white_m, path_m);
    seen_.push_back(
        {seconds_between(first_ns_, fix.stamp_ns), p_local_m, earth_->p_enu_m(fix.antenna), sigma});
    return true;
}

/// The search gave the place to linearise at. All fixes since the first pose are used again, so the heading
/// begins less certain than the search has it, and the place with nothing.
void EarthPath::begin(const Pose3& T_enu_odom) {
    state_.T_enu_base = T_enu_odom * poses_.front().T_odom_base;
    StateVector sigma;  // along the vehicle's axes
    sigma << Eigen::Vector3d::Constant(first_sigma_m), settings_.sigma_roll_rad, settings_.sigma_pitch_rad,
        heading_sigma_factor * heading_found_sigma_rad_, Eigen::Vector3d::Zero(), settings_.wheels.first;
    state_.covariance = sigma.cwiseAbs2().asDiagonal();
    const Matrix6d R = turned_both(state_.T_enu_base.rotation);
    state_.covariance.topLeftCorner<6, 6>() = R * state_.covariance.topLeftCorner<6, 6>() * R.transpose();
    committed_ = 0;
    for (const gnss::GnssFix& fix : early_) tally(apply(fix));
    early_ = {};
    seen_ = {};
    look_ahead();
}

}  // namespace loopline::fusion
