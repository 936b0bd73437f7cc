#include "cloud_localisation/frozen_cloud.h"

#include <limits>
#include <vector>

namespace loopline::cloud_localisation {
namespace {

constexpr std::size_t points_at_once = 1 << 16;
constexpr double farthest_m = 1e6;  ///< beyond it a cube has no number

}  // namespace

FrozenCloud::FrozenCloud(const PointFile& file, const lidar_mapping::SurfaceMapSettings& settings,
                         WorkerPool& workers)
    : surfaces_(settings),
      low_m_(Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity())),
      high_m_(-low_m_) {
    std::vector<Eigen::Vector3d> points_m;
    points_m.reserve(points_at_once);
    file.for_each(1, [&](const Eigen::Vector3d& p_m) {
        if (!(p_m.cwiseAbs().maxCoeff() < farthest_m)) return;
        points_m.push_back(p_m);
        if (points_m.size() < points_at_once) return;
        add(points_m, workers);
        points_m.clear();
    });
    add(points_m, workers);
}

/// Each size of cubes, and the columns, by itself: their order of points is that of the file.
void FrozenCloud::add(const std::vector<Eigen::Vector3d>& points_m, WorkerPool& workers) {
    // What is uncertain of a finished cloud's points is common to neighbours: there is no noise to be taken
    // off their surfaces.
    const Eigen::Matrix3f no_noise = Eigen::Matrix3f::Zero();
    const std::size_t sizes = surfaces_.sizes();
    workers.run(sizes + 1, [&](std::size_t task) {
        for (const Eigen::Vector3d& p_m : points_m) {
            if (task < sizes)
                surfaces_.add(task, {p_m, no_noise});
            else
                columns_.add(p_m);
        }
    });
    for (const Eigen::Vector3d& p_m : points_m) {
        low_m_ = low_m_.cwiseMin(p_m.head<2>());
        high_m_ = high_m_.cwiseMax(p_m.head<2>());
    }
    points_ += points_m.size();
}

double FrozenCloud::distance_m(const Eigen::Vector3d& p_map_m) const {
    const Eigen::Vector2d p = p_map_m.head<2>();
    return (low_m_ - p).cwiseMax(p - high_m_).cwiseMax(0.0).norm();
}

}  // namespace loopline::cloud_localisation
