/// A small log with a loop: a cart goes twice around a block, 84 s with ten scans of 181 beams a second.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "support/run_program.h"

namespace loopline::test {

constexpr const char* ring_scenario = R"(
[simulation]
seed = 1
sensors = wheels horizontal_laser

[world]
height_m = 2.8
wall_m = -1 -1  13 -1  13 9  -1 9  -1 -1
wall_m = 1 1  11 1  11 7  1 7  1 1
box_m = 2.1 -0.9  0.6 0.4  0 2.8
box_m = 4.7 0.9  0.6 0.4  0 2.8
box_m = 8.2 -0.9  0.6 0.4  0 2.8
box_m = 12.8 2.3  0.4 0.6  0 2.8
box_m = 11.1 5.2  0.4 0.6  0 2.8
box_m = 9.4 8.9  0.6 0.4  0 2.8
box_m = 6.3 7.1  0.6 0.4  0 2.8
box_m = 2.9 8.9  0.6 0.4  0 2.8
box_m = -0.8 6.4  0.4 0.6  0 2.8
box_m = 0.9 3.1  0.4 0.6  0 2.8

[route]
drive = pushed
waypoint_m = 0 0
waypoint_m = 12 0
waypoint_m = 12 8
waypoint_m = 0 8
waypoint_m = 0 0
waypoint_m = 12 0
waypoint_m = 12 8
waypoint_m = 0 8
waypoint_m = 0 0

[cart]
speed_mps = 1
standstill_s = 1

[vehicle]
track_width_m = 0.5
slip_straight = 0.003
sigma_straight_m = 0.003

[wheels]
rate_hz = 20
metres_per_tick_m = 0.001
sigma_scale = 0.001
track_scale = 1.03

[horizontal_laser]
beams = 181
field_of_view_deg = 270
rate_hz = 10
max_range_m = 8
sigma_range_m = 0.01
resolution_m = 0.001
x_m = 0.2
z_m = 0.45
)";

/// Simulated, with overrides of the scenario.
inline std::string simulated_ring(const TemporaryFolder& folder, const std::vector<std::string>& sets) {
    const std::string rawlog = (folder / "ring.rawlog").string();
    std::vector<std::string> words{"simulate", folder.write("ring.ini", ring_scenario), "--out", rawlog,
                                   "--quiet"};
    for (const std::string& set : sets) {
        words.emplace_back("--set");
        words.push_back(set);
    }
    const auto said = run_loopline(words);
    EXPECT_EQ(said.exit_code, 0) << said.err;
    return rawlog;
}

/// Simulated once for all tests of a program.
inline const std::string& ring_log() {
    static const TemporaryFolder folder;
    static const std::string log = simulated_ring(folder, {});
    return log;
}

/// The same with an IMU, which finds its attitude in five seconds at rest: 88 s.
inline const std::string& ring_log_with_imu() {
    static const TemporaryFolder folder;
    static const std::string log = simulated_ring(
        folder, {"simulation.sensors=wheels imu horizontal_laser", "cart.standstill_s=5", "imu.rate_hz=100"});
    return log;
}

}  // namespace loopline::test
