/// Strapdown mechanisation: pose and velocity from angular rates and specific forces, forward in time and
/// back again.
///
/// The frame is local and level, z up, and taken as inertial. The earth turns by 7.3e-5 rad/s, a hundredth of
/// the bias that a MEMS gyro shows from one start to the next, so it is estimated as a part of that bias; the
/// transport rate of a vehicle at walking speed is smaller by three more orders.
#pragma once

#include "inertial/imu_sample.h"
#include "inertial/navigation_state.h"

namespace loopline::inertial {

struct Mechanisation {
    double gravity_mps2 = 9.80665;  ///< at the place of the survey, along -z of the map

    /// The state at `to`, from that at `from`. Rates and forces are the means of both readings, less the
    /// biases, and the velocity increment is turned by half of the rotation: second order in the step.
    NavigationState forward(const NavigationState& state, const ImuSample& from, const ImuSample& to) const;

    /// The state at `from`, from that at `to`: the inverse map of forward() with the same two readings, up to
    /// rounding.
    NavigationState reverse(const NavigationState& state, const ImuSample& from, const ImuSample& to) const;
};

/// What the two readings at the ends of a step say of the time between them.
struct ImuStep {
    double duration_s;
    Eigen::Vector3d turn_rad;                  ///< rotation in the step, base axes, bias taken off
    Eigen::Vector3d specific_force_base_mps2;  ///< mean, bias taken off
};
ImuStep step_between(const NavigationState& biases, const ImuSample& from, const ImuSample& to);

}  // namespace loopline::inertial
