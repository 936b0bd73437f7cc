/// A floor that is not quite level: a random field of heights, the same wherever a vehicle comes back to.
#pragma once

#include <cstdint>
#include <vector>

#include "api/pose2.h"
#include "api/pose3.h"

namespace loopline::simulation {

/// What the floor adds to a planar pose: MRPT's angles, so pitch is positive where the nose is down.
struct FloorAttitude {
    double z_m = 0;
    double pitch_rad = 0;
    double roll_rad = 0;
};

/// The planar pose on the floor: Rz(phi) Ry(pitch) Rx(roll).
Pose3 on_floor(const Pose2& planar, const FloorAttitude& floor);

/// h(p) = sum of a_k (sin(k . p + phase) - sin(phase)): height 0 at the origin of its frame.
class UnevenFloor {
 public:
    /// `sigma_tilt_rad`: standard deviation of the slope in any one direction.
    UnevenFloor(double sigma_tilt_rad, std::uint64_t seed);

    double height_m(const Eigen::Vector2d& place_m) const;
    /// Of a vehicle that stands tangent to the floor.
    FloorAttitude below(const Pose2& T_floor_base) const;

 private:
    struct Wave {
        Eigen::Vector2d k_per_m;
        double amplitude_m, phase_rad, sine_of_phase;
    };
    std::vector<Wave> waves_;
};

}  // namespace loopline::simulation
