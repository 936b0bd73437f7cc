#include "simulation/gnss_sensor.h"

#include <algorithm>
#include <cmath>

#include "gnss/gps_observation.h"

namespace loopline::simulation {

using gnss::FixQuality;
using gnss::GnssFix;

ParameterTable GnssSensor::parameters() {
    GnssErrorSettings& e = error_settings_;
    const auto noise = [](ParameterTable& table, const std::string& kind, PositionNoise& n,
                          const std::string& which) {
        table
            .real(kind + "_white_m", n.white_m, {0, 100},
                  "Standard deviation of east and of north of a " + which + ", drawn anew for each.")
            .real(kind + "_correlated_m", n.correlated_m, {0, 1000},
                  "The same of an error that wanders slowly.")
            .real(kind + "_correlation_s", n.correlation_s, {0.01, 1e6}, "Correlation time of that.");
    };
    ParameterTable table("gnss",
                         "A satellite receiver: CObservationGPS (GGA, RMC, GSA, and standard deviations as "
                         "BESTPOS), late by its latency.");
    table.real("rate_hz", rate_hz_, {0.1, 100}, "Fixes a second.")
        .real("latency_s", latency_s_, {0, 10}, "From a fix's moment to its place in the log, at least.")
        .real("latency_spread_s", latency_spread_s_, {0, 10}, "By how much it varies.")
        .choice("stamp", stamp_, {{"epoch", Stamp::epoch}, {"reception", Stamp::reception}},
                "Stamp of an observation: the fix's moment by the satellites' clocks, or when it came, as a "
                "computer without them says.")
        .real("x_m", p_base_antenna_m_.x(), {-100, 100},
              "Place of the antenna, forward of the vehicle's origin.")
        .real("y_m", p_base_antenna_m_.y(), {-100, 100}, "To the left.")
        .real("z_m", p_base_antenna_m_.z(), {-100, 100}, "Above.")
        .real("latitude_deg", latitude_deg_, {-89, 89}, "Of the map's origin, which is the first pose.")
        .real("longitude_deg", longitude_deg_, {-180, 180}, "The same, east.")
        .real("height_m", height_m_, {-500, 9000}, "The same, above the ellipsoid.")
        .real("heading_deg", heading_deg_, {-180, 180}, "Of the map's x axis, counter-clockwise from east.")
        .real("geoid_separation_m", geoid_separation_m_, {-110, 90}, "Geoid above the ellipsoid.")
        .choice("state", sky_.elsewhere,
                {{"fixed", FixQuality::rtk_fixed},
                 {"float", FixQuality::rtk_float},
                 {"single", FixQuality::single},
                 {"none", FixQuality::invalid}},
                "Kind of fix where no row says another.")
        .rows("state_m", sky_.by_way, {3, 0}, "from to code",
              "Kind of fix along the way since the start: 0 none, 1 single, 4 fixed, 5 float.")
        .rows("zone_m", sky_.by_zone, {5, 0}, "x1 y1 x2 y2 code",
              "The same in a rectangle of the map, which goes before the way.")
        .rows("state_s", sky_.by_time, {3, 0}, "from to code",
              "The same by the time since the start, which goes before both.")
        .real("refix_s", sky_.refix_s, {0, 1000},
              "So long after a time without fixes there is none better than float.");
    noise(table, "fixed", e.fixed, "fix with whole ambiguities");
    noise(table, "float", e.floating, "float fix");
    noise(table, "single", e.single, "single fix");
    table
        .real("vertical_factor", e.vertical_factor, {0, 100}, "Errors of the height are so many times those.")
        .real("sigma_velocity_mps", e.velocity_mps, {0, 10},
              "Standard deviation of the velocity to the east and to the north.")
        .real("reported_sigma_factor", reported_sigma_factor_, {0.001, 1000},
              "Standard deviations that are reported, by the true ones: below 1 for a receiver that believes "
              "too much in itself.")
        .real("multipath_per_min", e.multipath_per_min, {0, 600},
              "How often in a minute reflected signals make the position jump.")
        .real("multipath_m", e.multipath_m, {0, 1000}, "How far, about.")
        .real("multipath_s", e.multipath_s, {0.1, 1000}, "For how long, on the average.")
        .real("multipath_noticed", e.multipath_noticed, {0, 1},
              "Part of the jumps in which the receiver falls back to a single fix; in the others neither "
              "state nor "
              "deviations tell.");
    return table;
}

void GnssSensor::start(const Scene& scene) {
    scene_ = &scene;
    reference_ = geo_reference();
    errors_.emplace(error_settings_, rate_hz_, scene.seed);
    delays_.emplace(scene.seed, "gnss latency");
    ways_m_.clear();
    double way_m = 0;
    for (const Twist2& step : scene.drive.motion.twists())
        ways_m_.push_back(way_m += std::hypot(step.forward_m, step.left_m));
    index_ = received_ns_ = 0;
    lost_ns_.reset();
    std::fill(std::begin(count_of_), std::end(count_of_), 0);
    truth_ = {{"georeference", 0, {latitude_deg_, longitude_deg_, height_m_, heading_deg_}}};
    await_next();
}

/// Fixes come in their order, however much the latency varies.
void GnssSensor::await_next() {
    const double latency_s = latency_s_ + latency_spread_s_ * delays_->uniform();
    const auto latency_ns = static_cast<StampNs>(std::llround(latency_s * 1e7)) * 100;
    received_ns_ = std::max(epoch_ns() + latency_ns, received_ns_ + (index_ > 0 ? 100 : 0));
    errors_->advance();
}

Eigen::Vector3d GnssSensor::p_map_antenna_m(StampNs time_ns) const {
    return scene_->drive.motion.pose_at(time_ns) * p_base_antenna_m_;
}

FixQuality GnssSensor::quality_at(StampNs time_ns) {
    const auto step = static_cast<std::size_t>(time_ns / scene_->drive.motion.step_ns());
    const double way_m = step == 0 ? 0 : ways_m_[std::min(step, ways_m_.size()) - 1];
    const Eigen::Vector2d place_m = p_map_antenna_m(time_ns).head<2>();
    FixQuality quality = sky_.at(seconds_between(0, time_ns), way_m, place_m);
    if (quality == FixQuality::invalid) lost_ns_ = time_ns;
    const bool soon = lost_ns_ && seconds_between(*lost_ns_, time_ns) <= sky_.refix_s;
    if (quality == FixQuality::rtk_fixed && soon) quality = FixQuality::rtk_float;
    if (quality != FixQuality::invalid && errors_->multipath_noticed()) quality = FixQuality::single;
    return quality;
}

GnssFix GnssSensor::fix_at(StampNs time_ns, FixQuality quality) const {
    GnssFix fix;
    fix.stamp_ns = scene_->start_ns + time_ns;
    fix.received_ns = scene_->start_ns + received_ns_;
    fix.quality = quality;
    fix.p_base_antenna_m = p_base_antenna_m_;
    fix.satellites = errors_->satellites(quality);
    if (quality == FixQuality::invalid) return fix;

    fix.has_position = fix.has_height = true;
    fix.geoid_separation_m = geoid_separation_m_;
    const Eigen::Vector3d error_enu_m = errors_->position_enu_m(quality) + errors_->multipath_enu_m();
    fix.antenna =
        reference_.geodetic(p_map_antenna_m(time_ns) + reference_.R_enu_map().transpose() * error_enu_m);
    fix.hdop = hdop_of(fix.satellites);
    fix.vdop = vdop_of(fix.satellites);
    fix.sigma_enu_m = reported_sigma_factor_ * errors_->sigma_enu_m(quality);

    // Doppler shifts: the velocity of the antenna, over two steps about its moment.
    const StampNs step_ns = scene_->drive.motion.step_ns();
    const Eigen::Vector3d velocity_map_mps =
        (p_map_antenna_m(time_ns + step_ns) - p_map_antenna_m(time_ns - step_ns)) /
        (2 * seconds_between(0, step_ns));
    const Eigen::Vector3d velocity_enu_mps =
        reference_.R_enu_map() * velocity_map_mps + errors_->velocity_enu_mps();
    fix.speed_mps = velocity_enu_mps.head<2>().norm();
    fix.course_rad = std::atan2(velocity_enu_mps.y(), velocity_enu_mps.x());
    return fix;
}

mrpt::obs::CObservation::Ptr GnssSensor::next() {
    const StampNs time_ns = epoch_ns();
    const FixQuality quality = quality_at(time_ns);
    const GnssFix fix = fix_at(time_ns, quality);
    const auto observation = gnss::gps_observation(fix, name());
    if (stamp_ == Stamp::reception) {
        observation->timestamp = observation->originalReceivedTimestamp;
        observation->has_satellite_timestamp = false;
    }
    const Eigen::Vector3d antenna_m = p_map_antenna_m(time_ns);
    const double jump_m = quality == FixQuality::invalid ? 0 : errors_->multipath_enu_m().norm();
    truth_.push_back({"gnss",
                      static_cast<int>(index_),
                      {antenna_m.x(), antenna_m.y(), antenna_m.z(), static_cast<double>(quality), jump_m}});
    ++count_of_[static_cast<std::size_t>(quality)];
    ++index_;
    await_next();
    return observation;
}

std::string GnssSensor::summary() const {
    const auto count = [this](FixQuality quality) {
        return std::to_string(count_of_[static_cast<std::size_t>(quality)]);
    };
    const auto jumped = std::count_if(truth_.begin() + 1, truth_.end(),
                                      [](const TruthRow& row) { return row.values.back() > 0; });
    return "gnss: " + count(FixQuality::rtk_fixed) + " fixed, " + count(FixQuality::rtk_float) + " float, " +
           count(FixQuality::single) + " single, " + count(FixQuality::invalid) + " without a fix; " +
           std::to_string(jumped) + " off by multipath.";
}

}  // namespace loopline::simulation
