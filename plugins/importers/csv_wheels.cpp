#include "importers/csv_wheels.h"

#include <mrpt/obs/CObservationOdometry.h>

namespace loopline::csv {
namespace {

mrpt::obs::CObservationOdometry::Ptr odometry_observation(const std::string& label, StampNs stamp_ns,
                                                          const Pose2& T_odom_base,
                                                          const std::optional<CarVelocity>& velocity) {
    auto observation = mrpt::obs::CObservationOdometry::Create();
    observation->sensorLabel = label;
    observation->timestamp = stamp_to_mrpt(stamp_ns);
    observation->odometry = {T_odom_base.x_m, T_odom_base.y_m, T_odom_base.phi_rad};
    observation->hasVelocities = velocity.has_value();
    if (velocity)
        observation->velocityLocal = {velocity->forward_mps, velocity->left_mps, velocity->turn_radps};
    return observation;
}

}  // namespace

OdometryStream::OdometryStream(ColumnMap& map, const Section& section, const std::string& path,
                               std::vector<Problem>& problems)
    : SensorStream(map, section, path, problems),
      x_(rows_.slot("x")),
      y_(rows_.slot("y")),
      yaw_(rows_.slot("yaw")),
      q_{rows_.slot("qw"), rows_.slot("qx"), rows_.slot("qy"), rows_.slot("qz")},
      speed_(rows_.slot("speed")),
      speed_left_(rows_.slot("speed_left")),
      turn_rate_(rows_.slot("turn_rate")) {}

bool OdometryStream::next(const Clock& clock, Reading& reading) {
    if (!rows_.next()) return false;
    Pose2 T_odom_base{rows_.value(x_), rows_.value(y_), 0};
    if (yaw_ != Rows::none)
        T_odom_base.phi_rad = wrap_to_pi(rows_.value(yaw_));
    else
        T_odom_base.phi_rad = Pose3({0, 0, 0}, Eigen::Quaterniond(rows_.value(q_[0]), rows_.value(q_[1]),
                                                                  rows_.value(q_[2]), rows_.value(q_[3]))
                                                   .normalized())
                                  .yaw_rad();
    std::optional<CarVelocity> velocity;
    if (speed_ != Rows::none)
        velocity = CarVelocity{rows_.value(speed_), rows_.value_or(speed_left_, 0), rows_.value(turn_rate_)};
    reading.known_ns = clock.utc_ns(rows_.time_ns());
    reading.observation = odometry_observation(section_.name, reading.known_ns, T_odom_base, velocity);
    return true;
}

CarStream::CarStream(ColumnMap& map, const Section& section, const std::string& path,
                     std::vector<Problem>& problems)
    : SensorStream(map, section, path, problems),
      speed_(rows_.slot("speed")),
      steering_(rows_.slot("steering")),
      left_(rows_.slot("left")),
      right_(rows_.slot("right")) {}

std::optional<CarVelocity> CarStream::velocity() const {
    if (section_.kind == Kind::wheels)
        return velocity_by_wheels(section_.track_width_m, rows_.value(left_), rows_.value(right_));
    const double angle_rad =
        (rows_.value(steering_) - section_.steering_offset_rad) / section_.steering_ratio;
    const SteeredCar& car = section_.car;
    const bool possible =
        std::abs(angle_rad) < M_PI / 2 && std::tan(angle_rad) / car.wheel_base_m * car.encoder_left_m < 0.9;
    if (!possible) return std::nullopt;
    return velocity_by_steering(car, rows_.value(speed_), angle_rad);
}

bool CarStream::next(const Clock& clock, Reading& reading) {
    while (rows_.next()) {
        const auto velocity = this->velocity();
        if (!velocity) {
            ++impossible_;
            continue;
        }
        reading.known_ns = clock.utc_ns(rows_.time_ns());
        path_.add(reading.known_ns, *velocity);
        reading.observation =
            odometry_observation(section_.name, reading.known_ns, path_.T_odom_base(), velocity);
        return true;
    }
    return false;
}

std::vector<std::string> CarStream::complaints() const {
    auto sentences = rows_.complaints();
    if (impossible_ > 0)
        sentences.push_back(
            "[" + section_.name + "]: " + std::to_string(impossible_) +
            " lines steer farther than wheels can and are left out; look at the unit of steering and "
            "at steering_ratio");
    return sentences;
}

}  // namespace loopline::csv
