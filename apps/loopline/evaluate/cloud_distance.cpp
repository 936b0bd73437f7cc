#include "evaluate/cloud_distance.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace loopline {
namespace {

constexpr double cube_m = 0.5;

/// 21 bits a coordinate; walls that are farther away than that are not looked for by cubes.
std::uint64_t key_of(const Eigen::Array3d& cube) {
    std::uint64_t key = 0;
    for (int i = 0; i < 3; ++i)
        key = key << 21 |
              (static_cast<std::uint64_t>(static_cast<std::int64_t>(cube[i]) + (1 << 20)) & 0x1fffff);
    return key;
}

float value_at_share(std::vector<float>& values, double share) {
    const auto at =
        values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

}  // namespace

double distance_to_wall_m(const Eigen::Vector3d& p_m, const TrueWall& wall) {
    const Eigen::Vector2d along_m = wall.to_m - wall.from_m, from_m = p_m.head<2>() - wall.from_m;
    const double length2 = along_m.squaredNorm();
    const double u = length2 > 0 ? std::clamp(from_m.dot(along_m) / length2, 0.0, 1.0) : 0;
    const double outside_m = std::max({wall.bottom_m - p_m.z(), p_m.z() - wall.top_m, 0.0});
    return std::hypot((from_m - u * along_m).norm(), outside_m);
}

const std::vector<std::size_t>& WallDistance::candidates(const Eigen::Vector3d& p_m) {
    const Eigen::Array3d cube = (p_m.array() / cube_m).floor();
    const auto [place, is_new] = cubes_.try_emplace(key_of(cube));
    if (!is_new) return place->second;
    const Eigen::Vector3d centre_m = (cube_m * (cube + 0.5)).matrix();
    std::vector<double> distances_m;
    for (const TrueWall& wall : walls_) distances_m.push_back(distance_to_wall_m(centre_m, wall));
    const double diagonal_m = std::sqrt(3.0) * cube_m;
    const double limit_m = *std::min_element(distances_m.begin(), distances_m.end()) + diagonal_m + 1e-9;
    for (std::size_t i = 0; i < walls_.size(); ++i)
        if (distances_m[i] <= limit_m) place->second.push_back(i);
    return place->second;
}

double WallDistance::operator()(const Eigen::Vector3d& p_m) {
    double least_m = INFINITY;
    if (walls_.empty()) return least_m;
    if (!((p_m.array().abs() / cube_m) < (1 << 20)).all()) {
        for (const TrueWall& wall : walls_) least_m = std::min(least_m, distance_to_wall_m(p_m, wall));
        return least_m;
    }
    for (const std::size_t i : candidates(p_m))
        least_m = std::min(least_m, distance_to_wall_m(p_m, walls_[i]));
    return least_m;
}

CloudDistance cloud_to_walls(const mrpt::maps::CPointsMap& cloud, const Pose3& T_truth_map,
                             const SurveyedTruth& truth) {
    constexpr double near_level_m = 0.1;
    CloudDistance result;
    if (truth.walls.empty()) return result;
    const auto& levels_m = truth.levels_m;
    const auto counts = [&](double z_m) {
        if (levels_m.empty()) return true;
        const auto [lowest, highest] = std::minmax_element(levels_m.begin(), levels_m.end());
        if (z_m < *lowest || (levels_m.size() > 1 && z_m > *highest)) return false;
        return std::none_of(levels_m.begin(), levels_m.end(),
                            [z_m](double level_m) { return std::abs(z_m - level_m) < near_level_m; });
    };
    WallDistance distance(truth.walls);
    const Eigen::Matrix3d R = T_truth_map.rotation.toRotationMatrix();
    const auto& x = cloud.getPointsBufferRef_x();
    const auto& y = cloud.getPointsBufferRef_y();
    const auto& z = cloud.getPointsBufferRef_z();
    std::vector<float> distances_m;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const Eigen::Vector3d p_m = R * Eigen::Vector3d(x[i], y[i], z[i]) + T_truth_map.translation_m;
        if (p_m.allFinite() && counts(p_m.z())) distances_m.push_back(static_cast<float>(distance(p_m)));
    }
    result.points = distances_m.size();
    if (distances_m.empty()) return result;
    result.median_m = value_at_share(distances_m, 0.5);
    result.percentile_95_m = value_at_share(distances_m, 0.95);
    return result;
}

}  // namespace loopline
