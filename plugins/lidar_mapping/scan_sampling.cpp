#include "lidar_mapping/scan_sampling.h"

#include <algorithm>
#include <cmath>

namespace loopline::lidar_mapping {

void ScanSampler::begin(std::size_t points, double voxel_m) {
    per_voxel_ = static_cast<float>(1 / voxel_m);
    std::size_t size = 1024;
    while (size < 2 * points) size *= 2;
    if (size > slots_.size()) {
        slots_.assign(size, {no_voxel, 0});
        round_ = 0;
    }
    mask_ = slots_.size() - 1;
    ++round_;
}

bool ScanSampler::is_first(const Eigen::Vector3f& p_m) {
    const VoxelKey key = pack({floor_to_int(p_m.x() * per_voxel_), floor_to_int(p_m.y() * per_voxel_),
                               floor_to_int(p_m.z() * per_voxel_)});
    for (std::size_t k = hash(key) & mask_;; k = (k + 1) & mask_) {
        Slot& slot = slots_[k];
        if (slot.round != round_) {
            slot = {key, round_};
            return true;
        }
        if (slot.key == key) return false;
    }
}

void ScanSampler::sample(const lidar::SpinningScan& scan, const SamplingSettings& settings, double voxel_m,
                         std::vector<SweepPoint>& points) {
    points.clear();
    begin(scan.points.size(), voxel_m);
    const auto least2 = static_cast<float>(settings.min_range_m * settings.min_range_m),
               most2 = static_cast<float>(settings.max_range_m * settings.max_range_m),
               middle_s = static_cast<float>((scan.begin_s + scan.end_s) / 2);
    const Eigen::Matrix3f R = scan.T_base_lidar.rotation.toRotationMatrix().cast<float>();
    const Eigen::Vector3f t = scan.T_base_lidar.translation_m.cast<float>();
    for (const lidar::SpinningPoint& point : scan.points) {
        const Eigen::Vector3f p(point.x_m, point.y_m, point.z_m);
        const float range2 = p.squaredNorm();
        if (!(range2 > least2 && range2 < most2) || !is_first(p)) continue;
        const Eigen::Vector3f arm = R * p;
        points.push_back({arm + t, point.time_s - middle_s, arm / std::sqrt(range2)});
    }
}

void ScanSampler::thin_out(const std::vector<SweepPoint>& points, double voxel_m,
                           std::vector<SweepPoint>& fewer) {
    fewer.clear();
    begin(points.size(), voxel_m);
    for (const SweepPoint& point : points)
        if (is_first(point.p_base_m)) fewer.push_back(point);
}

}  // namespace loopline::lidar_mapping
