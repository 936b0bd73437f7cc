/// A small log of a car with a spinning lidar: along a street and round a bend, 10 s.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "support/run_program.h"

namespace loopline::test {

constexpr const char* street_scenario =
    "[simulation]\nseed = 3\nsensors = spinning_lidar\n[world]\ngenerator = town\n[route]\n"
    "drive = pushed\nwaypoint_m = 0 0\nwaypoint_m = 40 0\nwaypoint_m = 60 20\n[cart]\n"
    "speed_mps = 8\nspeed_up_s = 3\ncorner_radius_m = 12\nstandstill_s = 1\nend_standstill_s = 1\n"
    "[terrain]\nsigma_slope_deg = 2\n[spinning_lidar]\nbeams = 32\ncolumns = 900\n";

/// Simulated once a process; the truth is beside it.
inline std::string street_log() {
    static const TemporaryFolder folder;
    static const std::string log = [] {
        const std::string scenario = (folder / "street.ini").string(),
                          out = (folder / "street.rawlog").string();
        std::ofstream(scenario) << street_scenario;
        EXPECT_EQ(run_loopline({"simulate", scenario, "--out", out}).exit_code, 0);
        return out;
    }();
    return log;
}

/// Some seconds of a small lidar and wheels, whose readings fall between sweeps, and of more sensors.
inline std::string short_street_log(const std::string& more_sensors = "") {
    static const TemporaryFolder folder;
    const std::string name = "short" + more_sensors, scenario = (folder / (name + ".ini")).string(),
                      out = (folder / (name + ".rawlog")).string();
    if (std::filesystem::exists(out)) return out;
    std::ofstream(scenario) << "[simulation]\nseed = 3\nsensors = wheels spinning_lidar " + more_sensors +
                                   "\n[world]\ngenerator = town\n[route]\ndrive = pushed\nwaypoint_m = 0 0\n"
                                   "waypoint_m = 12 0\n[cart]\nspeed_mps = 5\nspeed_up_s = 2\n"
                                   "standstill_s = 1\nend_standstill_s = 1\n[spinning_lidar]\n"
                                   "beams = 32\ncolumns = 600\n[wheels]\nrate_hz = 15\n";
    EXPECT_EQ(run_loopline({"simulate", scenario, "--out", out}).exit_code, 0);
    return out;
}

/// A street and a bend with a receiver and wheels, far enough to know the heading on the Earth.
inline std::string placed_street_log() {
    static const TemporaryFolder folder;
    static const std::string log = [] {
        const std::string scenario = folder.write(
            "placed.ini",
            "[simulation]\nseed = 3\nsensors = spinning_lidar gnss wheels\n[world]\ngenerator = "
            "town\n[route]\n"
            "drive = pushed\nwaypoint_m = 0 0\nwaypoint_m = 30 0\nwaypoint_m = 42 12\n[cart]\nspeed_mps = 8\n"
            "speed_up_s = 2\ncorner_radius_m = 8\nstandstill_s = 1\nend_standstill_s = 1\n[spinning_lidar]\n"
            "beams = 32\ncolumns = 450\n[wheels]\nrate_hz = 15\n");
        const std::string out = (folder / "placed.rawlog").string();
        EXPECT_EQ(run_loopline({"simulate", scenario, "--out", out}).exit_code, 0);
        return out;
    }();
    return log;
}

}  // namespace loopline::test
