/// Points of a map on the UTM grid, each for itself, for clouds of millions.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>

#include "gnss/geo_reference.h"
#include "gnss/utm.h"

namespace loopline::gnss {

/// Easting, northing and height above the ellipsoid by series of second order about the middles of cells of
/// 256 m, whose coefficients are differences of the exact ones: what is left out is of third order, below 1
/// um to 75 degrees of latitude and below 10 um everywhere, at a fraction of the time.
class UtmOfMap {
 public:
    /// All in the zone and hemisphere of `grid`.
    UtmOfMap(const GeoReference& reference, const Utm& grid) : reference_(reference), grid_(grid) {}

    Eigen::Vector3d p_utm_m(const Eigen::Vector3d& p_map_m);
    /// What the series stands for.
    Eigen::Vector3d exact_p_utm_m(const Eigen::Vector3d& p_map_m) const;

 private:
    using Key = std::array<std::int32_t, 3>;
    struct Cell {
        Eigen::Vector3d middle_m, at_middle_m;
        Eigen::Matrix3d slope;
        std::array<Eigen::Matrix3d, 3> curvature;  ///< second derivatives of easting, northing, height
    };
    Cell cell_about(const Eigen::Vector3d& middle_m) const;

    GeoReference reference_;
    Utm grid_;
    std::map<Key, Cell> cells_;
    Key last_key_{};
    const Cell* last_ = nullptr;  ///< that of the point before
};

}  // namespace loopline::gnss
