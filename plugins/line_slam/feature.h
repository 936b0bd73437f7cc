/// How the filter writes a wall that it sees: as a line, or as the paper's foot point.
///
/// Hu, Chen, Zhang 2012, eq. (11), takes the foot point of the perpendicular from the world's origin, as if
/// it were a landmark seen by range and bearing. Where that point is "measured" depends on the predicted
/// pose, since no beam tells where the origin is: an error of the pose moves measurement and prediction
/// alike, and the filter takes their agreement for information. It is kept for comparison. With the line
/// itself (line_observation.h) nothing but the scan enters the measurement.
#pragma once

#include "line_slam/line_observation.h"

namespace loopline::line_slam {

enum class Feature { line, foot_point };

/// A pairing in the space of the measurement: (rho, alpha), or (range, bearing) of the foot point.
struct FeaturePrediction {
    Eigen::Vector2d innovation;  ///< measured minus predicted
    ObservationJacobians H;      ///< to the invariant pose error and to the map line's (rho, alpha)
    Eigen::Matrix2d noise;       ///< R, of the measurement
};

/// `covariance`: of the observation's (rho, alpha), as it shall count. A foot point that coincides with the
/// vehicle has no bearing: its noise is then infinite. `first_normal` as in observation_jacobians().
FeaturePrediction predict_feature(Feature feature, const Pose2& T_map_base, const PlanarLine& line_map,
                                  const Eigen::Vector2d& first_normal, const LineObservation& observation,
                                  const Eigen::Matrix2d& covariance);

/// H alone.
ObservationJacobians feature_jacobians(Feature feature, const Pose2& T_map_base, const PlanarLine& line_map,
                                       const Eigen::Vector2d& first_normal);

}  // namespace loopline::line_slam
