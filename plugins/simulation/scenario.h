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
#include "simulation/sensor.h"

namespace loopline::simulation {

enum class Generator { none, office, campus };

struct Scenario {
    std::uint64_t seed = 1;
    double start_utc_s = 1.3e9;
    std::vector<std::string> sensors{"wheels", "commands", "horizontal_laser"};
    Generator generator = Generator::none;
    FloorPlan plan;
    OfficeSettings office;
    CampusSettings campus;
    std::vector<Row> waypoints;
    DriverSettings driver;
    VehicleSettings vehicle;
    DriveSettings drive;

    ParameterTable simulation_table();
    std::vector<ParameterTable> tables();  ///< of all sections
    std::vector<ScenarioProblem> check() const;
};

/// Builds the world, drives the route, and puts both into the map frame. Throws std::runtime_error if the
/// vehicle does not arrive.
std::unique_ptr<Scene> make_scene(const Scenario& scenario);

}  // namespace loopline::simulation
