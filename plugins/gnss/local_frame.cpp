#include "gnss/local_frame.h"

namespace loopline::gnss {

Eigen::Vector3d p_ecef_m(const Geodetic& place) {
    const double phi = place.latitude_deg * rad_per_deg, lambda = place.longitude_deg * rad_per_deg;
    const double s = std::sin(phi), c = std::cos(phi);
    const double prime_vertical_m = wgs84::a_m / std::sqrt(1 - wgs84::e2 * s * s);
    const double from_axis_m = (prime_vertical_m + place.height_m) * c;
    return {from_axis_m * std::cos(lambda), from_axis_m * std::sin(lambda),
            (prime_vertical_m * (1 - wgs84::e2) + place.height_m) * s};
}

Geodetic geodetic_from_ecef(const Eigen::Vector3d& p) {
    constexpr double a = wgs84::a_m, b = wgs84::b_m, e2 = wgs84::e2;
    const double from_axis_m = std::hypot(p.x(), p.y());
    // Bowring 1976 with the reduced latitude u: near the ground the first step is exact to nanometres
    // already.
    constexpr double second_e2 = e2 / (1 - e2);
    double u = std::atan2(p.z() * a, from_axis_m * b), phi = 0;
    for (int step = 0; step < 4; ++step) {
        const double s = std::sin(u), c = std::cos(u);
        phi = std::atan2(p.z() + second_e2 * b * s * s * s, from_axis_m - e2 * a * c * c * c);
        u = std::atan2((1 - wgs84::flattening) * std::sin(phi), std::cos(phi));
    }
    const double s = std::sin(phi), c = std::cos(phi);
    // The distance along the normal, which has no trouble at the poles nor at the equator.
    const double height_m = from_axis_m * c + p.z() * s - a * std::sqrt(1 - e2 * s * s);
    const double lambda = from_axis_m > 0 ? std::atan2(p.y(), p.x()) : 0;
    return {phi / rad_per_deg, wrapped_longitude_deg(lambda / rad_per_deg), height_m};
}

Eigen::Matrix3d R_ecef_enu(double latitude_deg, double longitude_deg) {
    const double phi = latitude_deg * rad_per_deg, lambda = longitude_deg * rad_per_deg;
    const double sp = std::sin(phi), cp = std::cos(phi), sl = std::sin(lambda), cl = std::cos(lambda);
    Eigen::Matrix3d R;
    R << -sl, -sp * cl, cp * cl,  //
        cl, -sp * sl, cp * sl,    //
        0, cp, sp;
    return R;
}

LocalFrame::LocalFrame(const Geodetic& origin)
    : origin_(origin),
      p_ecef_origin_m_(gnss::p_ecef_m(origin)),
      R_ecef_enu_(gnss::R_ecef_enu(origin.latitude_deg, origin.longitude_deg)) {}

Eigen::Vector3d LocalFrame::p_enu_m(const Geodetic& place) const {
    return R_ecef_enu_.transpose() * (gnss::p_ecef_m(place) - p_ecef_origin_m_);
}

Geodetic LocalFrame::geodetic(const Eigen::Vector3d& p_enu_m) const {
    return geodetic_from_ecef(p_ecef_origin_m_ + R_ecef_enu_ * p_enu_m);
}

}  // namespace loopline::gnss
