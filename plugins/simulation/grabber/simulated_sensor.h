/// Driver "CSimulatedSensor": one sensor of a scenario as a device of MRPT, for rawlog-grabber and every
/// other host of CGenericSensor.
#pragma once

#include <mrpt/hwdrivers/CGenericSensor.h>

#include <memory>
#include <string>

#include "simulation/simulator_module.h"

namespace loopline {

/// Keys of its section: `scenario` (an .ini of datasets/), `sensor` (horizontal_laser, wheels, ...), `set`
/// (overrides, "section.key=value", separated by blanks) and `speed` (simulated seconds a second; 1 if it is
/// not given). Sensors of one scenario and seed fit together: each drives the same path. All start at the
/// same moment, with the first that is asked for something. After the end of the drive no more observations
/// come.
class CSimulatedSensor : public mrpt::hwdrivers::CGenericSensor {
    DEFINE_GENERIC_SENSOR(CSimulatedSensor)
 public:
    void initialize() override;
    void doProcess() override;

 protected:
    void loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                   const std::string& section) override;

 private:
    double speed_ = 1;
    WorldSimulator simulator_;
    simulation::Sensor* sensor_ = nullptr;
    std::unique_ptr<simulation::Scene> scene_;
};

}  // namespace loopline
