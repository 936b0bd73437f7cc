#include "lidar_mapping/scan_sampling.h"

#include <array>
#include <cmath>
#include <optional>

#include "api/fetch.h"

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

VoxelKey ScanSampler::voxel_of(const Eigen::Vector3f& p_m) const {
    return pack({floor_to_int(p_m.x() * per_voxel_), floor_to_int(p_m.y() * per_voxel_),
                 floor_to_int(p_m.z() * per_voxel_)});
}

bool ScanSampler::is_first(VoxelKey key) {
    for (std::size_t k = hash(key) & mask_;; k = (k + 1) & mask_) {
        Slot& slot = slots_[k];
        if (slot.round != round_) {
            slot = {key, round_};
            return true;
        }
        if (slot.key == key) return false;
    }
}

/// The table does not fit into the processor's caches: places in it are fetched some at a time.
template <class PlaceOf, class Take>
void ScanSampler::for_firsts(std::size_t count, PlaceOf place_of, Take take) {
    struct Asked {
        std::size_t i;
        VoxelKey key;
    };
    std::array<Asked, 32> asked;
    for (std::size_t i = 0; i < count;) {
        std::size_t n = 0;
        for (; i < count && n < asked.size(); ++i) {
            const std::optional<Eigen::Vector3f> p_m = place_of(i);
            if (!p_m) continue;
            asked[n] = {i, voxel_of(*p_m)};
            fetch(&slots_[hash(asked[n++].key) & mask_]);
        }
        for (std::size_t k = 0; k < n; ++k)
            if (is_first(asked[k].key)) take(asked[k].i);
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
    const auto place_of = [&](std::size_t i) {
        const lidar::SpinningPoint& point = scan.points[i];
        const Eigen::Vector3f p(point.x_m, point.y_m, point.z_m);
        const float range2 = p.squaredNorm();
        return range2 > least2 && range2 < most2 ? std::optional(p) : std::nullopt;
    };
    for_firsts(scan.points.size(), place_of, [&](std::size_t i) {
        const Eigen::Vector3f p = *place_of(i), arm = R * p;
        points.push_back({arm + t, scan.points[i].time_s - middle_s, arm / p.norm()});
    });
}

void ScanSampler::thin_out(const std::vector<SweepPoint>& points, double voxel_m,
                           std::vector<SweepPoint>& fewer) {
    fewer.clear();
    begin(points.size(), voxel_m);
    for_firsts(
        points.size(), [&](std::size_t i) { return std::optional(points[i].p_base_m); },
        [&](std::size_t i) { fewer.push_back(points[i]); });
}

}  // namespace loopline::lidar_mapping
