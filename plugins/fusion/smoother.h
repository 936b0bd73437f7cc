/// What later fixes say of earlier poses: Rauch, Tung and Striebel's smoother, on what the filter went
/// through.
#pragma once

#include <array>
#include <vector>

#include "api/pose3_record.h"
#include "fusion/earth_filter.h"

namespace loopline::fusion {

/// A state as it lies on disk.
struct EarthStateRecord {
    Pose3Record T_enu_base;
    std::array<double, 3> fix_error_m{}, wheel_errors{};
    std::array<double, state_errors*(state_errors + 1) / 2>
        covariance{};  ///< upper triangle, column by column

    EarthStateRecord() = default;
    explicit EarthStateRecord(const EarthState& state);
    EarthState state() const;
};

/// One step of the filter: where it was, by all fixes up to then, and where that led.
struct SmootherStep {
    std::uint64_t pose = 0;  ///< number of the pose that it starts from
    EarthStateRecord before, after;
    std::array<double, state_errors * state_errors> before_and_after{};

    SmootherStep() = default;
    SmootherStep(std::size_t from_pose, const EarthState& before, const Carried& carried);
};

/// One step back: the state before it, given all that was said of the one after it.
EarthState smoothed_before(const SmootherStep& step, const EarthState& smoothed_after);

}  // namespace loopline::fusion
