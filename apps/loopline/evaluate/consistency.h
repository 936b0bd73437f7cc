/// Are the covariances right? The normalised estimation error squared (NEES) of position and heading.
/// Bar-Shalom, Li, Kirubarajan 2001, "Estimation with Applications to Tracking and Navigation", section 5.4.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "api/pose2.h"

namespace loopline {

/// e^T P^-1 e of e = (x, y, heading) in m and rad, map frame; 3 on average if P is right. None if P is not
/// positive definite (the first pose of a run, which is known by definition).
std::optional<double> pose_nees(const Pose2& T_map_base_estimate, const Pose2& T_map_base_truth,
                                const Eigen::Matrix3d& covariance);

/// Both ends of the interval that the mean of `runs` independent NEES values of `dimension` lies in with a
/// probability of 95 %, by Wilson and Hilferty's approximation of the chi-square quantile (within 1 % from 5
/// degrees of freedom on).
struct Band {
    double low, high;
};
Band nees_band_95(int dimension, int runs);

}  // namespace loopline
