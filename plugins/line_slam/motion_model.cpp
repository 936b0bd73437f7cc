#include "line_slam/motion_model.h"

#include <cmath>

namespace loopline::line_slam {

WheelTravel wheel_travel(const Pose2& T_old_new, double track_width_m) {
    const double half_turn = 0.5 * T_old_new.phi_rad;
    const double c = std::cos(half_turn), s = std::sin(half_turn);
    const double ahead_m = c * T_old_new.x_m + s * T_old_new.y_m;
    return {ahead_m - half_turn * track_width_m, ahead_m + half_turn * track_width_m,
            -s * T_old_new.x_m + c * T_old_new.y_m};
}

Pose2 moved(const WheelTravel& travel, double track_width_m, const WheelCalibration& calibration) {
    const double left_m = (1 + calibration.left) * travel.left_m,
                 right_m = (1 + calibration.right) * travel.right_m;
    const double ahead_m = 0.5 * (left_m + right_m);
    const double turn = (right_m - left_m) / ((1 + calibration.track) * track_width_m);
    const double c = std::cos(0.5 * turn), s = std::sin(0.5 * turn);
    return {ahead_m * c - travel.side_m * s, ahead_m * s + travel.side_m * c, turn};
}

MotionJacobians motion_jacobians(const WheelTravel& travel, double track_width_m,
                                 const WheelCalibration& calibration) {
    const Pose2 T_old_new = moved(travel, track_width_m, calibration);
    const double c = std::cos(0.5 * T_old_new.phi_rad), s = std::sin(0.5 * T_old_new.phi_rad);
    const Eigen::Vector3d to_ahead(c, s, 0), to_turn(-0.5 * T_old_new.y_m, 0.5 * T_old_new.x_m, 1);
    const double turn_per_m = 1 / ((1 + calibration.track) * track_width_m);
    MotionJacobians J;
    const Eigen::Vector3d to_left = 0.5 * to_ahead - turn_per_m * to_turn;
    const Eigen::Vector3d to_right = 0.5 * to_ahead + turn_per_m * to_turn;
    J.travel.col(0) = (1 + calibration.left) * to_left;
    J.travel.col(1) = (1 + calibration.right) * to_right;
    J.travel.col(2) = Eigen::Vector3d(-s, c, 0);
    J.calibration.col(0) = travel.left_m * to_left;
    J.calibration.col(1) = travel.right_m * to_right;
    J.calibration.col(2) = -T_old_new.phi_rad / (1 + calibration.track) * to_turn;
    return J;
}

ExpectedTravel expected_travel(const Pose2& T_old_new, double track_width_m,
                               const WheelCalibration& calibration) {
    const double phi = T_old_new.phi_rad, c = std::cos(0.5 * phi), s = std::sin(0.5 * phi);
    const double ahead_m = c * T_old_new.x_m + s * T_old_new.y_m,
                 side_m = -s * T_old_new.x_m + c * T_old_new.y_m;
    const double half_track_m = 0.5 * (1 + calibration.track) * track_width_m;
    const double left = 1 + calibration.left, right = 1 + calibration.right;
    ExpectedTravel e;
    e.travel = {(ahead_m - phi * half_track_m) / left, (ahead_m + phi * half_track_m) / right, side_m};
    e.motion << c / left, s / left, (0.5 * side_m - half_track_m) / left,  //
        c / right, s / right, (0.5 * side_m + half_track_m) / right,       //
        -s, c, -0.5 * ahead_m;
    e.calibration << -e.travel.left_m / left, 0, -0.5 * phi * track_width_m / left,  //
        0, -e.travel.right_m / right, 0.5 * phi * track_width_m / right,             //
        0, 0, 0;
    return e;
}

double mean_way_m(const WheelTravel& travel) {
    return 0.5 * (std::abs(travel.left_m) + std::abs(travel.right_m)) + std::abs(travel.side_m);
}

Eigen::Matrix3d travel_covariance(const WheelTravel& travel, const DriveParameters& drive,
                                  double sigma_left_m, double sigma_right_m) {
    const auto variance = [&](double sigma_at_1m, double way_m) {
        return sigma_at_1m * sigma_at_1m * std::abs(way_m) + drive.sigma_rest_m * drive.sigma_rest_m;
    };
    return Eigen::Vector3d(variance(sigma_left_m > 0 ? sigma_left_m : drive.sigma_wheel_m, travel.left_m),
                           variance(sigma_right_m > 0 ? sigma_right_m : drive.sigma_wheel_m, travel.right_m),
                           variance(drive.sigma_side_m, mean_way_m(travel)))
        .asDiagonal();
}

}  // namespace loopline::line_slam
