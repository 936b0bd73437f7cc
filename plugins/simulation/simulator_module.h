/// Simulator "simulation": drives a vehicle through a world, and merges what its sensors see by stamp.
#pragma once

#include <memory>

#include "api/simulator.h"
#include "simulation/scenario.h"

namespace loopline {

class WorldSimulator : public Simulator {
    DEFINE_MRPT_OBJECT(WorldSimulator, loopline)
 public:
    WorldSimulator();
    ModuleInfo info() const override;
    ParameterTable parameters() override;
    std::vector<ParameterTable> sections() override;
    std::vector<ScenarioProblem> check_scenario() override;
    void simulate(SimulationSink& sink) override;

    /// The sensors that the scenario names, in the order of all_sensors(); for hosts that run each by itself.
    std::vector<simulation::Sensor*> sensors_in_use();
    const simulation::Scenario& scenario() const { return scenario_; }

 private:
    simulation::Scenario scenario_;
    std::vector<std::shared_ptr<simulation::Sensor>> sensors_;
};

}  // namespace loopline
