/// The true path of a simulated vehicle: constant twists, step by step, so that the pose is exact at any
/// nanosecond.
#pragma once

#include <utility>
#include <vector>

#include "api/pose2.h"
#include "api/pose3.h"
#include "api/stamp.h"
#include "api/twist2.h"
#include "simulation/ground.h"

namespace loopline::simulation {

/// Times are nanoseconds since the start.
class TrueMotion {
 public:
    TrueMotion() = default;
    TrueMotion(const Pose2& T_map_start, StampNs step_ns) : poses_{T_map_start}, step_ns_(step_ns) {}

    /// The vehicle moves by `twist` within the next step.
    void append(const Twist2& twist) {
        twists_.push_back(twist);
        poses_.push_back(poses_.back() * exp_se2(twist));
    }

    /// The vehicle moves to a pose within the next step, by a constant twist.
    void append_pose(const Pose2& T_map_base) {
        twists_.push_back(log_se2(poses_.back().inverse() * T_map_base));
        poses_.push_back(T_map_base);
    }

    StampNs step_ns() const { return step_ns_; }
    StampNs duration_ns() const { return static_cast<StampNs>(twists_.size()) * step_ns_; }
    const std::vector<Twist2>& twists() const { return twists_; }
    const Pose2& last() const { return poses_.back(); }

    /// Before the start and after the end the vehicle stands still.
    Pose2 planar_pose_at(StampNs time_ns) const {
        if (time_ns <= 0) return poses_.front();
        if (time_ns >= duration_ns()) return poses_.back();
        const auto step = static_cast<std::size_t>(time_ns / step_ns_);
        const double part = static_cast<double>(time_ns % step_ns_) / static_cast<double>(step_ns_);
        return poses_[step] * exp_se2(twists_[step] * part);
    }
    Pose3 pose_at(StampNs time_ns) const {
        const Pose2 planar = planar_pose_at(time_ns);
        return floor_.empty() ? Pose3(planar) : on_floor(planar, floor_at(time_ns));
    }

    /// From now on poses are those of a vehicle on this ground, whose frame is the map; the planar path
    /// stays.
    void put_on(const Ground& ground) {
        floor_.clear();
        for (const Pose2& pose : poses_) floor_.push_back(ground.below(pose));
    }
    /// Height, pitch and roll at the start of each step, and at the end of the last.
    void lift(std::vector<FloorAttitude> attitudes) { floor_ = std::move(attitudes); }

 private:
    FloorAttitude floor_at(StampNs time_ns) const {
        if (time_ns <= 0) return floor_.front();
        if (time_ns >= duration_ns()) return floor_.back();
        const auto step = static_cast<std::size_t>(time_ns / step_ns_);
        const double part = static_cast<double>(time_ns % step_ns_) / static_cast<double>(step_ns_);
        const FloorAttitude &a = floor_[step], &b = floor_[step + 1];
        return {a.z_m + part * (b.z_m - a.z_m), a.pitch_rad + part * (b.pitch_rad - a.pitch_rad),
                a.roll_rad + part * (b.roll_rad - a.roll_rad)};
    }

    std::vector<Pose2> poses_;          ///< at the start of each step, and at the end of the last
    std::vector<Twist2> twists_;        ///< of each step
    std::vector<FloorAttitude> floor_;  ///< as poses_; empty: a level floor
    StampNs step_ns_ = 1;
};

}  // namespace loopline::simulation
