#include "pipeline/object_splitter.h"

#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <cmath>

#include "api/observation_class.h"
#include "pipeline/raw_value.h"

namespace loopline {
namespace {

using mrpt::obs::CActionRobotMovement2D;
using mrpt::obs::CActionRobotMovement3D;
using mrpt::obs::CObservation;
using mrpt::obs::CObservationOdometry;

constexpr double absurd_increment_m = 1e4;

bool sane(const Pose2& increment) {
    return std::isfinite(increment.x_m) && std::isfinite(increment.y_m) && std::isfinite(increment.phi_rad) &&
           std::hypot(increment.x_m, increment.y_m) < absurd_increment_m && std::abs(increment.phi_rad) < 1e3;
}

}  // namespace

void ObjectSplitter::take(const mrpt::serialization::CSerializable::Ptr& object) {
    if (auto observation = as<CObservation>(object)) {
        release_held_frame();
        ready_.push_back(std::move(observation));
    } else if (const auto frame = as<mrpt::obs::CSensoryFrame>(object)) {
        take_frame(frame);
    } else if (const auto actions = as<mrpt::obs::CActionCollection>(object)) {
        take_actions(*actions);
    } else {
        ++other_objects_;
    }
}

void ObjectSplitter::end() {
    release_held_frame();
}

CObservation::Ptr ObjectSplitter::pop() {
    if (next_ < ready_.size()) return std::move(ready_[next_++]);
    ready_.clear();
    next_ = 0;
    return {};
}

/// Wheel odometry if there is any; else the first movement, whatever it was estimated from.
std::optional<ObjectSplitter::Movement> ObjectSplitter::movement_in(
    const mrpt::obs::CActionCollection& actions) {
    std::optional<Movement> movement;
    for (const auto& action : actions) {
        if (!action.get_ptr()) continue;
        if (const auto* planar = dynamic_cast<const CActionRobotMovement2D*>(action.get())) {
            const bool wheels = raw_value(planar->estimationMethod) == CActionRobotMovement2D::emOdometry;
            if (!wheels && (movement || !planar->poseChange.get_ptr())) continue;
            const auto pose = wheels ? planar->rawOdometryIncrementReading : planar->poseChange->getMeanVal();
            movement = Movement{{pose.x(), pose.y(), pose.phi()}, planar};
            if (wheels) break;
        } else if (const auto* spatial = dynamic_cast<const CActionRobotMovement3D*>(action.get())) {
            const auto& pose = spatial->rawOdometryIncrementReading;
            if (!movement && raw_value(spatial->estimationMethod) == CActionRobotMovement3D::emOdometry)
                movement = Movement{{pose.x(), pose.y(), pose.yaw()}, nullptr};
        }
    }
    return movement;
}

void ObjectSplitter::take_actions(const mrpt::obs::CActionCollection& actions) {
    const auto movement = movement_in(actions);
    if (!movement) return release_held_frame();
    if (held_frame_) odometry_due_ = true;  // the log has odometry, so its first frame gets the origin
    release_held_frame();
    odometry_due_ = true;
    if (!sane(movement->increment)) {
        ++refused_increments_;
        return;
    }
    // What the wheels did before the first frame moves no observation.
    if (any_frame_) T_odometry_base_ = T_odometry_base_ * movement->increment;
    const auto* planar = movement->planar;
    has_ticks_ = planar != nullptr && is_set(planar->hasEncodersInfo);
    if (has_ticks_ && any_frame_) {
        left_ticks_ += static_cast<std::uint32_t>(planar->encoderLeftTicks);
        right_ticks_ += static_cast<std::uint32_t>(planar->encoderRightTicks);
    }
    has_velocity_ = planar != nullptr && is_set(planar->hasVelocities) &&
                    std::isfinite(planar->velocityLocal.vx) && std::isfinite(planar->velocityLocal.vy) &&
                    std::isfinite(planar->velocityLocal.omega);
    if (has_velocity_) velocity_base_ = planar->velocityLocal;
}

void ObjectSplitter::take_frame(const mrpt::obs::CSensoryFrame::Ptr& frame) {
    release_held_frame();
    if (!any_frame_ && !odometry_due_)
        held_frame_ = frame;
    else
        deliver(*frame);
}

void ObjectSplitter::release_held_frame() {
    if (!held_frame_) return;
    const auto frame = std::move(held_frame_);
    held_frame_.reset();
    deliver(*frame);
}

void ObjectSplitter::deliver(mrpt::obs::CSensoryFrame& frame) {
    bool first = true;
    for (const auto& observation : frame) {
        if (!observation) continue;
        if (first && odometry_due_) {
            auto odometry = CObservationOdometry::Create();
            odometry->timestamp = observation->timestamp;
            odometry->sensorLabel = "odometry";
            odometry->odometry = {T_odometry_base_.x_m, T_odometry_base_.y_m, T_odometry_base_.phi_rad};
            odometry->hasEncodersInfo = has_ticks_;
            odometry->encoderLeftTicks = static_cast<std::int32_t>(left_ticks_);
            odometry->encoderRightTicks = static_cast<std::int32_t>(right_ticks_);
            odometry->hasVelocities = has_velocity_;
            odometry->velocityLocal = velocity_base_;
            ready_.push_back(std::move(odometry));
            odometry_due_ = false;
        }
        first = false;
        any_frame_ = true;
        ready_.push_back(observation);
    }
}

}  // namespace loopline
