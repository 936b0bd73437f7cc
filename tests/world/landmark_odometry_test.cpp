/// Motion by landmarks that are points, over many drives.
#include "landmark_odometry/landmark_odometry.h"

#include <gtest/gtest.h>

#include "api/dense_algebra.h"
#include "support/grove.h"

using namespace loopline;
using namespace loopline::landmark_odometry;
using namespace loopline::landmark_odometry::test;

namespace {

Eigen::Vector3d off(const Pose2& from, const Pose2& to) {
    return {to.x_m - from.x_m, to.y_m - from.y_m, wrap_to_pi(to.phi_rad - from.phi_rad)};
}

}  // namespace

// 30 drives of 400 m among trees by wheels that are 3 % too long and turn 5 % too little.
TEST(LandmarkOdometry, drifts_less_than_a_percent_and_says_how_much) {
    constexpr int runs = 30;
    double way_m = 0, end_m = 0, worst_m = 0, dead_m = 0, squares = 0;
    for (std::uint64_t seed = 0; seed < runs; ++seed) {
        GroveSettings settings;
        settings.scale = 1.03;
        settings.turn_scale = 0.95;
        Grove grove(settings, seed);
        LandmarkOdometry odometry({});
        Pose2 by_wheels;
        odometry.take({}, grove.look());
        while (grove.way_m() < 400) {
            const Twist2 told = grove.drive();
            by_wheels = by_wheels * exp_se2(told);
            odometry.take(told, grove.look());
        }
        const PoseWithCovariance pose = odometry.pose();
        const Pose2 T{pose.T_map_base.translation_m.x(), pose.T_map_base.translation_m.y(),
                      pose.T_map_base.yaw_rad()};
        const Eigen::Vector3d error = off(grove.T_map_base(), T);
        Eigen::Matrix3d covariance;
        constexpr int in_plane[] = {0, 1, 5};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) covariance(i, j) = pose.covariance(in_plane[i], in_plane[j]);
        squares += squared_in_sigmas(error, covariance) / runs;
        way_m += grove.way_m();
        end_m += error.head<2>().norm();
        worst_m = std::max(worst_m, error.head<2>().norm());
        dead_m += off(grove.T_map_base(), by_wheels).head<2>().norm();
        EXPECT_NEAR(odometry.counts().sum_of_squares / double(2 * odometry.counts().matched), 1, 0.15);
    }
    RecordProperty("drift_percent", std::to_string(100 * end_m / way_m));
    RecordProperty("wheels_percent", std::to_string(100 * dead_m / way_m));
    RecordProperty("nees", std::to_string(squares));
    EXPECT_LT(end_m / way_m, 0.01);
    EXPECT_LT(worst_m, 0.02 * 400);
    EXPECT_GT(dead_m / way_m, 0.02);
    EXPECT_GT(squares, 0.3);
    EXPECT_LT(squares, 5);
}
