#include "simulation/simulator_module.h"

#include <algorithm>

#include "simulation/gnss_sensor.h"
#include "simulation/imu_sensor.h"
#include "simulation/laser_sensors.h"
#include "simulation/spinning_lidar_sensor.h"
#include "simulation/wheel_sensors.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(WorldSimulator, Simulator, loopline)

using namespace simulation;

namespace simulation {

std::vector<std::shared_ptr<Sensor>> all_sensors() {
    std::vector<std::shared_ptr<Sensor>> sensors;
    sensors.push_back(std::make_shared<CommandSensor>());
    sensors.push_back(std::make_shared<WheelSensor>());
    sensors.push_back(std::make_shared<ImuSensor>());
    sensors.push_back(std::make_shared<HorizontalLaser>());
    sensors.push_back(std::make_shared<SurveyLaser>());
    sensors.push_back(std::make_shared<SpinningLidarSensor>());
    sensors.push_back(std::make_shared<GnssSensor>());
    return sensors;
}

}  // namespace simulation

namespace {

void write_world(const World& world, SimulationSink& sink) {
    for (const FeaturePoint& point : world.points)
        sink.truth({"point", point.number, {point.position_m.x(), point.position_m.y()}});
    int number = 0;
    for (const Wall& wall : world.walls)
        sink.truth(
            {"wall",
             ++number,
             {wall.from_m.x(), wall.from_m.y(), wall.to_m.x(), wall.to_m.y(), wall.bottom_m, wall.top_m}});
    sink.truth({"level", 1, {world.ground_m}});
    if (std::isfinite(world.ceiling_m)) sink.truth({"level", 2, {world.ceiling_m}});
}

/// Writes poses at scans (at all that is sensed, if nothing scans), and between them at a rate of its own, in
/// the order of time.
class TruePath {
 public:
    TruePath(const Scene& scene, double rate_hz, SimulationSink& sink)
        : scene_(scene), rate_hz_(rate_hz), sink_(sink) {}

    void write_at(StampNs time_ns) {
        if (time_ns == last_ns_) return;
        sink_.true_pose(scene_.start_ns + time_ns, scene_.drive.motion.pose_at(time_ns));
        last_ns_ = time_ns;
    }
    void write_until(StampNs end_ns) {
        for (; rate_hz_ > 0 && sample_time_ns(index_, rate_hz_) < end_ns; ++index_)
            write_at(std::max(sample_time_ns(index_, rate_hz_), last_ns_));
    }

 private:
    const Scene& scene_;
    double rate_hz_;
    SimulationSink& sink_;
    std::int64_t index_ = 0;  ///< of the next pose between scans
    StampNs last_ns_ = -1;
};

}  // namespace

WorldSimulator::WorldSimulator() : sensors_(all_sensors()) {}

ModuleInfo WorldSimulator::info() const {
    return {"simulation",
            "Makes a log and its truth from a scenario.",
            {},
            {},
            {"CObservationOdometry", "CObservationComment", "CObservationIMU", "CObservation2DRangeScan",
             "CObservationRotatingScan", "CObservationGPS"}};
}

ParameterTable WorldSimulator::parameters() {
    return scenario_.simulation_table();
}

std::vector<ParameterTable> WorldSimulator::sections() {
    auto tables = scenario_.tables();
    for (const auto& sensor : sensors_) tables.push_back(sensor->parameters());
    return tables;
}

std::vector<ScenarioProblem> WorldSimulator::check_scenario() {
    auto problems = scenario_.check();
    std::vector<std::string> known;
    for (const auto& sensor : sensors_) {
        known.push_back(sensor->name());
        if (const auto sentence = sensor->check(); !sentence.empty())
            problems.push_back({sensor->name(), "", 0, sentence});
    }
    std::string listed;
    for (const auto& name : known) listed += (listed.empty() ? "" : ", ") + name;
    for (const auto& name : scenario_.sensors)
        if (std::find(known.begin(), known.end(), name) == known.end())
            problems.push_back(
                {"simulation", "sensors", 0, "names \"" + name + "\", which is none; there are " + listed});
    for (const auto& sensor : sensors_in_use())
        if (scenario_.generator == Generator::town && sensor->sees_walls_only())
            problems.push_back({"simulation", "sensors", 0,
                                "names " + sensor->name() + ", which sees walls and nothing of a town"});
    if (scenario_.sensors.empty())
        problems.push_back({"simulation", "sensors", 0, "names none; there are " + listed});
    return problems;
}

std::vector<Sensor*> WorldSimulator::sensors_in_use() {
    std::vector<Sensor*> used;
    const auto& names = scenario_.sensors;
    for (const auto& sensor : sensors_)
        if (std::find(names.begin(), names.end(), sensor->name()) != names.end())
            used.push_back(sensor.get());
    return used;
}

void WorldSimulator::simulate(SimulationSink& sink) {
    const auto scene = make_scene(scenario_);
    if (!scene->landscape) write_world(scene->world, sink);
    const auto sensors = sensors_in_use();
    for (Sensor* sensor : sensors) sensor->start(*scene);
    const double total_s = seconds_between(0, scene->duration_ns());
    TruePath path(*scene, scenario_.truth_hz, sink);
    const bool scans = std::any_of(sensors.begin(), sensors.end(),
                                   [](const Sensor* sensor) { return sensor->is_scanner(); });
    for (std::uint64_t made = 0;; ++made) {
        Sensor* const next = *std::min_element(
            sensors.begin(), sensors.end(),
            [](const Sensor* a, const Sensor* b) { return a->next_time_ns() < b->next_time_ns(); });
        const StampNs time_ns = next->next_time_ns();
        if (time_ns > scene->duration_ns()) break;
        path.write_until(time_ns);
        if (next->is_scanner() || !scans) path.write_at(time_ns);
        sink.observation(*next->next());
        if (made % 1000 == 0 || next->is_slow()) sink.progress(seconds_between(0, time_ns), total_s);
    }
    sink.note("The drive takes " + number_text(std::round(total_s * 10) / 10) + " s.");
    for (const Sensor* sensor : sensors)
        for (const TruthRow& row : sensor->truth()) sink.truth(row);
    for (Sensor* sensor : sensors)
        if (const auto sentence = sensor->summary(); !sentence.empty()) sink.note(sentence);
}

}  // namespace loopline
