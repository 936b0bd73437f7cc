/// What later fixes say of earlier poses: Rauch, Tung and Striebel's smoother, on what the filter went
/// through.
#pragma once

#include <array>
#include <vector>

#include "api/pose3_record.h"
#include "fusion/earth_filter.h"

namespace loopline::fusion {

/// One step of the filter as it lies on disk: where it was, by all fixes up to then, and where that led.
struct SmootherStep {
    std::uint64_t pose = 0;  ///< number of the pose that it starts from
    Pose3Record before, after;
    std::array<double, 3> fix_error_before{}, fix_error_after{};
    std::array<double, 81> covariance_before{}, covariance_after{}, F{};

    SmootherStep() = default;
    SmootherStep(std::size_t pose, const EarthState& before, const EarthState& after, const Matrix9d& F);
    EarthState state_before() const;
    EarthState state_after() const;
};

struct SmoothedPose {
    Pose3 T_enu_base;
    Matrix6d covariance = Matrix6d::Zero();  ///< of (shift, turn) along ENU, about the vehicle
};

/// One step back: the state before it, given all that was said of the one after it.
EarthState smoothed_before(const SmootherStep& step, const EarthState& smoothed_after);

}  // namespace loopline::fusion
