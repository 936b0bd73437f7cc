/// The paper's light filter: its equations, rows that are left out, and frames out of step.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "fusion/paper_path.h"

using namespace loopline;
using namespace loopline::fusion;

namespace {

constexpr StampNs paper_second = 1'000'000'000;
const gnss::Geodetic paper_origin{25, 118.6, 30};

Vector6d numbers(double x, double y, double z, double roll, double pitch, double yaw) {
    Vector6d s;
    s << x, y, z, roll, pitch, yaw;
    return s;
}

TEST(PaperFilter, numbers_and_poses_are_the_same) {
    const Vector6d s = numbers(1, -2, 3, 0.2, -0.4, 2.9);
    EXPECT_LT((as_numbers(as_pose(s)) - s).norm(), 1e-12);
}

// F of eq. (4) to (6): what the covariance becomes is what moved states do.
TEST(PaperFilter, prediction_carries_the_covariance_as_its_derivative_says) {
    const Vector6d s = numbers(1, -2, 3, 0.02, -0.04, 2.9);
    Matrix6d P = Matrix6d::Random();
    P = 0.01 * (P * P.transpose()).eval();
    PaperFilter filter(as_pose(s), P);
    filter.predict(1.7, 0.4, Matrix6d::Zero());
    Matrix6d F;
    constexpr double h = 1e-6;
    for (int k = 0; k < 6; ++k) {
        Vector6d ends[2];
        for (const int side : {0, 1}) {
            PaperFilter moved(as_pose(s + (side == 0 ? h : -h) * Vector6d::Unit(k)), P);
            moved.predict(1.7, 0.4, Matrix6d::Zero());
            ends[side] = as_numbers(moved.pose());
        }
        F.col(k) = (ends[0] - ends[1]) / (2 * h);
        F(5, k) = wrap_to_pi(ends[0][5] - ends[1][5]) / (2 * h);
    }
    EXPECT_LT((filter.covariance() - F * P * F.transpose()).cwiseAbs().maxCoeff(), 1e-8);
    EXPECT_NEAR(filter.pose().translation_m.x(), 1 + 1.7 * std::cos(2.9), 1e-12);
    EXPECT_NEAR(filter.pose().yaw_rad(), wrap_to_pi(3.3), 1e-12);
}

// Row C8: a fix has no angles. With zeros in their place the vehicle would be turned to the grid's axes.
TEST(PaperFilter, what_a_sensor_does_not_tell_is_left_out) {
    const Matrix6d P = Matrix6d::Identity();
    PaperFilter filter(as_pose(numbers(0, 0, 0, 0, 0, 3.1)), P);
    filter.observe(as_pose(numbers(1, 2, 3, 0, 0, 0)), {0, 1, 2}, Vector6d::Ones());
    EXPECT_LT((as_numbers(filter.pose()) - numbers(0.5, 1, 1.5, 0, 0, 3.1)).norm(), 1e-12);
    EXPECT_NEAR(filter.covariance()(0, 0), 0.5, 1e-12);
    EXPECT_NEAR(filter.covariance()(5, 5), 1, 1e-12);
    filter.observe(as_pose(numbers(0, 0, 0, 0, 0, -3.1)), {5}, Vector6d::Ones());
    EXPECT_NEAR(std::abs(filter.pose().yaw_rad()), M_PI, 1e-9) << "across the cut, not through zero";
}

struct Paper {
    PaperSettings settings;
    double fix_phase_s = 0;  ///< after a frame
    double outage_from_s = 1e9;
    bool wheels = true;
};

/// Along a circle of 60 m at 6 m/s, with an odometry 1 % too long.
PaperPath followed(const Paper& paper, double seconds, double* worst_m = nullptr) {
    PaperPath path(paper.settings);
    const gnss::LocalFrame frame(paper_origin);
    const Twist3 step{{0.6, 0, 0}, {0, 0, 0.01}};
    Pose3 T_enu_base{{0, 0, 0}, inertial::exp_so3({0, 0, 2})}, T_odom_base, T_first;
    for (int k = 0; k <= 10 * seconds; ++k) {
        const StampNs stamp_ns = 50 * paper_second + k * paper_second / 10;
        if (k > 0) {
            T_enu_base = T_enu_base * exp_se3(step);
            T_odom_base = T_odom_base * exp_se3({1.01 * step.shift_m, step.turn_rad});
        }
        std::optional<Twist2> wheels;
        if (paper.wheels && k > 0) wheels = Twist2{0.6, 0, 0.01};
        path.take_pose(stamp_ns, T_odom_base, Matrix6d::Zero(), wheels);
        if (k % 2 == 0) {
            gnss::GnssFix fix;
            fix.stamp_ns = stamp_ns + std::llround(1e9 * paper.fix_phase_s);
            fix.quality = gnss::FixQuality::rtk_fixed;
            fix.has_position = fix.has_height = k < 10 * paper.outage_from_s;
            fix.p_base_antenna_m = {1, 0, 2};
            fix.antenna =
                frame.geodetic(T_enu_base * exp_se3(step * (10 * paper.fix_phase_s)) * fix.p_base_antenna_m);
            path.take_fix(fix, false);
        }
        const auto now = path.known();
        if (worst_m == nullptr || !now || k < 100) continue;
        const Eigen::Vector3d off_m =
            now->T_enu_base.translation_m - (T_enu_base.translation_m + path.earth()->p_enu_m(paper_origin));
        *worst_m = std::max(*worst_m, off_m.norm());
    }
    return path;
}

TEST(PaperPath, follows_the_fixes_and_knows_every_pose) {
    Paper paper;
    paper.settings.wheels_are_there = true;
    double worst_m = 0;
    PaperPath path = followed(paper, 60, &worst_m);
    EXPECT_LT(worst_m, 0.1);
    EXPECT_EQ(path.poses(), 601U);
    EXPECT_EQ(path.finished().size(), 601U);
    EXPECT_EQ(path.count(FixUse::used) + path.count(FixUse::after_path), 301U);
}

// Row C9, and what the default does instead.
TEST(PaperPath, frames_out_of_step_go_on_by_the_lidar_alone) {
    Paper paper;
    paper.fix_phase_s = 0.04;
    paper.settings.sync_s = 0.02;
    double by_lidar_m = 0, moved_m = 0, near_m = 0;
    EXPECT_EQ(followed(paper, 60, &by_lidar_m).fused(), 0U);
    EXPECT_GT(by_lidar_m, 1) << "1 % of 360 m, bent";
    paper.settings.sync_s = 0.05;
    EXPECT_GT(followed(paper, 60, &near_m).fused(), 280U);
    EXPECT_GT(near_m, 0.1) << "a fix 0.04 s old counts as of now";
    paper.settings.sync = Sync::interpolate;
    EXPECT_GT(followed(paper, 60, &moved_m).fused(), 280U);
    EXPECT_LT(moved_m, 0.1);

    paper.settings.wheels_are_there = true;
    paper.wheels = false;
    PaperPath path = followed(paper, 60);
    EXPECT_EQ(path.fused(), 0U);
    EXPECT_GT(path.count(FixUse::out_of_sync), 280U);
}

TEST(PaperPath, an_outage_is_bridged_by_the_lidar) {
    Paper paper;
    paper.outage_from_s = 30;
    PaperPath path = followed(paper, 60);
    EXPECT_EQ(path.count(FixUse::no_position), 151U);
    EXPECT_EQ(path.finished().size(), 601U);
}

}  // namespace
