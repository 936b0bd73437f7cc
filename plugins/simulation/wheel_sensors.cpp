#include "simulation/wheel_sensors.h"

#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <limits>

namespace loopline::simulation {

ParameterTable WheelSensor::parameters() {
    return ParameterTable("wheels",
                          "Wheel encoders, and dead reckoning from them on board: CObservationOdometry.")
        .real("rate_hz", rate_hz_, {0.1, 1000}, "Readings a second.")
        .real(
            "metres_per_tick_m", settings_.metres_per_tick_m, {0, 1},
            "Way of a wheel's rim for one encoder tick; 0: encoders without steps, and no ticks in the log.")
        .real("scale_left", settings_.scale_left, {0.5, 2},
              "Way of the left wheel that dead reckoning believes in, as a multiple of the rim's true way.")
        .real("scale_right", settings_.scale_right, {0.5, 2}, "The same of the right wheel.")
        .real("sigma_scale", sigma_scale_, {0, 0.2},
              "Standard deviation of an error of either wheel's scale that the seed draws.")
        .real("sigma_common_scale", sigma_common_scale_, {0, 0.2},
              "The same of an error that both wheels have alike, as by the air in tyres.")
        .real("track_scale", track_scale_, {0.5, 2},
              "Track width that dead reckoning believes in, as a multiple of the vehicle's.");
}

void WheelSensor::start(const Scene& scene) {
    scene_ = &scene;
    settings_.track_width_m = scene.vehicle.track_width_m * track_scale_;
    EncoderSettings believed = settings_;
    RandomStream random(scene.seed, name());
    believed.scale_left += random.normal(sigma_scale_);
    believed.scale_right += random.normal(sigma_scale_);
    const double common = random.normal(sigma_common_scale_);
    believed.scale_left += common;
    believed.scale_right += common;
    encoders_ = std::make_unique<Encoders>(believed, scene.drive);
    index_ = 0;
}

mrpt::obs::CObservation::Ptr WheelSensor::next() {
    const StampNs time_ns = next_time_ns();
    const EncoderReading reading = encoders_->read(time_ns);
    auto observation = mrpt::obs::CObservationOdometry::Create();
    observation->sensorLabel = name();
    observation->timestamp = stamp_to_mrpt(scene_->start_ns + time_ns);
    observation->odometry = {reading.T_odom_base.x_m, reading.T_odom_base.y_m, reading.T_odom_base.phi_rad};
    if (settings_.metres_per_tick_m > 0) {
        observation->hasEncodersInfo = true;
        // As a counter of 32 bits that overflows.
        observation->encoderLeftTicks =
            static_cast<std::int32_t>(static_cast<std::uint32_t>(reading.left_ticks));
        observation->encoderRightTicks =
            static_cast<std::int32_t>(static_cast<std::uint32_t>(reading.right_ticks));
    }
    observation->hasVelocities = true;
    observation->velocityLocal = {reading.velocity.forward_m, reading.velocity.left_m,
                                  reading.velocity.turn_rad};
    ++index_;
    return observation;
}

ParameterTable CommandSensor::parameters() {
    return ParameterTable(
        "commands",
        "The way to drive that was commanded: a CObservationComment at each change, \"straight\", "
        "\"left\" or \"right\".");
}

void CommandSensor::start(const Scene& scene) {
    scene_ = &scene;
    index_ = 0;
}

StampNs CommandSensor::next_time_ns() const {
    const auto& commands = scene_->drive.commands;
    return index_ < commands.size() ? commands[index_].time_ns : std::numeric_limits<StampNs>::max();
}

mrpt::obs::CObservation::Ptr CommandSensor::next() {
    const Command& command = scene_->drive.commands[index_++];
    auto observation = mrpt::obs::CObservationComment::Create();
    observation->sensorLabel = name();
    observation->timestamp = stamp_to_mrpt(scene_->start_ns + command.time_ns);
    observation->text = command.regime == Regime::left    ? "left"
                        : command.regime == Regime::right ? "right"
                                                          : "straight";
    return observation;
}

std::string CommandSensor::summary() const {
    return "commands: " + std::to_string(index_ > 0 ? index_ - 1 : 0) + " changes of the way to drive.";
}

}  // namespace loopline::simulation
