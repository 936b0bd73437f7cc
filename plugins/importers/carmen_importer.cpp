#include "importers/carmen_importer.h"

#include <mrpt/obs/CSensoryFrame.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "importers/carmen_objects.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(CarmenImporter, Importer, loopline)

using carmen::Log;
using carmen::Message;
using carmen::Scan;

struct CarmenImporter::Sensor {
    Message message = Message::flaser;  ///< scans that other messages repeat are left out
    carmen::Mounting mounting;
    double max_range_m = 0;  ///< unless the scan says so itself
    std::optional<double> resolution_rad;
};

namespace {

constexpr double default_max_range_m =
    81;  // SICK lasers with centimetre ranges: above are their codes for "no echo"
constexpr std::size_t most_sentences = 10;

const Scan* scan_of(const carmen::Record& record, Message message) {
    const auto* scan = std::get_if<Scan>(&record);
    return scan && scan->message == message ? scan : nullptr;
}

std::size_t count_scans(const Log& log, Message message) {
    return static_cast<std::size_t>(
        std::count_if(log.records.begin(), log.records.end(),
                      [&](const auto& record) { return scan_of(record, message); }));
}

bool has_odometry(const Log& log) {
    return std::any_of(log.records.begin(), log.records.end(),
                       [](const auto& record) { return std::holds_alternative<carmen::Odometry>(record); });
}

std::string text(const char* format, double a, double b = 0, double c = 0) {
    char buffer[160];
    std::snprintf(buffer, sizeof buffer, format, a, b, c);
    return buffer;
}

}  // namespace

ModuleInfo CarmenImporter::info() const {
    return {"carmen",
            "CARMEN text logs (FLASER, ROBOTLASER1, RAWLASER1, ODOM): their own stamps, the file's order.",
            {},
            {},
            {"CObservation2DRangeScan", "CObservationOdometry", "CActionRobotMovement2D"}};
}

ParameterTable CarmenImporter::parameters() {
    return ParameterTable("carmen", info().sentence)
        .choice("format", format_, {{"sf", Format::sf}, {"observations", Format::observations}},
                "Pairs of an odometry action and a frame with the scan, or observations one by one.")
        .choice("stamp", stamp_, {{"ipc", Stamp::ipc}, {"logger", Stamp::logger}},
                "Take the time at which a message was sent, or at which the logger wrote it.")
        .angle("aperture_deg", aperture_rad_, {0, 360},
               "From the first to the last beam; 0 takes the log's own word, or guesses from the number of "
               "beams.")
        .real("min_range_m", min_range_m_, Range::at_least(0),
              "Ranges up to here are no returns: below 2 cm are the error codes of the small Hokuyo lasers.")
        .real("max_range_m", max_range_m_, Range::at_least(0),
              "Ranges from here on are no returns; 0 takes the log's own word, or 81 m.")
        .real(
            "laser_x_m", T_base_laser_.x_m, Range::any(),
            "Where the laser sits on the vehicle, ahead of its origin; all three 0 take the log's own word.")
        .real("laser_y_m", T_base_laser_.y_m, Range::any(), "The same, to the left.")
        .angle("laser_yaw_deg", T_base_laser_.phi_rad, {-180, 180}, "The same, turned counter-clockwise.")
        .real("sigma_range_m", sigma_range_m_, Range::at_least(0),
              "Standard deviation of a range, as noted with the scans.");
}

std::string CarmenImporter::import(const std::vector<std::string>& inputs, RawlogSink& sink) {
    Log log;
    for (const auto& input : inputs) {
        std::ifstream stream(input, std::ios::binary);
        if (!stream || stream.peek() == std::ifstream::traits_type::eof())
            throw std::runtime_error(input + " can't be read, or is empty; give a CARMEN log");
        carmen::read_log(stream, input, log);
    }
    const Sensor sensor = describe_sensor(log, sink);
    if (format_ == Format::sf)
        write_frames(log, sensor, sink);
    else
        write_observations(log, sensor, sink);
    return summary(log, sensor);
}

/// Reports what is damaged, chooses the message to use, and finds what all scans have in common.
CarmenImporter::Sensor CarmenImporter::describe_sensor(const Log& log, RawlogSink& sink) const {
    for (std::size_t i = 0; i < std::min(most_sentences, log.damaged.size()); ++i) sink.warn(log.damaged[i]);
    if (log.damaged.size() > most_sentences)
        sink.warn("and " + std::to_string(log.damaged.size() - most_sentences) +
                  " more damaged lines are left out");

    // CARMEN logs one scan as several messages: the richest kind counts.
    Sensor sensor;
    bool found = false;
    for (const Message message : {Message::robotlaser, Message::flaser, Message::rawlaser}) {
        const std::size_t scans = count_scans(log, message);
        if (scans > 0 && found)
            sink.warn(std::to_string(scans) + " " + name_of(message) + " lines repeat the " +
                      name_of(sensor.message) + " lines and are left out");
        if (scans > 0 && !found) sensor.message = message, found = true;
    }
    if (!found)
        throw std::runtime_error(
            "there is no laser scan (FLASER, ROBOTLASER1 or RAWLASER1 line) in the input");

    sensor.mounting = find_mounting(log, sensor.message);
    if (T_base_laser_.x_m != 0 || T_base_laser_.y_m != 0 || T_base_laser_.phi_rad != 0) {
        sensor.mounting.T_base_laser = T_base_laser_;
        sensor.mounting.source = carmen::Mounting::Source::given;
    }
    if (sensor.mounting.corrected_poses)
        sink.warn(
            "the laser poses are not at one place on the robot, so a mapper has corrected them; only the "
            "robot's raw odometry is used");
    sensor.max_range_m = max_range_m_ > 0
                             ? max_range_m_
                             : number_parameter(log, "robot_front_laser_max").value_or(default_max_range_m);
    if (const auto resolution_deg = number_parameter(log, "laser_front_laser_resolution"))
        sensor.resolution_rad = *resolution_deg * M_PI / 180;
    return sensor;
}

double CarmenImporter::aperture_rad(const Scan& scan, const Sensor& sensor) const {
    const std::size_t beams = scan.ranges_m.size();
    const auto steps = static_cast<double>(beams - 1);
    if (aperture_rad_ > 0) return aperture_rad_;
    if (scan.configuration) return scan.configuration->resolution_rad * steps;
    if (const auto aperture = carmen::aperture_of_beams_rad(beams)) return *aperture;
    if (sensor.resolution_rad && *sensor.resolution_rad * steps <= 2 * M_PI)
        return *sensor.resolution_rad * steps;
    throw std::runtime_error("a scan has " + std::to_string(beams) +
                             " beams, from which their aperture can't be guessed; give --aperture-deg");
}

mrpt::obs::CObservation2DRangeScan CarmenImporter::observation_of(const Scan& scan,
                                                                  const Sensor& sensor) const {
    carmen::ScanProperties properties;
    properties.stamp_ns = stamp_of(scan.times);
    properties.aperture_rad = aperture_rad(scan, sensor);
    properties.min_range_m = min_range_m_;
    properties.max_range_m =
        scan.configuration && max_range_m_ == 0 ? scan.configuration->max_range_m : sensor.max_range_m;
    properties.sigma_range_m = sigma_range_m_;
    properties.T_base_laser = sensor.mounting.T_base_laser;
    return carmen::scan_observation(scan, properties);
}

void CarmenImporter::write_frames(const Log& log, const Sensor& sensor, RawlogSink& sink) const {
    if (sensor.message == Message::rawlaser)
        throw std::runtime_error(
            "RAWLASER1 scans carry no odometry to make actions of; give --format observations");
    std::optional<Pose2> T_odom_before;
    for (const auto& record : log.records) {
        const Scan* scan = scan_of(record, sensor.message);
        if (!scan) continue;
        const Pose2 T_odom_base = *scan->T_odom_base;
        const Pose2 T_before_now = T_odom_before ? T_odom_before->inverse() * T_odom_base : Pose2{};
        sink.write(carmen::odometry_action(T_before_now, stamp_of(scan->times)));
        T_odom_before = T_odom_base;
        mrpt::obs::CSensoryFrame frame;
        frame.insert(mrpt::obs::CObservation2DRangeScan::Create(observation_of(*scan, sensor)));
        sink.write(frame);
    }
}

void CarmenImporter::write_observations(const Log& log, const Sensor& sensor, RawlogSink& sink) const {
    const bool own_odometry = has_odometry(log);
    for (const auto& record : log.records) {
        if (const auto* odometry = std::get_if<carmen::Odometry>(&record)) {
            sink.write(carmen::odometry_observation(*odometry, stamp_of(odometry->times)));
        } else if (const Scan* scan = scan_of(record, sensor.message)) {
            if (!own_odometry && scan->T_odom_base)
                sink.write(carmen::odometry_observation(*scan->T_odom_base, stamp_of(scan->times)));
            sink.write(observation_of(*scan, sensor));
        }
    }
}

std::string CarmenImporter::summary(const Log& log, const Sensor& sensor) const {
    std::size_t backwards = 0;
    std::optional<StampNs> first, last, before;
    const Scan* example = nullptr;
    for (const auto& record : log.records) {
        const Scan* scan = scan_of(record, sensor.message);
        if (!scan) continue;
        if (!example) example = scan;
        const StampNs stamp_ns = stamp_of(scan->times);
        if (before && stamp_ns < *before) ++backwards;
        before = stamp_ns;
        first = std::min(first.value_or(stamp_ns), stamp_ns);
        last = std::max(last.value_or(stamp_ns), stamp_ns);
    }
    const Pose2& mount = sensor.mounting.T_base_laser;
    const char* const sources[] = {" (from its poses)", " (PARAM robot_frontlaser_offset)", " (as given)",
                                   " (assumed)"};
    std::string sentence =
        std::to_string(count_scans(log, sensor.message)) + " " + name_of(sensor.message) + " scans of " +
        std::to_string(example->ranges_m.size()) + " beams over " +
        text("%.1f degrees in %.1f s", aperture_rad(*example, sensor) * 180 / M_PI,
             seconds_between(*first, *last)) +
        text(", laser at (%.3f, %.3f) m, %.1f degrees", mount.x_m, mount.y_m, mount.phi_rad * 180 / M_PI) +
        sources[static_cast<int>(sensor.mounting.source)];
    if (backwards > 0)
        sentence += "; the stamps go back " + std::to_string(backwards) + " times, the file's order is kept";
    for (const auto& [name, count] : log.skipped)
        sentence += "; " + std::to_string(count) + " " + name + " lines skipped";
    return sentence;
}

}  // namespace loopline
