/// A simulated sensor: parameters of its own .ini section, and observations at its own times.
#pragma once

#include <mrpt/obs/CObservation.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "api/parameters.h"
#include "api/simulator.h"
#include "simulation/drive.h"
#include "simulation/ray_caster.h"
#include "simulation/town/landscape.h"
#include "simulation/walkers.h"

namespace loopline::simulation {

/// What a sensor is on and in: all of it in the map frame, which is the first pose of the vehicle.
struct Scene {
    World world;
    std::vector<Walker> walkers;
    Drive drive;
    VehicleSettings vehicle;
    StampNs start_ns = 0;  ///< UTC
    std::uint64_t seed = 0;
    std::unique_ptr<RayCaster> caster;     ///< of the world's walls
    std::unique_ptr<Landscape> landscape;  ///< null: there are only the world's walls, on level ground

    StampNs duration_ns() const { return drive.motion.duration_ns(); }
    std::vector<Cylinder> cylinders_at(StampNs time_ns) const {
        return walkers_at(walkers, time_ns, drive.motion.planar_pose_at(time_ns).translation());
    }
};

class Sensor {
 public:
    virtual ~Sensor() = default;
    /// The section, and the label of the observations.
    virtual std::string name() const = 0;
    virtual ParameterTable parameters() = 0;
    /// What is wrong with the values together, as a clause; empty if nothing is.
    virtual std::string check() const { return {}; }
    /// Whether the true path has a pose for each of its observations.
    virtual bool is_scanner() const { return false; }
    /// Whether what it sees is the scene's world of walls, whatever else there is.
    virtual bool sees_walls_only() const { return false; }
    /// Whether an observation takes so long to make that each is worth a word of progress.
    virtual bool is_slow() const { return false; }

    /// `scene` outlives the sensor's work.
    virtual void start(const Scene& scene) = 0;
    /// Time of the next observation since the start of the drive, in whole 100 ns, which is what a rawlog
    /// keeps.
    virtual StampNs next_time_ns() const = 0;
    /// Makes it. None that starts after the end of the drive is asked for.
    virtual mrpt::obs::CObservation::Ptr next() = 0;
    /// What was true of the sensor itself, after the last observation.
    virtual std::vector<TruthRow> truth() const { return {}; }
    /// What it did, as one sentence.
    virtual std::string summary() const { return {}; }
};

/// Of sample `index` of a sensor.
inline StampNs sample_time_ns(std::int64_t index, double rate_hz) {
    return static_cast<StampNs>(std::llround(static_cast<double>(index) / rate_hz * 1e7)) * 100;
}

/// Every sensor there is, fresh, in the order in which observations of one time stand in the log.
std::vector<std::shared_ptr<Sensor>> all_sensors();

}  // namespace loopline::simulation
