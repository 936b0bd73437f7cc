/// Cars that move: towards the vehicle on the other lane, and ahead of it on its own.
#pragma once

#include <cstdint>
#include <vector>

#include "simulation/drive.h"
#include "simulation/town/car_shapes.h"
#include "simulation/town/town.h"

namespace loopline::simulation {

struct TrafficSettings {
    double oncoming_s = 15;  ///< from one that the vehicle meets to the next, about; 0: none
    double oncoming_mps = 9;
    double ahead = 0.25;  ///< part of the time that another car drives ahead
};

/// A body of a mesh of its own.
struct MovingBody {
    std::size_t mesh = 0;
    Pose3 T_map_body;
};

class Traffic {
 public:
    Traffic() = default;
    /// Cars keep off what stands in the town. `driven` is the way of the drive's motion.
    Traffic(const Street& driven, const Drive& drive, const Ground& ground, const Lots& lots,
            const TrafficSettings& settings, std::uint64_t seed);

    const std::vector<TriangleMesh>& meshes() const { return meshes_; }
    /// Those that are on their way at a time. `driven` and `ground` must still be there.
    std::vector<MovingBody> at(StampNs time_ns) const;

 private:
    struct Car {
        std::size_t mesh;
        StampNs from_ns, to_ns;
        bool oncoming;
        double way_m;  ///< oncoming: where it is at `meet_ns`; ahead: how far ahead of the vehicle
        StampNs meet_ns;
        double speed_mps;
    };
    double vehicle_way_m(StampNs time_ns) const;
    Pose2 place(const Car& car, StampNs time_ns) const;
    bool keeps_clear(const Car& car, const CarShape& shape, const Lots& lots) const;

    const Street* driven_ = nullptr;
    const Ground* ground_ = nullptr;
    StampNs step_ns_ = 1;
    std::vector<double> ways_m_;  ///< of the vehicle, step by step
    std::vector<TriangleMesh> meshes_;
    std::vector<Car> cars_;
};

}  // namespace loopline::simulation
