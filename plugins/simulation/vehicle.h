/// A vehicle with two driven wheels that knows three ways to drive, straight, left and right, each with its
/// own wheel speeds and its own slip (Hu 2012, sections 2.1, 2.2 and 3.1).
#pragma once

#include "api/twist2.h"
#include "simulation/random_stream.h"

namespace loopline::simulation {

enum class Regime { straight, left, right };

struct WheelPair {
    double left = 0;
    double right = 0;
};

struct VehicleSettings {
    double track_width_m = 0.4;
    double straight_mps = 0.1023;  ///< of both wheels
    double turn_outer_mps = 0.0634;
    double turn_inner_mps = 0.0106;
    double wheel_lag_s = 0.1;  ///< time constant with which a wheel follows its command

    /// The motors: how far wheel speeds wander from what was commanded, as a part of it; encoders see that.
    double wander = 0.005;
    double wander_s = 5;  ///< for how long they do

    /// The ground: the part of the rim's way that a wheel loses; encoders don't see that.
    double slip_straight = 0;
    double slip_turn_outer = 0.01;
    double slip_turn_inner = 0.47;
    double sigma_slip_turn = 0.03;    ///< of the inner wheel's slip from one turn to the next
    double sigma_straight_m = 0.001;  ///< random way of a wheel after 1 m, driving straight
    double sigma_turn_m = 0.005;      ///< and in turns
    double sigma_side_m = 0.002;      ///< random way to the side after 1 m
    double bumps_hz = 0.02;           ///< how often something on the ground turns the vehicle
    double sigma_bump_rad = 0.1 * M_PI / 180;
};

/// What happened within a step.
struct VehicleStep {
    WheelPair rim_m;  ///< way of the wheels' rims: what encoders count
    Twist2 motion;    ///< way of the vehicle over ground
};

/// Draws its disturbances step by step.
class Vehicle {
 public:
    Vehicle(const VehicleSettings& settings, double step_s, RandomStream random)
        : settings_(settings), step_s_(step_s), random_(random) {}

    VehicleStep step(Regime commanded);

    /// Commanded wheel speeds in m/s.
    static WheelPair commanded_mps(const VehicleSettings& settings, Regime regime);

 private:
    void enter(Regime regime);
    double rim_way_m(double commanded_mps, double& speed_mps, double& wander);

    VehicleSettings settings_;
    double step_s_;
    RandomStream random_;
    Regime regime_ = Regime::straight;
    WheelPair speed_mps_, wander_, slip_;
    double sigma_wheel_m_ = 0;
    bool moving_ = false;
};

}  // namespace loopline::simulation
