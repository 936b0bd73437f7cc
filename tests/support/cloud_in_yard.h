/// Finished clouds of worlds of rectangles, and drives that are localised in them.
#pragma once

#include <gtest/gtest.h>

#include "cloud_localisation/cloud_localisation.h"
#include "support/second.h"
#include "support/spinning_world.h"

namespace loopline::test {

class PointsOfWorld : public PointFile {
 public:
    /// Points `apart_m` apart on all rectangles, `sigma_m` about them.
    PointsOfWorld(const std::vector<Rectangle>& world, double apart_m, double sigma_m) {
        std::mt19937_64 random(7);
        std::normal_distribution<double> normal;
        for (const Rectangle& r : world) {
            const int a = static_cast<int>(r.edge_a_m.norm() / apart_m),
                      b = static_cast<int>(r.edge_b_m.norm() / apart_m);
            const Eigen::Vector3d across = r.edge_a_m.cross(r.edge_b_m).normalized();
            for (int i = 0; i <= a; ++i)
                for (int k = 0; k <= b; ++k)
                    points_m_.push_back(r.corner_m + r.edge_a_m * i / std::max(1, a) +
                                        r.edge_b_m * k / std::max(1, b) + sigma_m * normal(random) * across);
        }
    }
    std::size_t size() const override { return points_m_.size(); }
    void for_each(std::size_t stride, const Use& use) const override {
        for (std::size_t i = 0; i < points_m_.size(); i += stride) use(points_m_[i]);
    }

 private:
    std::vector<Eigen::Vector3d> points_m_;
};

inline cloud_localisation::FrozenCloud cloud_of(const std::vector<Rectangle>& world) {
    WorkerPool workers(1);
    return cloud_localisation::FrozenCloud(PointsOfWorld(world, 0.12, 0.01),
                                           lidar_mapping::SurfaceMapSettings(), workers);
}

inline SpinningBeams quick_beams() {
    SpinningBeams beams;
    beams.rings = 24;
    beams.columns = 300;
    beams.sigma_range_m = 0.02;
    return beams;
}

/// A lidar 1.8 m above the vehicle's origin.
inline Pose3 T_base_lidar() {
    return {{0, 0, 1.8}, Eigen::Quaterniond::Identity()};
}

/// The worlds' own axes lie along those of the map's cubes, and their floor between two of these: nothing
/// real does.
inline Pose3 T_map_world() {
    return {{0.23, 0.11, 0.17}, Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()))};
}
inline std::vector<Rectangle> in_map(std::vector<Rectangle> world) {
    for (Rectangle& r : world)
        r = {T_map_world() * r.corner_m, T_map_world().rotation * r.edge_a_m,
             T_map_world().rotation * r.edge_b_m};
    return world;
}

/// On the floor of such a world, by its own axes.
inline Pose3 level_pose(double x_m, double y_m, double yaw_rad) {
    return T_map_world() * Pose3(Pose2{x_m, y_m, yaw_rad});
}

/// A sweep about `middle_ns` of a vehicle that is at `T_map_base` then and moves at `velocity`.
inline lidar::SpinningScan sweep_at(const std::vector<Rectangle>& world, const Pose3& T_map_base,
                                    const Twist3& velocity, StampNs middle_ns, std::mt19937_64& random) {
    auto scan = sweep_in(
        world, [&](double s) { return T_map_base * exp_se3(velocity * s) * T_base_lidar(); }, middle_ns,
        quick_beams(), random);
    scan.T_base_lidar = T_base_lidar();
    return scan;
}

/// A fix of that vehicle's antenna, above its rear.
inline cloud_localisation::FixInMap fix_of(const Pose3& T_map_base, StampNs stamp_ns, double sigma_m,
                                           const Eigen::Vector3d& off_m = Eigen::Vector3d::Zero()) {
    cloud_localisation::FixInMap fix;
    fix.stamp_ns = stamp_ns;
    fix.p_base_antenna_m = {-0.9, 0.3, 1.6};
    fix.p_map_m = T_map_base * fix.p_base_antenna_m + off_m;
    fix.sigma_m = sigma_m;
    fix.has_height = true;
    fix.sigma_z_m = 2 * sigma_m;
    return fix;
}

inline double turn_between_rad(const Pose3& a, const Pose3& b) {
    return a.rotation.angularDistance(b.rotation);
}

}  // namespace loopline::test
