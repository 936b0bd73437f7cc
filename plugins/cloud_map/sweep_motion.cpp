#include "cloud_map/sweep_motion.h"

#include <algorithm>
#include <cmath>

namespace loopline::cloud_map {
namespace {

constexpr double step_s = 0.003;
constexpr int most_legs = 400;

}  // namespace

bool SweepMotion::follow(const lidar::SpinningScan& scan, const PoseAt& T_map_base) {
    const double span_s = std::max(0.0, scan.end_s - scan.begin_s);
    const int legs = std::clamp(static_cast<int>(std::ceil(span_s / step_s)), 1, most_legs);
    const double leg_s = std::max(span_s / legs, 1e-6);
    const auto stamp_at = [&](double time_s) { return scan.stamp_ns + std::llround(1e9 * time_s); };
    const auto middle = T_map_base(stamp_at((scan.begin_s + scan.end_s) / 2));
    if (!middle) return false;
    middle_m_ = (*middle * scan.T_base_lidar).translation_m;
    begin_s_ = static_cast<float>(scan.begin_s);
    per_leg_s_ = static_cast<float>(1 / leg_s);
    legs_.clear();
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    Eigen::Vector3d t_m = Eigen::Vector3d::Zero();
    for (int k = 0; k <= legs; ++k) {
        const auto pose = T_map_base(stamp_at(scan.begin_s + leg_s * k));
        if (!pose) return false;
        const Pose3 T_map_lidar = *pose * scan.T_base_lidar;
        const Eigen::Matrix3d R_end = T_map_lidar.rotation.toRotationMatrix();
        const Eigen::Vector3d t_end_m = T_map_lidar.translation_m - middle_m_;
        if (k > 0)
            legs_.push_back({static_cast<float>(scan.begin_s + leg_s * (k - 1)), R.cast<float>(),
                             ((R_end - R) / leg_s).cast<float>(), t_m.cast<float>(),
                             ((t_end_m - t_m) / leg_s).cast<float>()});
        R = R_end;
        t_m = t_end_m;
    }
    return true;
}

}  // namespace loopline::cloud_map
