/// A spinning lidar's path and local map, sweep after sweep.
#pragma once

#include <vector>

#include "lidar_mapping/registration.h"

namespace loopline::lidar_mapping {

struct SweepMappingSettings {
    SamplingSettings sampling;
    double map_voxel_m = 0.25;  ///< of the returns that go to the map
    double match_voxel_m = 1;   ///< of those that are matched
    double forget_every_m = 10;
    MotionNoise motion;
    SurfaceMapSettings map;
    RegistrationSettings registration;
};

class SweepMapping {
 public:
    explicit SweepMapping(const SweepMappingSettings& settings)
        : settings_(settings), map_(settings.map) {}

    const Registration& add(const lidar::SpinningScan& scan);
    const SurfaceMap& map() const { return map_; }
    const std::vector<SweepPoint>& matched() const { return matched_; }

 private:
    void add_to_map();

    SweepMappingSettings settings_;
    ScanSampler sampler_;
    SurfaceMap map_;
    std::vector<SweepPoint> points_, matched_;
    std::vector<Eigen::Vector3d> points_map_m_;
    Registration last_;
    bool any_ = false;
    StampNs last_ns_ = 0;
    Eigen::Vector3d forgot_at_m_ = Eigen::Vector3d::Zero();
};

}  // namespace loopline::lidar_mapping
