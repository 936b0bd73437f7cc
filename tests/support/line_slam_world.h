/// A vehicle that drives through a world of straight walls and sees them as lines with exactly known noise:
/// what an estimator's own statistics can be tested against.
#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <random>
#include <vector>

#include "line_slam/line_observation.h"
#include "line_slam/motion_model.h"

namespace loopline::test {

struct WorldWall {
    Eigen::Vector2d from_m, to_m;  ///< seen from the left of from -> to
    line_slam::PlanarLine line() const {
        const Eigen::Vector2d t = (to_m - from_m).normalized();
        const Eigen::Vector2d n(t.y(), -t.x());
        return {n.dot(from_m), std::atan2(n.y(), n.x())};
    }
};

/// A closed polygon, counter-clockwise seen from inside, clockwise from outside.
inline std::vector<WorldWall> polygon(const std::vector<Eigen::Vector2d>& corners_m) {
    std::vector<WorldWall> walls;
    for (std::size_t i = 0; i < corners_m.size(); ++i)
        walls.push_back({corners_m[i], corners_m[(i + 1) % corners_m.size()]});
    return walls;
}

/// A square ring: outer walls of `outer_m`, an inner block of `inner_m`, both around the origin.
inline std::vector<WorldWall> square_ring(double outer_m, double inner_m) {
    const double a = 0.5 * outer_m, b = 0.5 * inner_m;
    std::vector<WorldWall> walls = polygon({{-a, -a}, {a, -a}, {a, a}, {-a, a}});
    for (const WorldWall& w : polygon({{-b, -b}, {-b, b}, {b, b}, {b, -b}})) walls.push_back(w);
    return walls;
}

/// The part of `wall` within `range_m` of the vehicle as an exact line observation, if it faces the vehicle
/// and is long enough; without occlusion.
inline bool view(const WorldWall& wall, const Pose2& T_world_base, double range_m,
                 line_slam::LineObservation& observation) {
    const line_slam::PlanarLine line = wall.line();
    const Eigen::Vector2d p = T_world_base.translation();
    const double distance_m = -line.signed_distance_m(p);
    if (distance_m < 0.2 || distance_m > range_m) return false;
    const double half_m = std::sqrt(range_m * range_m - distance_m * distance_m), at_m = line.along_m(p);
    const double a_m = line.along_m(wall.from_m), b_m = line.along_m(wall.to_m);
    const double from_m = std::max(std::min(a_m, b_m), at_m - half_m);
    const double to_m = std::min(std::max(a_m, b_m), at_m + half_m);
    if (to_m - from_m < 0.5) return false;
    observation.line = line_slam::predicted_line(T_world_base, line);
    observation.start_m = T_world_base.inverse() * line.point_m(from_m);
    observation.end_m = T_world_base.inverse() * line.point_m(to_m);
    return true;
}

/// Gives `observation` the covariance of a fit whose ends lie `sigma_m` off, and draws that error.
inline void disturb(line_slam::LineObservation& observation, double sigma_m, std::mt19937_64& random) {
    const double middle_m = observation.line.along_m(observation.middle_m());
    const double length_m = observation.length_m();
    Eigen::Matrix2d about_middle;
    about_middle << 1, middle_m, 0, 1;
    const Eigen::Vector2d sigma(sigma_m / std::sqrt(2.0), std::sqrt(2.0) * sigma_m / length_m);
    observation.covariance = about_middle * sigma.cwiseAbs2().asDiagonal() * about_middle.transpose();
    std::normal_distribution<double> normal;
    const Eigen::Vector2d error =
        about_middle * Eigen::Vector2d(sigma.x() * normal(random), sigma.y() * normal(random));
    observation.line.rho_m += error.x();
    observation.line.alpha_rad = wrap_to_pi(observation.line.alpha_rad + error.y());
}

/// The measured travel for a true one: with the drive's noise, and wheels that are not what they are said to
/// be.
inline line_slam::WheelTravel measured(const line_slam::WheelTravel& truth,
                                       const line_slam::DriveParameters& drive,
                                       const line_slam::WheelCalibration& calibration,
                                       std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    const Eigen::Matrix3d Q = line_slam::travel_covariance(truth, drive);
    // moved() multiplies what is measured by (1 + calibration) and the track width too.
    const double ahead_m = 0.5 * (truth.left_m + truth.right_m);
    const double half_turn_m = 0.5 * (truth.right_m - truth.left_m) * (1 + calibration.track);
    return {(ahead_m - half_turn_m) / (1 + calibration.left) + std::sqrt(Q(0, 0)) * normal(random),
            (ahead_m + half_turn_m) / (1 + calibration.right) + std::sqrt(Q(1, 1)) * normal(random),
            truth.side_m + std::sqrt(Q(2, 2)) * normal(random)};
}

}  // namespace loopline::test
