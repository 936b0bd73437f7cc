/// What a scenario's sections say, apart from its sensors: the world, the route and the vehicle.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "api/simulator.h"
#include "simulation/campus_plan.h"
#include "simulation/drive.h"
#include "simulation/floor_plan.h"
#include "simulation/office_plan.h"
#include "simulation/pushed_drive.h"
#include "simulation/sensor.h"
#include "simulation/town/recorded_path.h"

namespace loopline::simulation {

enum class Generator { none, office, campus, town };
enum class Driving { steered, pushed };

struct Scenario {
    std::uint64_t seed = 1;
    double start_utc_s = 1.3e9;
    double truth_hz = 0;  ///< poses of the true path besides those at scans
    std::vector<std::string> sensors{"wheels", "commands", "horizontal_laser"};
    Generator generator = Generator::none;
    std::uint64_t town_seed = 0;  ///< of the town and its hills, without its cars; 0: `seed`
    FloorPlan plan;
    OfficeSettings office;
    CampusSettings campus;
    TownSettings town;
    TerrainSettings terrain;
    TrafficSettings traffic;
    RecordedPathSettings path;
    double sigma_tilt_rad = 0;  ///< slope of the floor
    std::vector<Row> waypoints;
    int laps = 1;
    Driving driving = Driving::steered;
    PushSettings push;
    DriverSettings driver;
    VehicleSettings vehicle;
    DriveSettings drive;

    ParameterTable simulation_table();
    std::vector<ParameterTable> tables();  ///< of all sections
    std::vector<ScenarioProblem> check() const;
    Waypoints drawn_route() const;  ///< of `waypoints`

 private:
    bool has_waypoints() const {
        return generator == Generator::none || (generator == Generator::town && path.sequence.empty());
    }
    void check_plan(std::vector<ScenarioProblem>& problems) const;
    void check_route(std::vector<ScenarioProblem>& problems) const;
    void check_path(std::vector<ScenarioProblem>& problems) const;
};

/// Builds the world, drives the route, and puts both into the map frame. Throws std::runtime_error if the
/// vehicle does not arrive.
std::unique_ptr<Scene> make_scene(const Scenario& scenario);

}  // namespace loopline::simulation
