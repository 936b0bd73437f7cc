/// A vehicle that drives straight and turns at random corners of a room, with wheels that slip differently in
/// each, seen through the real wide interval and filter: what a calibration can be tested against.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "line_slam/calibration.h"
#include "line_slam/line_ekf_slam.h"
#include "support/line_slam_world.h"

namespace loopline::test {

struct SlipTruth {
    double track_width_m = 0.35;
    line_slam::RegimeWheelValues slip{{{0.005, 0.01}, {0.3, 0.02}, {0.03, 0.2}}};
    line_slam::RegimeWheelValues sigma_m{{{0.002, 0.002}, {0.004, 0.004}, {0.004, 0.004}}};
    line_slam::RegimeWheelValues scatter{{{0, 0}, {0.02, 0}, {0, 0.02}}};
    double sigma_side_m = 0.004;
};

struct SlippingDrive {
    line_slam::LineSlamParameters slam;
    line_slam::IntervalParameters interval;
    SlipTruth truth;
    int corners = 40;
    bool right_turns = true;
    double odometry_track_width_m = 0.35;  ///< that the log's poses are reckoned with
    double largest_inner_m = 0.003;        ///< rolled by the inner wheel from scan to scan; each turn takes
    double smallest_inner_m = 0.003;       ///< one of its own between the two

    SlippingDrive() {
        slam.drive.track_width_m = truth.track_width_m;
        slam.sigma_wall_m = 0;
        interval.scans = 5;
    }
};

/// Drives as soon as it is made.
class SlippingVehicle {
 public:
    SlippingVehicle(const SlippingDrive& drive, std::uint64_t seed)
        : settings_(drive), random_(seed), interval_(drive.interval, drive.slam.drive), slam_(drive.slam) {
        scan(line_slam::Regime::straight);
        for (int corner = 0; corner < drive.corners; ++corner) {
            go_straight();
            turn(next_turn());
        }
    }

    const line_slam::History& history() const { return slam_.history(); }
    const line_slam::Drive& drive() const { return drive_; }
    /// Of the steps, in the map frame.
    const std::vector<Pose2>& truth() const { return truth_; }
    /// Where each step was predicted to lead from the true pose of the one before, in that one's frame, with
    /// the covariance of (left, right, side): what the control and its parameters are worth.
    struct Prediction {
        line_slam::WheelTravel error;
        Eigen::Matrix3d covariance;
    };
    const std::vector<Prediction>& predictions() const { return predictions_; }

 private:
    using Regime = line_slam::Regime;
    using Wheel = line_slam::Wheel;
    static constexpr double straight_m = 0.02, outer_m = 0.016;  ///< from scan to scan

    double normal() { return std::normal_distribution<double>()(random_); }
    double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(random_); }

    void go_straight() {
        enter(Regime::straight);
        const int scans = static_cast<int>(uniform(60, 120));
        for (int i = 0; i < scans; ++i) go(Regime::straight, {straight_m, straight_m});
    }
    void turn(Regime regime) {
        enter(regime);
        const double inner_m = uniform(settings_.smallest_inner_m, settings_.largest_inner_m);
        const line_slam::WheelValues rolled = regime == Regime::left
                                                  ? line_slam::WheelValues{inner_m, outer_m}
                                                  : line_slam::WheelValues{outer_m, inner_m};
        const double from_rad = T_world_base_.phi_rad;
        while (std::abs(wrap_to_pi(T_world_base_.phi_rad - from_rad)) < M_PI / 2 - 0.02) go(regime, rolled);
    }
    /// To where there is room.
    Regime next_turn() {
        const Eigen::Vector2d here_m = T_world_base_.translation();
        const Eigen::Vector2d left(-std::sin(T_world_base_.phi_rad), std::cos(T_world_base_.phi_rad));
        const bool any = std::abs(left.dot(here_m)) < 1;
        const bool to_left = any ? uniform(0, 1) < 0.5 : left.dot(here_m) < 0;
        return to_left || !settings_.right_turns ? Regime::left : Regime::right;
    }
    void enter(Regime regime) {
        for (const Wheel wheel : line_slam::both_wheels)
            of(deviation_, wheel) = of(settings_.truth.scatter, regime, wheel) * normal();
    }

    void go(Regime regime, const line_slam::WheelValues& rolled_m) {
        const SlipTruth& truth = settings_.truth;
        line_slam::WheelValues ground_m;
        for (const Wheel wheel : line_slam::both_wheels)
            of(ground_m, wheel) =
                (1 - of(truth.slip, regime, wheel) - of(deviation_, wheel)) * of(rolled_m, wheel) +
                of(truth.sigma_m, regime, wheel) * std::sqrt(of(rolled_m, wheel)) * normal();
        const double side_m = truth.sigma_side_m * std::sqrt(0.5 * (rolled_m[0] + rolled_m[1])) * normal();
        T_world_base_ =
            T_world_base_ * line_slam::moved({ground_m[0], ground_m[1], side_m}, truth.track_width_m);
        T_odom_base_ =
            T_odom_base_ * line_slam::moved({rolled_m[0], rolled_m[1], 0}, settings_.odometry_track_width_m);
        scan(regime);
    }

    void scan(Regime regime) {
        if (!interval_.add({T_odom_base_, 0.05, regime})) return;
        std::vector<line_slam::LineObservation> seen;
        for (const WorldWall& wall : walls_) {
            line_slam::LineObservation z;
            if (!view(wall, T_world_base_, 15, z)) continue;
            disturb(z, 0.01, random_);
            seen.push_back(z);
        }
        remember_prediction();
        drive_.push_back(interval_.drive_pieces());
        EXPECT_EQ(slam_.step(interval_.pieces(), seen), line_slam::SlamStatus::good);
        interval_.restart();
        truth_.push_back(T_world_first_.inverse() * T_world_base_);
    }

    void remember_prediction() {
        if (truth_.empty()) return;
        const double track_width_m = settings_.slam.drive.track_width_m;
        Prediction p{{}, Eigen::Matrix3d::Zero()};
        Pose2 T_previous_base;
        for (const line_slam::MotionPiece& piece : interval_.pieces()) {
            T_previous_base = T_previous_base * line_slam::moved(piece.travel, track_width_m);
            p.covariance += piece.covariance;
        }
        const Pose2 T_true = truth_.back().inverse() * (T_world_first_.inverse() * T_world_base_);
        const auto predicted = line_slam::wheel_travel(T_previous_base, track_width_m),
                   was = line_slam::wheel_travel(T_true, track_width_m);
        p.error = {was.left_m - predicted.left_m, was.right_m - predicted.right_m,
                   was.side_m - predicted.side_m};
        predictions_.push_back(p);
    }

    SlippingDrive settings_;
    std::mt19937_64 random_;
    std::vector<WorldWall> walls_ = polygon({{-6, -6}, {6, -6}, {6, 6}, {-6, 6}});
    line_slam::WideInterval interval_;
    line_slam::LineEkfSlam slam_;
    line_slam::Drive drive_;
    line_slam::WheelValues deviation_{};
    Pose2 T_world_first_{-2, -2, 0}, T_world_base_ = T_world_first_, T_odom_base_;
    std::vector<Pose2> truth_;
    std::vector<Prediction> predictions_;
};

}  // namespace loopline::test
