#include <algorithm>
#include <cmath>
#include <cstring>

#include "gnss/gps_observation.h"
#include "gnss/limits.h"

namespace loopline::gnss {
namespace {

using namespace mrpt::obs::gnss;

bool within(double value, double most) {
    return std::isfinite(value) && std::abs(value) <= most;
}

template <class Message>
const Message* message_of(const mrpt::obs::CObservationGPS& observation) {
    const auto found = observation.messages.find(static_cast<gnss_message_type_t>(Message::msg_type));
    return found == observation.messages.end() ? nullptr : dynamic_cast<const Message*>(found->second.get());
}

/// A receiver's time of day as a stamp; none if it is not one.
std::optional<StampNs> utc_near(const UTC_time& time, StampNs stamp_ns) {
    constexpr StampNs farthest_ns = 9'000'000'000'000'000'000;
    if (stamp_ns < -farthest_ns || stamp_ns > farthest_ns || time.hour > 23 || time.minute > 59 ||
        !(time.sec >= 0 && time.sec < 61))
        return std::nullopt;
    // To the microsecond: no sentence has more digits.
    const StampNs of_day_ns =
        (time.hour * 60 + time.minute) * 60'000'000'000 + std::llround(time.sec * 1e6) * 1000;
    return nearest_moment_ns(of_day_ns, stamp_ns);
}

/// The bits of an enumeration or flag: a damaged log may hold what its type has not.
template <class Value>
std::uint32_t bits_of(const Value& value) {
    std::uint32_t bits = 0;
    static_assert(sizeof value <= sizeof bits);
    std::memcpy(&bits, &value, sizeof value);
    return bits;
}

FixQuality quality_of(const Message_NV_OEM6_BESTPOS::content_t& best) {
    if (bits_of(best.solution_stat) != nv_oem6_solution_status::SOL_COMPUTED) return FixQuality::invalid;
    switch (bits_of(best.position_type)) {
        case nv_oem6_position_type::NONE:
        case nv_oem6_position_type::DOPPLER_VELOCITY:
            return FixQuality::invalid;
        case nv_oem6_position_type::FIXEDPOS:
        case nv_oem6_position_type::FIXEDHEIGHT:
            return FixQuality::manual;
        case nv_oem6_position_type::PROPAGATED:
        case nv_oem6_position_type::INS:
            return FixQuality::estimated;
        case nv_oem6_position_type::SINGLE:
        case nv_oem6_position_type::INS_PSRSP:
            return FixQuality::single;
        case nv_oem6_position_type::L1_INT:
        case nv_oem6_position_type::WIDE_INT:
        case nv_oem6_position_type::NARROW_INT:
        case nv_oem6_position_type::RTK_DIRECT_INS:
        case nv_oem6_position_type::INS_RTKFIXED:
            return FixQuality::rtk_fixed;
        case nv_oem6_position_type::FLOATCONV:
        case nv_oem6_position_type::WIDELANE:
        case nv_oem6_position_type::NARROWLANE:
        case nv_oem6_position_type::L1_FLOAT:
        case nv_oem6_position_type::IONOFREE_FLOAT:
        case nv_oem6_position_type::NARROW_FLOAT:
        case nv_oem6_position_type::INS_RTKFLOAT:
            return FixQuality::rtk_float;
        default:  // corrections from satellites or stations
            return FixQuality::differential;
    }
}

/// False if the place can't be.
bool take_place(double latitude_deg, double longitude_deg, GnssFix& fix) {
    fix.has_position = fix.quality != FixQuality::invalid;
    if (!fix.has_position) return true;  // what stands there is nothing
    fix.antenna.latitude_deg = latitude_deg;
    fix.antenna.longitude_deg = longitude_deg;
    return within(latitude_deg, 90) && within(longitude_deg, 360);
}

bool take_height(double altitude_m, double separation_m, GnssFix& fix) {
    fix.has_height = fix.has_position;
    if (!fix.has_position) return true;
    fix.geoid_separation_m = separation_m;
    fix.antenna.height_m = altitude_m + separation_m;
    return within(altitude_m, most_height_m) && within(separation_m, most_height_m);
}

bool take_gga(const Message_NMEA_GGA::content_t& gga, GnssFix& fix) {
    fix.utc_ns = utc_near(gga.UTCTime, fix.stamp_ns);
    fix.quality = fix_quality(gga.fix_quality);
    fix.satellites = static_cast<int>(std::min<std::uint32_t>(gga.satellitesUsed, 999));
    if (bits_of(gga.thereis_HDOP) != 0 && std::isfinite(gga.HDOP) && gga.HDOP >= 0) fix.hdop = gga.HDOP;
    return take_place(gga.latitude_degrees, gga.longitude_degrees, fix) &&
           take_height(gga.altitude_meters, gga.geoidal_distance, fix);
}

bool take_bestpos(const Message_NV_OEM6_BESTPOS::content_t& best, GnssFix& fix) {
    fix.quality = quality_of(best);
    fix.satellites = best.num_sats_sol;
    return take_place(best.lat, best.lon, fix) && take_height(best.hgt, best.undulation, fix);
}

bool take_rmc(const Message_NMEA_RMC::content_t& rmc, GnssFix& fix) {
    fix.utc_ns = utc_near(rmc.UTCTime, fix.stamp_ns);
    fix.quality = rmc.validity_char != 'A'      ? FixQuality::invalid
                  : rmc.positioning_mode == 'D' ? FixQuality::differential
                  : rmc.positioning_mode == 'E' ? FixQuality::estimated
                  : rmc.positioning_mode == 'M' ? FixQuality::manual
                  : rmc.positioning_mode == 'R' ? FixQuality::rtk_fixed
                  : rmc.positioning_mode == 'F' ? FixQuality::rtk_float
                                                : FixQuality::single;
    return take_place(rmc.latitude_degrees, rmc.longitude_degrees, fix);
}

void take_motion(const Message_NMEA_RMC::content_t& rmc, GnssFix& fix) {
    const double speed_mps = rmc.speed_knots * mps_per_knot;
    if (rmc.validity_char != 'A' || !(speed_mps >= 0 && speed_mps <= most_speed_mps)) return;
    fix.speed_mps = speed_mps;
    if (within(rmc.direction_degrees, 360)) fix.course_rad = east_angle_rad(rmc.direction_degrees);
}

}  // namespace

std::optional<GnssFix> fix_from_mrpt(const mrpt::obs::CObservationGPS& observation, StampNs stamp_ns) {
    const auto* gga = message_of<Message_NMEA_GGA>(observation);
    const auto* rmc = message_of<Message_NMEA_RMC>(observation);
    const auto* best = message_of<Message_NV_OEM6_BESTPOS>(observation);
    const auto* gsa = message_of<Message_NMEA_GSA>(observation);
    const auto* ins = message_of<Message_NV_OEM6_INSPVAS>(observation);
    GnssFix fix;
    fix.stamp_ns = stamp_ns;
    fix.received_ns = stamp_from_mrpt(observation.originalReceivedTimestamp);
    const auto& pose = observation.sensorPose;
    fix.p_base_antenna_m = {pose.x(), pose.y(), pose.z()};
    const bool possible = gga    ? take_gga(gga->fields, fix)
                          : best ? take_bestpos(best->fields, fix)
                          : rmc  ? take_rmc(rmc->fields, fix)
                                 : false;
    if (!possible) return std::nullopt;
    if (rmc) take_motion(rmc->fields, fix);
    if (gsa && within(gsa->fields.VDOP, most_dop) && gsa->fields.VDOP > 0) fix.vdop = gsa->fields.VDOP;
    if (best) {
        const Eigen::Vector3d sigma_enu_m(best->fields.lon_sigma, best->fields.lat_sigma,
                                          best->fields.hgt_sigma);
        if ((sigma_enu_m.array() > 0).all() && (sigma_enu_m.array() <= most_sigma_m).all())
            fix.sigma_enu_m = sigma_enu_m;
    }
    if (ins && bits_of(ins->fields.ins_status) == nv_oem6_ins_status_type::INS_SOLUTION_GOOD &&
        within(ins->fields.azimuth, 360))
        fix.heading_rad = east_angle_rad(ins->fields.azimuth);
    return fix;
}

}  // namespace loopline::gnss
