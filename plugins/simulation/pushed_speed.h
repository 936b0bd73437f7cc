/// How fast a cart is pushed along its path: from standstill to standstill, slower in bends, with stops.
#pragma once

#include <vector>

#include "simulation/cart_path.h"
#include "simulation/random_stream.h"

namespace loopline::simulation {

struct PushSettings {
    double corner_radius_m = 1;  ///< of a bend, where it is tightest
    double speed_mps = 1;
    double sigma_speed = 0.08;  ///< how far the speed strays from that along the way, as a part of it
    double speed_up_s = 2;      ///< from standstill to `speed_mps`, and back
    double turn_radps = 45 * M_PI / 180;  ///< bends are taken so slowly that the cart turns no faster
    double standstill_s = 10;             ///< before the cart sets off
    double end_standstill_s = 3;
    double stop_every_m = 0;  ///< way from stop to stop, about; 0: none
    double stop_s = 4;
    double slip_turn = 0;        ///< of the inner wheel in a bend, by the acceleration to its side in m/s^2
    double sigma_side_m = 0.03;  ///< how far hands let the cart stray beside its path
};

/// The way along the path that is gone within each step of `step_s`, of the whole drive with its standstills.
/// Speed, acceleration and jerk have no jumps.
std::vector<double> pushed_ways_m(const CartPath& path, const PushSettings& settings, double step_s,
                                  RandomStream random);

}  // namespace loopline::simulation
