#include "gnss/gps_observation.h"

#include <algorithm>
#include <cmath>

#include "gnss/limits.h"

namespace loopline::gnss {
namespace {

using namespace mrpt::obs::gnss;

nv_oem6_position_type::nv_position_type_t position_type(FixQuality quality) {
    switch (quality) {
        case FixQuality::invalid:
            return nv_oem6_position_type::NONE;
        case FixQuality::differential:
        case FixQuality::pps:
            return nv_oem6_position_type::PSRDIFF;
        case FixQuality::rtk_fixed:
            return nv_oem6_position_type::NARROW_INT;
        case FixQuality::rtk_float:
            return nv_oem6_position_type::NARROW_FLOAT;
        case FixQuality::estimated:
            return nv_oem6_position_type::PROPAGATED;
        case FixQuality::manual:
            return nv_oem6_position_type::FIXEDPOS;
        default:
            return nv_oem6_position_type::SINGLE;
    }
}

/// Time of day, as NMEA's messages have it.
UTC_time time_of_day(StampNs stamp_ns) {
    const StampNs of_day_ns = ((stamp_ns % day_ns) + day_ns) % day_ns;
    const StampNs minutes = of_day_ns / 60'000'000'000;
    UTC_time time;
    time.hour = static_cast<std::uint8_t>(minutes / 60);
    time.minute = static_cast<std::uint8_t>(minutes % 60);
    time.sec = static_cast<double>(of_day_ns % 60'000'000'000) * 1e-9;
    return time;
}

Message_NMEA_GGA gga_message(const GnssFix& fix) {
    Message_NMEA_GGA gga;
    gga.fields.UTCTime = time_of_day(fix.stamp_ns);
    gga.fields.latitude_degrees = fix.antenna.latitude_deg;
    gga.fields.longitude_degrees = fix.antenna.longitude_deg;
    gga.fields.fix_quality = static_cast<std::uint8_t>(fix.quality);
    if (fix.has_height) {
        gga.fields.altitude_meters = fix.antenna.height_m - fix.geoid_separation_m;
        gga.fields.geoidal_distance = fix.geoid_separation_m;
        gga.fields.orthometric_altitude = gga.fields.corrected_orthometric_altitude = fix.antenna.height_m;
    }
    gga.fields.satellitesUsed = static_cast<std::uint32_t>(fix.satellites);
    gga.fields.thereis_HDOP = fix.hdop.has_value();
    gga.fields.HDOP = static_cast<float>(fix.hdop.value_or(0));
    return gga;
}

Message_NMEA_RMC rmc_message(const GnssFix& fix) {
    Message_NMEA_RMC rmc;
    rmc.fields.UTCTime = time_of_day(fix.stamp_ns);
    rmc.fields.validity_char = fix.quality == FixQuality::invalid ? 'V' : 'A';
    rmc.fields.latitude_degrees = fix.antenna.latitude_deg;
    rmc.fields.longitude_degrees = fix.antenna.longitude_deg;
    rmc.fields.speed_knots = fix.speed_mps.value_or(0) / mps_per_knot;
    rmc.fields.direction_degrees = fix.course_rad ? compass_deg(*fix.course_rad) : 0;
    mrpt::system::TTimeParts date;
    mrpt::system::timestampToParts(stamp_to_mrpt(fix.stamp_ns), date);
    rmc.fields.date_day = date.day;
    rmc.fields.date_month = date.month;
    rmc.fields.date_year = static_cast<std::uint8_t>(date.year % 100);
    rmc.fields.positioning_mode = fix.quality == FixQuality::invalid        ? 'N'
                                  : fix.quality == FixQuality::single       ? 'A'
                                  : fix.quality == FixQuality::differential ? 'D'
                                  : fix.quality == FixQuality::rtk_fixed    ? 'R'
                                  : fix.quality == FixQuality::rtk_float    ? 'F'
                                  : fix.quality == FixQuality::estimated    ? 'E'
                                  : fix.quality == FixQuality::manual       ? 'M'
                                                                            : 'A';
    return rmc;
}

Message_NV_OEM6_BESTPOS bestpos_message(const GnssFix& fix) {
    Message_NV_OEM6_BESTPOS best;
    best.fields.solution_stat = fix.quality == FixQuality::invalid ? nv_oem6_solution_status::INSUFFICIENT_OBS
                                                                   : nv_oem6_solution_status::SOL_COMPUTED;
    best.fields.position_type = position_type(fix.quality);
    best.fields.lat = fix.antenna.latitude_deg;
    best.fields.lon = fix.antenna.longitude_deg;
    best.fields.hgt = fix.antenna.height_m - fix.geoid_separation_m;
    best.fields.undulation = static_cast<float>(fix.geoid_separation_m);
    best.fields.lat_sigma = static_cast<float>(fix.sigma_enu_m->y());
    best.fields.lon_sigma = static_cast<float>(fix.sigma_enu_m->x());
    best.fields.hgt_sigma = static_cast<float>(fix.sigma_enu_m->z());
    best.fields.num_sats_sol = static_cast<std::uint8_t>(std::min(fix.satellites, 255));
    return best;
}

Message_NV_OEM6_INSPVAS inspvas_message(const GnssFix& fix) {
    Message_NV_OEM6_INSPVAS ins;
    ins.fields.lat = fix.antenna.latitude_deg;
    ins.fields.lon = fix.antenna.longitude_deg;
    ins.fields.hgt = fix.antenna.height_m;
    ins.fields.azimuth = compass_deg(*fix.heading_rad);
    ins.fields.ins_status = nv_oem6_ins_status_type::INS_SOLUTION_GOOD;
    return ins;
}

}  // namespace

mrpt::obs::CObservationGPS::Ptr gps_observation(const GnssFix& fix, const std::string& label) {
    auto observation = mrpt::obs::CObservationGPS::Create();
    observation->sensorLabel = label;
    observation->timestamp = stamp_to_mrpt(fix.stamp_ns);
    observation->has_satellite_timestamp = true;
    if (fix.received_ns) observation->originalReceivedTimestamp = stamp_to_mrpt(*fix.received_ns);
    observation->sensorPose.x(fix.p_base_antenna_m.x());
    observation->sensorPose.y(fix.p_base_antenna_m.y());
    observation->sensorPose.z(fix.p_base_antenna_m.z());
    const bool rmc_alone = fix.has_position && !fix.has_height;
    if (!rmc_alone) observation->setMsg(gga_message(fix));
    if (rmc_alone || fix.speed_mps) observation->setMsg(rmc_message(fix));
    if (fix.vdop) {
        Message_NMEA_GSA gsa;
        gsa.fields.fix_2D_3D = '3';
        gsa.fields.HDOP = fix.hdop.value_or(0);
        gsa.fields.VDOP = *fix.vdop;
        gsa.fields.PDOP = std::hypot(gsa.fields.HDOP, gsa.fields.VDOP);
        observation->setMsg(gsa);
    }
    if (fix.sigma_enu_m) observation->setMsg(bestpos_message(fix));
    if (fix.heading_rad) observation->setMsg(inspvas_message(fix));
    return observation;
}

}  // namespace loopline::gnss
