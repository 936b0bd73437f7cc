#include "simulation/grabber/simulated_sensor.h"

#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/core/initializer.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "config/scenario.h"

using namespace loopline;

IMPLEMENTS_GENERIC_SENSOR(CSimulatedSensor, loopline)

MRPT_INITIALIZER(register_loopline_simulated_sensors) {
    CSimulatedSensor::doRegister();
}

namespace loopline {
namespace {

constexpr int most_at_once = 100;  // hosts keep queues of 200

double seconds_since_first_call() {
    using Clock = std::chrono::steady_clock;
    static const Clock::time_point first = Clock::now();
    return std::chrono::duration<double>(Clock::now() - first).count();
}

}  // namespace

void CSimulatedSensor::loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                                 const std::string& section) {
    const std::string scenario = config.read_string(section, "scenario", "", true);
    const std::string name = config.read_string(section, "sensor", "", true);
    speed_ = config.read_double(section, "speed", 1);
    if (!(speed_ > 0)) throw std::runtime_error("[" + section + "] speed must be above 0");
    load_scenario(scenario, split_words(config.read_string(section, "set", ""), " "), simulator_);
    std::string known;
    for (simulation::Sensor* sensor : simulator_.sensors_in_use()) {
        known += (known.empty() ? "" : ", ") + sensor->name();
        if (sensor->name() == name) sensor_ = sensor;
    }
    if (!sensor_)
        throw std::runtime_error("[" + section + "] sensor names \"" + name + "\", which is not one of " +
                                 scenario + ": " + known);
}

void CSimulatedSensor::initialize() {
    scene_ = simulation::make_scene(simulator_.scenario());
    sensor_->start(*scene_);
    m_state = ssWorking;
}

void CSimulatedSensor::doProcess() {
    const double now_s = std::min(seconds_since_first_call() * speed_, 1e9);
    const StampNs until_ns = std::min(scene_->duration_ns(), static_cast<StampNs>(now_s * 1e9));
    for (int made = 0; made < most_at_once && sensor_->next_time_ns() <= until_ns; ++made) {
        const auto observation = sensor_->next();
        if (m_sensorLabel != "UNNAMED_SENSOR") observation->sensorLabel = m_sensorLabel;
        appendObservation(observation);
    }
}

}  // namespace loopline
