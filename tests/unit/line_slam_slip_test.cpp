/// A bump of the ground turns the vehicle by more than its wheels can tell: the walls beside it bring the
/// heading back.
#include <gtest/gtest.h>

#include "line_slam/line_ekf_slam.h"
#include "support/line_slam_world.h"

using namespace loopline;
using namespace loopline::line_slam;

namespace {

constexpr double step_m = 0.05, range_m = 8, end_sigma_m = 0.002;

/// Along a corridor whose walls are parallel, with wheels that are well known; `bump_rad` after 60 steps.
struct CorridorDrive {
    explicit CorridorDrive(const std::vector<test::WorldWall>& walls) : walls_(walls), slam_(parameters()) {}

    static LineSlamParameters parameters() {
        LineSlamParameters p;
        p.drive.track_width_m = 0.35;
        p.drive.sigma_wheel_m = 0.0006;
        p.drive.sigma_side_m = 0.002;
        p.drive.sigma_rest_m = 3e-5;
        p.drive.sigma_scale = 0.005;
        return p;
    }
    /// `off_rad` turns what is seen of the first wall.
    void step(double bump_rad = 0, double off_rad = 0) {
        T_world_base_ = T_world_base_ * Pose2{step_m, 0, bump_rad};
        std::vector<LineObservation> seen;
        for (const test::WorldWall& wall : walls_) {
            LineObservation z;
            if (!test::view(wall, T_world_base_, range_m, z)) continue;
            test::disturb(z, end_sigma_m, random_);
            if (&wall == &walls_.front()) z.line.alpha_rad += off_rad;
            seen.push_back(z);
        }
        ASSERT_EQ(slam_.step(Pose2{step_m, 0, 0}, std::move(seen)), SlamStatus::good);
    }
    int lines_in_map() const {
        int count = 0;
        for (int id = 0; id < slam_.filter().line_ids(); ++id) count += slam_.filter().exists(id);
        return count;
    }
    double heading_error_rad() const {
        return wrap_to_pi(slam_.filter().T_map_base().phi_rad - T_world_base_.phi_rad);
    }

    std::vector<test::WorldWall> walls_;
    LineEkfSlam slam_;
    Pose2 T_world_base_;
    std::mt19937_64 random_{1};
};

}  // namespace

TEST(LineSlamSlip, a_bump_between_two_parallel_walls_is_taken_for_what_it_is) {
    for (const double bump_rad : {0.008, -0.008}) {
        CorridorDrive drive(test::polygon({{-20, -1}, {40, -1}, {40, 1.2}, {-20, 1.2}}));
        for (int i = 0; i < 60; ++i) drive.step();
        drive.step(bump_rad);
        for (int i = 0; i < 60; ++i) drive.step();
        EXPECT_EQ(drive.slam_.counts().slips, 1);
        EXPECT_EQ(drive.lines_in_map(), 2) << "no wall is there twice";
        EXPECT_LT(std::abs(drive.heading_error_rad()), 0.1 * std::abs(bump_rad));
    }
}

TEST(LineSlamSlip, a_wall_that_is_off_alone_moves_nobody) {
    CorridorDrive drive(test::polygon({{-3, -3}, {3, -3}, {3, 3}, {-3, 3}}));
    for (int i = 0; i < 20; ++i) drive.step();
    for (int i = 0; i < 5; ++i) drive.step(0, 0.02);
    EXPECT_EQ(drive.slam_.counts().slips, 0);
    EXPECT_LT(std::abs(drive.heading_error_rad()), 1e-3);
}
