#include "lidar_mapping/sweep_mapping.h"

#include <algorithm>
#include <cmath>

namespace loopline::lidar_mapping {

MotionPrior SweepMapping::predict(StampNs middle_ns) const {
    MotionPrior prior;
    prior.T_map_before = last_.T_map_base;
    prior.duration_s = seconds_between(last_ns_, middle_ns);
    prior.T_map_base = last_.T_map_base * exp_se3(last_motion_ * prior.duration_s);
    prior.velocity_change = change_;
    const double dt2 = prior.duration_s * prior.duration_s / 2;
    const double shift = std::max(1e-3, settings_.sigma_acceleration_mps2 * dt2 * (moved_ ? 1 : 100)),
                 turn = std::max(1e-4, settings_.sigma_turn_radps2 * dt2 * (moved_ ? 1 : 10));
    prior.information.diagonal().head<3>().setConstant(1 / (shift * shift));
    prior.information.diagonal().tail<3>().setConstant(1 / (turn * turn));
    return prior;
}

const Registration& SweepMapping::add(const lidar::SpinningScan& scan) {
    sampler_.sample(scan, settings_.sampling, settings_.map_voxel_m, points_);
    sampler_.thin_out(points_, settings_.match_voxel_m, matched_);
    const StampNs middle_ns = scan.stamp_ns + std::llround(1e9 * (scan.begin_s + scan.end_s) / 2);
    if (any_) {
        const MotionPrior prior = predict(middle_ns);
        last_ = register_sweep(map_, matched_, prior, settings_.registration);
        if (prior.duration_s > 0) {
            const Twist3 motion =
                log_se3(prior.T_map_before.inverse() * last_.T_map_base) * (1 / prior.duration_s);
            if (moved_)
                change_ = {motion.shift_m - last_motion_.shift_m, motion.turn_rad - last_motion_.turn_rad};
            last_motion_ = motion;
            moved_ = true;
        }
    }
    any_ = true;
    last_ns_ = middle_ns;
    add_to_map();
    return last_;
}

void SweepMapping::add_to_map() {
    for (const SweepPoint& point : points_) map_.add(last_.T_map_base * undistorted(point, last_.velocity));
    if ((last_.T_map_base.translation_m - forgot_at_m_).norm() < settings_.forget_every_m) return;
    forgot_at_m_ = last_.T_map_base.translation_m;
    map_.keep_around(forgot_at_m_);
}

}  // namespace loopline::lidar_mapping
