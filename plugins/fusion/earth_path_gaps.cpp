/// Fixes that are withheld on purpose: how far the path is off at the end of each gap that they leave.
#include "fusion/earth_path.h"

namespace loopline::fusion {

/// Where the path is by now, and where the motion as it came would have it since the gap began.
void EarthPath::look_at_withheld(const gnss::GnssFix& fix) {
    settle_before(fix.stamp_ns);
    if (gaps_.empty() || gaps_.back().from_ns != used_ns_) gaps_.push_back({used_ns_});
    Gap& gap = gaps_.back();
    gap.to_ns = fix.stamp_ns;
    gap.end_pose = *committed_;
    gap.way_m = pose(*committed_).way_m - used_.way_m;
    gap.end_m = state_.T_enu_base.translation_m;
    gap.dead_reckoned_end_m =
        (used_.T_enu_base * used_.T_odom_base.inverse() * pose(*committed_).T_odom_base).translation_m;
    gap.sigma_m = state_.covariance.diagonal().head<3>().cwiseSqrt();
}

/// By the path that the fixes after each gap have made better. The last one counts only if there were any.
void EarthPath::judge_gaps(const std::vector<PoseOnEarth>& path) {
    if (!gaps_.empty() && gaps_.back().from_ns == used_ns_) gaps_.pop_back();
    for (Gap& gap : gaps_) {
        const Eigen::Vector3d& better_m = path[gap.end_pose].T_enu_base.translation_m;
        gap.off_m = gap.end_m - better_m;
        gap.dead_reckoning_off_m = gap.dead_reckoned_end_m - better_m;
    }
}

}  // namespace loopline::fusion
