#include "line_slam/assumed_drive.h"

#include <cmath>

namespace loopline::line_slam {
WheelTravel AssumedDrive::over_ground(const DrivePiece& piece) const {
    return {(1 - of(slip, piece.regime, Wheel::left)) * piece.rolled.left_m,
            (1 - of(slip, piece.regime, Wheel::right)) * piece.rolled.right_m, piece.rolled.side_m};
}

Eigen::Matrix3d AssumedDrive::covariance(const DrivePiece& piece) const {
    const auto variance = [this](int component, double way_m) {
        return std::exp(log_variance(component)) * std::abs(way_m) + std::exp(log_variance(rest_noise));
    };
    return Eigen::Vector3d(variance(wheel_noise(piece.regime, Wheel::left), piece.rolled.left_m),
                           variance(wheel_noise(piece.regime, Wheel::right), piece.rolled.right_m),
                           variance(side_noise, mean_way_m(piece.rolled)))
        .asDiagonal();
}

History history_with(const AssumedDrive& assumed, const Drive& drive, const History& history,
                     const SmoothedPath& path) {
    History h = history;
    h.drive.track_width_m = assumed.track_width_m;
    for (std::size_t k = 0; k < h.steps.size(); ++k) {
        HistoryStep& step = h.steps[k];
        if (!path.poses.empty()) step.T_map_base = path.poses[k];
        step.travel_covariance.setZero();
        Pose2 T_previous_base;
        for (const DrivePiece& piece : drive[k]) {
            T_previous_base = T_previous_base * moved(assumed.over_ground(piece), assumed.track_width_m);
            step.travel_covariance += assumed.covariance(piece);
        }
        step.travel = wheel_travel(T_previous_base, assumed.track_width_m);
    }
    return h;
}

}  // namespace loopline::line_slam
