/// Turns the objects of either rawlog format into observations in their order. In the format of sensory
/// frames, odometry comes as actions between the frames, increments mostly without a stamp: each becomes a
/// cumulative CObservationOdometry (sensorLabel "odometry"), stamped like the first observation of the frame
/// after it and delivered just before that. The vehicle's pose at the first frame is the origin.
#pragma once

#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <cstdint>
#include <optional>
#include <vector>

#include "api/pose2.h"

namespace loopline {

class ObjectSplitter {
 public:
    void take(const mrpt::serialization::CSerializable::Ptr& object);
    /// No object follows: lets go of what was held back.
    void end();

    /// The next observation; null if another object is needed.
    mrpt::obs::CObservation::Ptr pop();

    /// Odometry increments dropped because they are not finite, or longer than any vehicle moves between two
    /// scans.
    std::uint64_t refused_increments() const { return refused_increments_; }
    /// Objects that are neither frames, actions nor observations.
    std::uint64_t other_objects() const { return other_objects_; }

 private:
    struct Movement {
        Pose2 increment;
        const mrpt::obs::CActionRobotMovement2D* planar = nullptr;  ///< has ticks and velocities, perhaps
    };
    static std::optional<Movement> movement_in(const mrpt::obs::CActionCollection& actions);
    void take_actions(const mrpt::obs::CActionCollection& actions);
    void take_frame(const mrpt::obs::CSensoryFrame::Ptr& frame);
    void deliver(mrpt::obs::CSensoryFrame& frame);
    void release_held_frame();

    std::vector<mrpt::obs::CObservation::Ptr> ready_;
    std::size_t next_ = 0;  ///< of those
    /// The first frame waits until it is known whether the log has odometry at all.
    mrpt::obs::CSensoryFrame::Ptr held_frame_;
    bool any_frame_ = false;
    bool odometry_due_ = false;
    Pose2 T_odometry_base_;
    std::uint32_t left_ticks_ = 0, right_ticks_ = 0;  ///< unsigned: wraps where the sum leaves 32 bits
    bool has_ticks_ = false, has_velocity_ = false;
    mrpt::math::TTwist2D velocity_base_;
    std::uint64_t refused_increments_ = 0, other_objects_ = 0;
};

}  // namespace loopline
