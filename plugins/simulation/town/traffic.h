/// Cars that move: towards the vehicle on the other lane, ahead of it on its own, and those that stood on
/// either until it came.
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
    double ahead = 0.25;         ///< part of the time that another car drives ahead
    double standing_per_km = 0;  ///< stand from the beginning, and leave when the vehicle is there
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
    enum class Kind {
        oncoming,
        ahead,   ///< of the vehicle, by a gap that changes slowly
        leaving  ///< stands until `meet_ns`
    };
    struct Car {
        std::size_t mesh;
        StampNs from_ns, to_ns;
        Kind kind;
        bool other_lane;
        double way_m;  ///< where it is at `meet_ns`; ahead: how far ahead of the vehicle
        StampNs meet_ns;
        double speed_mps;
    };
    void add_moving(const TrafficSettings& settings, const Lots& lots, StampNs end_ns, std::uint64_t seed);
    void add_standing(const TrafficSettings& settings, const Lots& lots, std::uint64_t seed);
    void add_if_clear(Car car, const CarShape& shape, const Lots& lots);
    double vehicle_way_m(StampNs time_ns) const;
    StampNs vehicle_is_at_ns(double way_m) const;
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
