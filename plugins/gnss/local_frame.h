/// Cartesian coordinates: Earth-centred (ECEF), and local with x east, y north, z up (ENU).
#pragma once

#include <Eigen/Core>

#include "gnss/geodetic.h"

namespace loopline::gnss {

/// x through latitude 0, longitude 0; z through the north pole.
Eigen::Vector3d p_ecef_m(const Geodetic& place);
/// The inverse, by Bowring's iteration (1976): exact to nanometres from 100 km below ground to the
/// satellites.
Geodetic geodetic_from_ecef(const Eigen::Vector3d& p_ecef_m);

/// Axes of ENU at a place, as columns: p_ecef = origin + R p_enu.
Eigen::Matrix3d R_ecef_enu(double latitude_deg, double longitude_deg);

/// A tangent frame about an origin. A straight one: 1 km from the origin the ellipsoid is 78 mm below it.
class LocalFrame {
 public:
    explicit LocalFrame(const Geodetic& origin);

    const Geodetic& origin() const { return origin_; }
    Eigen::Vector3d p_enu_m(const Geodetic& place) const;
    Geodetic geodetic(const Eigen::Vector3d& p_enu_m) const;

 private:
    Geodetic origin_;
    Eigen::Vector3d p_ecef_origin_m_;
    Eigen::Matrix3d R_ecef_enu_;
};

}  // namespace loopline::gnss
