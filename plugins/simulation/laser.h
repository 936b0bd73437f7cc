/// A laser that measures beam after beam in a plane: true motion during the sweep, noise, quantisation, beams
/// without return, and ranges between two surfaces where a beam meets an edge.
#pragma once

#include <functional>
#include <vector>

#include "api/pose3.h"
#include "api/stamp.h"
#include "simulation/random_stream.h"
#include "simulation/ray_caster.h"

namespace loopline::simulation {

struct LaserSettings {
    int beams = 181;
    double field_of_view_rad = M_PI;  ///< from the first beam to the last, around the x axis
    double rate_hz = 37;
    double sweep_part =
        0.5;  ///< of the time from scan to scan that the beams take: the mirror looks back for the rest
    double min_range_m = 0.05;
    double max_range_m = 32;
    double sigma_range_m = 0.01;
    double resolution_m = 0.01;  ///< ranges are multiples of it; 0: no steps
    double dropouts = 0.01;      ///< part of the beams without return
    double beam_width_rad = 0.5 * M_PI / 180;
    double mixed_pixels = 0.3;  ///< part of the beams on an edge that see neither surface
    double mixed_gap_m = 2;     ///< a wider gap is told apart by the receiver: the nearer surface counts
};

struct Beam {
    double range_m = 0;
    bool valid = false;  ///< false: no return; `range_m` is then the maximum, or 0 for a dropout
};

/// Pose of the sensor at a time, in the frame of the ray caster's world.
using PoseAt = std::function<Pose3(StampNs time_ns)>;
/// What moves, where it is at a time; empty: nothing does.
using CylindersAt = std::function<std::vector<Cylinder>(StampNs time_ns)>;

class Laser {
 public:
    Laser(const LaserSettings& settings, RandomStream random) : settings_(settings), random_(random) {}

    /// Counter-clockwise, from the right. Beam 0 is measured at `start_ns`, beam k at beam_time_ns(k) after
    /// it.
    const std::vector<Beam>& scan(StampNs start_ns, const PoseAt& T_world_sensor, const RayCaster& world,
                                  const CylindersAt& cylinders_at = {});
    StampNs beam_time_ns(int beam) const;
    double angle_rad(int beam) const;

 private:
    void aim(int beam, StampNs start_ns, const PoseAt& T_world_sensor, const CylindersAt& cylinders_at);
    Hit cast(double angle_rad, const RayCaster& world) const;
    double range_at_edge_m(int beam, const RayCaster& world);
    bool meets_edge(int beam) const;
    Beam measured(double true_range_m);

    LaserSettings settings_;
    RandomStream random_;
    Pose3 T_world_sensor_;  ///< at the beam that is aimed
    std::vector<Cylinder> cylinders_;
    std::vector<Hit> hits_;  ///< of the middle of each beam
    std::vector<Beam> beams_;
};

}  // namespace loopline::simulation
