/// Relative pose error (RPE): how wrong is the motion over a given step? Sturm et al. 2012, eq. (2)-(3):
/// E_i = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j) with the estimate P and the reference Q.
#pragma once

#include <vector>

#include "evaluate/association.h"
#include "evaluate/statistics.h"

namespace loopline {

/// What separates the two poses of a step: j is the first pose after i that is at least so far away.
struct RelativeStep {
    enum class Unit { poses, seconds, metres } unit = Unit::poses;  ///< metres: along the reference path
    double length = 1;
};

struct RelativeError {
    std::vector<double> translations_m, rotations_deg;  ///< one a step; every pose starts one
    Statistics translation_m, rotation_deg;
};

/// Pairs in the order of the estimate's file. With a step in seconds, stamps that go backwards begin no step.
RelativeError relative_error(const std::vector<PosePair>& pairs, const RelativeStep& step);

/// Angle of a rotation, 0 .. pi; well conditioned also near 0, where acos of the trace is not.
double rotation_angle_rad(const Eigen::Quaterniond& rotation);

/// Way along the reference up to each pair, in metres; the first is 0.
std::vector<double> reference_way_m(const std::vector<PosePair>& pairs);

}  // namespace loopline
