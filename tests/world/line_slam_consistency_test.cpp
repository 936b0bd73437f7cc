/// The filter in a small square ring, 200 seeds: is its covariance that of its error? Normalised estimation
/// error squared (NEES) inside the 95 % band, with wheels whose diameters are not what they are said to be.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "api/dense_algebra.h"
#include "line_slam/line_ekf_slam.h"
#include "line_slam/smoother.h"
#include "support/line_slam_world.h"

using namespace loopline;
using namespace loopline::line_slam;

namespace {

constexpr int seeds = 200;
constexpr double side_m = 8, step_m = 0.1;

struct RingRun {
    std::vector<Pose2> truth;  ///< in the frame of the first pose
    std::vector<Pose2> online, smoothed;
    std::vector<Eigen::Matrix3d> online_covariance, smoothed_covariance;
    std::size_t walls_in_map = 0;
};

/// One and a quarter rounds of the ring.
RingRun drive_around(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    LineSlamParameters parameters;
    parameters.sigma_wall_m = 0.02;
    const auto& drive = parameters.drive;
    const WheelCalibration wrong{drive.sigma_scale * normal(random), drive.sigma_scale * normal(random),
                                 drive.sigma_scale * normal(random)};
    const auto walls = test::square_ring(side_m + 4, side_m - 4);
    Pose2 T_world_base{-0.5 * side_m, -0.5 * side_m, 0};
    const Pose2 T_first = T_world_base;

    LineEkfSlam slam(parameters);
    RingRun run;
    WheelTravel travel;
    for (int leg = 0; leg < 5; ++leg)
        for (int i = 0; i < static_cast<int>(side_m / step_m) + 10; ++i) {
            std::vector<LineObservation> seen;
            for (const auto& w : walls) {
                LineObservation z;
                if (!test::view(w, T_world_base, 6, z)) continue;
                test::disturb(z, 0.02, random);
                seen.push_back(z);
            }
            EXPECT_EQ(slam.step(moved(travel, drive.track_width_m), seen), SlamStatus::good);
            run.truth.push_back(T_first.inverse() * T_world_base);
            run.online.push_back(slam.filter().T_map_base());
            run.online_covariance.push_back(slam.filter().pose_covariance());
            const bool turning = i >= static_cast<int>(side_m / step_m);
            const WheelTravel truth =
                wheel_travel(turning ? Pose2{0, 0, M_PI / 20} : Pose2{step_m, 0, 0}, drive.track_width_m);
            T_world_base = T_world_base * moved(truth, drive.track_width_m);
            travel = test::measured(truth, drive, wrong, random);
        }
    const SmoothedPath smoothed = smooth(slam.history(), {});
    EXPECT_TRUE(smoothed.good);
    run.smoothed = smoothed.poses;
    run.smoothed_covariance = smoothed.covariances;
    run.walls_in_map = smoothed.walls.size();
    return run;
}

double nees(const Pose2& estimate, const Pose2& truth, const Eigen::Matrix3d& covariance) {
    const Eigen::Vector3d e(estimate.x_m - truth.x_m, estimate.y_m - truth.y_m,
                            wrap_to_pi(estimate.phi_rad - truth.phi_rad));
    return squared_in_sigmas(e, covariance);
}

/// Bounds of the mean of `seeds` independent NEES of three degrees of freedom: chi-square with 600
/// degrees, 2.5 % each side.
constexpr double lower = 534.02 / seeds, upper = 669.77 / seeds;

TEST(LineSlamConsistency, nees_stays_in_its_band_around_the_ring) {
    std::vector<RingRun> runs;
    for (int seed = 1; seed <= seeds; ++seed) runs.push_back(drive_around(static_cast<std::uint64_t>(seed)));
    const std::size_t steps = runs[0].truth.size();
    int inside = 0, smoothed_inside = 0, checked = 0;
    double mean_online = 0, mean_smoothed = 0;
    for (std::size_t k = 20; k < steps; k += 10) {
        double online = 0, smoothed = 0;
        for (const RingRun& r : runs) {
            online += nees(r.online[k], r.truth[k], r.online_covariance[k]) / seeds;
            smoothed += nees(r.smoothed[k], r.truth[k], r.smoothed_covariance[k]) / seeds;
        }
        ++checked;
        inside += lower < online && online < upper;
        smoothed_inside += lower < smoothed && smoothed < upper;
        mean_online += online;
        mean_smoothed += smoothed;
    }
    RecordProperty("nees_mean", std::to_string(mean_online / checked));
    std::printf("NEES mean %.2f online (%d of %d inside [%.2f, %.2f]), %.2f smoothed (%d inside)\n",
                mean_online / checked, inside, checked, lower, upper, mean_smoothed / checked,
                smoothed_inside);
    // Of independent steps 95 % would be inside; these follow each other, and leave or stay together.
    EXPECT_GE(inside, static_cast<int>(0.8 * checked));
    EXPECT_GT(mean_online / checked, lower);
    EXPECT_LT(mean_online / checked, upper);
    EXPECT_GE(smoothed_inside, static_cast<int>(0.75 * checked));
    EXPECT_GT(mean_smoothed / checked, lower);
    EXPECT_LT(mean_smoothed / checked, upper);
    for (const RingRun& r : runs) EXPECT_EQ(r.walls_in_map, 8u);
}

}  // namespace
