/// A sweep as columns, and how well they lie on those of a map at a place and heading.
#pragma once

#include <optional>
#include <vector>

#include "api/pose3_motion.h"
#include "cloud_localisation/upright_columns.h"
#include "lidar_mapping/registration.h"

namespace loopline::cloud_localisation {

struct SweepFromAbove {
    std::vector<Eigen::Vector2f> upright_base_m;      ///< middles of upright columns
    std::vector<Eigen::Vector3f> lowest_base_m;       ///< of columns close by, the lowest point of each
    std::vector<lidar_mapping::SweepPoint> standing;  ///< returns from upright columns
};

/// Undistorted by `velocity`; within `range_m` of the vehicle.
SweepFromAbove seen_from_above(const std::vector<lidar_mapping::SweepPoint>& points, const Twist3& velocity,
                               double range_m);

/// The vehicle at (x, y) with a heading, put on the ground of the map: height, roll and pitch by the lowest
/// points of columns that both have, z_map - z_base = z - pitch x + roll y. None where they have too few.
std::optional<Pose3> on_ground(const UprightColumns& map, const std::vector<Eigen::Vector3f>& lowest_base_m,
                               const Pose2& T_map_base);

/// How near the upright columns of a map are to each place, dense about a middle.
class UprightField {
 public:
    UprightField(const UprightColumns& map, const Eigen::Vector2d& middle_m, double radius_m);
    /// 0 .. 255, 0 outside.
    int at(float x_m, float y_m) const {
        const int x = cell_of(x_m - x0_m_), y = cell_of(y_m - y0_m_);
        return x < 0 || y < 0 || x >= side_ || y >= side_
                   ? 0
                   : values_[static_cast<std::size_t>(y) * static_cast<std::size_t>(side_) +
                             static_cast<std::size_t>(x)];
    }
    /// Of the map's columns within it, how many have points, and how many are upright.
    int columns() const { return columns_; }
    int upright() const { return upright_; }

 private:
    static int cell_of(float v_m) {
        return static_cast<int>(std::floor(v_m * static_cast<float>(1 / UprightColumns::cell_m)));
    }
    void stamp(int x, int y);

    int side_ = 0, columns_ = 0, upright_ = 0;
    float x0_m_ = 0, y0_m_ = 0;
    std::vector<std::uint8_t> values_;
};

}  // namespace loopline::cloud_localisation
