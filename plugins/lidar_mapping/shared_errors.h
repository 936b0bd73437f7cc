/// Errors that neighbouring points of a sweep share: of a map whose planes cut off what is curved, of
/// somebody who moves. Points that err together say less than as many that err each by itself.
#pragma once

#include <vector>

#include "lidar_mapping/motion_state.h"

namespace loopline::lidar_mapping {

class SharedErrors {
 public:
    /// What a point at `arm_m` from the vehicle adds to the gradient by all that undistorts a sweep.
    void add(const Eigen::Vector3d& arm_m, const SweepVector& gradient);
    /// The gradient's covariance: `alone`, if each point errs by itself, and more in directions in which
    /// neighbours pull together (clusters of Liang and Zeger 1986, "Longitudinal data analysis using
    /// generalized linear models").
    SweepMatrix covariance(const SweepMatrix& alone) const;

 private:
    static constexpr std::size_t sectors = 24, rings = 4;
    std::vector<SweepVector> clusters_ = std::vector<SweepVector>(sectors * rings, SweepVector::Zero());
};

}  // namespace loopline::lidar_mapping
