/// What a vehicle drives on: heights over the plan, and how a vehicle stands on them.
#pragma once

#include <Eigen/Core>

#include "api/pose2.h"
#include "api/pose3.h"

namespace loopline::simulation {

/// What the ground adds to a planar pose: MRPT's angles, so pitch is positive where the nose is down.
struct FloorAttitude {
    double z_m = 0;
    double pitch_rad = 0;
    double roll_rad = 0;
};

/// The planar pose on the ground: Rz(phi) Ry(pitch) Rx(roll).
Pose3 on_floor(const Pose2& planar, const FloorAttitude& floor);

/// A height for every place, the same whenever a vehicle comes there.
class Ground {
 public:
    virtual ~Ground() = default;
    virtual double height_m(const Eigen::Vector2d& place_m) const = 0;
    /// Its derivative along x and y.
    virtual Eigen::Vector2d slope(const Eigen::Vector2d& place_m) const = 0;

    /// Of a vehicle that stands tangent to the ground.
    FloorAttitude below(const Pose2& T_ground_base) const;
};

}  // namespace loopline::simulation
