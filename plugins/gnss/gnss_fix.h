/// One fix of a GNSS receiver, whatever brought it here.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "api/stamp.h"
#include "gnss/geodetic.h"

namespace loopline::gnss {

/// The codes of NMEA's GGA sentence.
enum class FixQuality {
    invalid = 0,
    single = 1,        ///< by the receiver alone
    differential = 2,  ///< by corrections of code ranges
    pps = 3,
    rtk_fixed = 4,  ///< carrier phases with whole ambiguities
    rtk_float = 5,  ///< carrier phases without
    estimated = 6,  ///< dead reckoning
    manual = 7,
    simulator = 8
};

/// From the code of a sentence; what it does not know is invalid.
inline FixQuality fix_quality(int code) {
    return code >= 0 && code <= 8 ? static_cast<FixQuality>(code) : FixQuality::invalid;
}

/// Whether satellites were measured: not invalid, dead reckoning, or a number that somebody entered.
inline bool is_measured(FixQuality quality) {
    return quality != FixQuality::invalid && quality != FixQuality::estimated &&
           quality != FixQuality::manual;
}

struct GnssFix {
    StampNs stamp_ns = 0;                ///< when the antenna was there
    std::optional<StampNs> received_ns;  ///< when the log's computer had the fix; later by the latency
    std::optional<StampNs> utc_ns;       ///< the receiver's own time of that, of the day nearest to the stamp
    FixQuality quality = FixQuality::invalid;
    Geodetic antenna;                  ///< place of the antenna
    bool has_position = false;         ///< false: `antenna` is nothing
    bool has_height = false;           ///< false: its height is nothing
    double geoid_separation_m = 0;     ///< geoid above the ellipsoid: height - separation is "above the sea"
    int satellites = 0;                ///< that were used; 0: not said
    std::optional<double> hdop, vdop;  ///< dilution of precision: sigma by that of a range
    std::optional<Eigen::Vector3d> sigma_enu_m;  ///< standard deviations as the receiver reports them
    std::optional<double> speed_mps;             ///< over ground
    std::optional<double> course_rad;            ///< of the motion, counter-clockwise from east
    std::optional<double> heading_rad;  ///< of the line between two antennas, counter-clockwise from east
    Eigen::Vector3d p_base_antenna_m = Eigen::Vector3d::Zero();  ///< lever arm

    bool is_usable() const { return has_position && is_measured(quality); }
};

/// Compass degrees, clockwise from north, as an angle within (-pi, pi] counter-clockwise from east; and back,
/// within [0, 360).
inline double east_angle_rad(double compass_deg) {
    const double angle_rad = std::remainder((90 - compass_deg) * rad_per_deg, 2 * M_PI);
    return angle_rad <= -M_PI ? M_PI : angle_rad;
}
inline double compass_deg(double east_angle_rad) {
    const double degrees = std::remainder(90 - east_angle_rad / rad_per_deg, 360);
    return degrees < 0 ? degrees + 360 : degrees;
}

}  // namespace loopline::gnss
