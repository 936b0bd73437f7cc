/// The beginning of the path on the Earth: until its heading is known, fixes are kept.
#include <algorithm>
#include <cmath>

#include "fusion/earth_path.h"

namespace loopline::fusion {
namespace {

constexpr double first_sigma_m = 100;  // nothing is known
/// The search's heading counts so many times less than it says: the filter uses the same fixes again.
constexpr double heading_sigma_factor = 5;

}  // namespace

/// The first fix may be of where the receiver was when it was switched off: the frame then is that of the
/// first of those that came since.
void EarthPath::doubt_origin() {
    constexpr std::size_t others = 5;
    constexpr double far_m = 1000;
    if (early_.size() < others) return;
    const auto from_latest_m = [&](const gnss::Geodetic& place) {
        return gnss::LocalFrame(early_.back().antenna).p_enu_m(place).norm() - poses_.back().way_m;
    };
    const auto is_near = [&](const gnss::GnssFix& fix) { return from_latest_m(fix.antenna) < far_m; };
    if (from_latest_m(earth_->origin()) < far_m || !std::all_of(early_.end() - others, early_.end(), is_near))
        return;
    earth_.emplace(std::find_if(early_.begin(), early_.end(), is_near)->antenna);
    start_.clear();
    for (std::size_t i = 0; i + 1 < early_.size(); ++i) see_for_heading(early_[i]);
}

void EarthPath::look_for_heading(const gnss::GnssFix& fix) {
    early_.push_back(fix);
    doubt_origin();
    const auto found = see_for_heading(fix);
    if (!found) return;
    heading_ = {pose(pose_before(fix.stamp_ns)).way_m, found->sigma_rad};
    begin(found->T_enu_local);
}

std::optional<FoundHeading> EarthPath::see_for_heading(const gnss::GnssFix& fix) {
    HeadingStart::Settings settings{settings_.heading_sigma_rad};
    if (poses_.back().by_wheels) settings.wheels = settings_.wheels.first;
    const std::size_t before = pose_before(fix.stamp_ns);
    gnss::SigmaOfFix sigma = gnss::sigma_of(fix, settings_.noise);
    const double by_latency_m = before + 1 < poses() ? settings_.sigma_latency_s * speed_mps(before + 1) : 0;
    for (double& white_m : sigma.white_m) white_m = std::hypot(white_m, by_latency_m);
    return start_.see(seconds_between(first_ns_, fix.stamp_ns),
                      T_odom_at(before, fix.stamp_ns) * fix.p_base_antenna_m, earth_->p_enu_m(fix.antenna),
                      sigma, settings);
}

/// The search gave the place to linearise at. All fixes since the first pose are used again, so the heading
/// begins less certain than the search has it, and the place with nothing. The first of them count, also
/// where they contradict the search: it sees few of those that came while the vehicle stood.
void EarthPath::begin(const Pose3& T_enu_odom) {
    state_.T_enu_base = T_enu_odom * poses_.front().T_odom_base;
    StateVector sigma;  // along the vehicle's axes
    sigma << Eigen::Vector3d::Constant(first_sigma_m), settings_.sigma_roll_rad, settings_.sigma_pitch_rad,
        heading_sigma_factor * heading_.sigma_rad, Eigen::Vector3d::Zero(), settings_.wheels.first,
        settings_.sigma_antenna_m, settings_.sigma_antenna_m, 0;
    state_.covariance = sigma.cwiseAbs2().asDiagonal();
    const Matrix6d R = inertial::turned_both(state_.T_enu_base.rotation);
    state_.covariance.topLeftCorner<6, 6>() = propagated(R, state_.covariance.topLeftCorner<6, 6>());
    committed_ = 0;
    re_entry_.begin(early_.front().stamp_ns, 0);
    gain_foothold(re_entry_);
    for (const gnss::GnssFix& fix : early_) judge({fix}, apply(fix));
    early_ = {};
    start_.clear();
    look_ahead();
}

}  // namespace loopline::fusion
