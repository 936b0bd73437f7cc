/// A receiver's own fixes against the truth, and the truth between two of its poses.
#include <gtest/gtest.h>

#include <random>

#include "api/pose3_motion.h"
#include "evaluate/evaluate_run.h"
#include "evaluate/fix_errors.h"
#include "gnss/gps_observation.h"

using namespace loopline;

namespace {

constexpr StampNs tenth_ns = 100'000'000;

/// On a circle of 20 m at 10 m/s, a pose each 0.1 s, about a frame whose x axis points 30 deg left of east.
std::shared_ptr<EvaluationReference> circle() {
    auto reference = std::make_shared<EvaluationReference>();
    for (int i = 0; i <= 100; ++i) {
        const double angle_rad = 0.05 * i;
        reference->truth.push_back(
            {i * tenth_ns,
             Pose3(Pose2{20 * std::sin(angle_rad), 20 * (1 - std::cos(angle_rad)), wrap_to_pi(angle_rad)})});
    }
    reference->surveyed.earth = EarthFrame{48, 11, 500, 30};
    return reference;
}

/// The fix at `stamp_ns` of an antenna at `l_m` that errs by `e_m` in the truth's frame.
mrpt::obs::CObservationGPS::Ptr fix_on(const EvaluationReference& reference, StampNs stamp_ns,
                                       const Eigen::Vector3d& l_m, const Eigen::Vector3d& e_m,
                                       bool has_height, const std::string& label) {
    gnss::GnssFix fix;
    fix.stamp_ns = stamp_ns;
    fix.quality = gnss::FixQuality::single;
    fix.has_position = true;
    fix.has_height = has_height;
    fix.p_base_antenna_m = l_m;
    const double angle_rad = 0.5 * seconds_between(0, stamp_ns);
    const Pose3 T_ref_base(
        Pose2{20 * std::sin(angle_rad), 20 * (1 - std::cos(angle_rad)), wrap_to_pi(angle_rad)});
    fix.antenna = gnss::GeoReference(*reference.surveyed.earth).geodetic(T_ref_base * l_m + e_m);
    return gnss::gps_observation(fix, label);
}

double value(const std::map<std::string, MetricValue>& metrics, const char* key) {
    return std::get<double>(metrics.at(key));
}

}  // namespace

TEST(FixErrors, are_those_of_the_antenna_at_the_fixs_own_time) {
    const auto reference = circle();
    const auto errors = FixErrors::against(reference);
    ASSERT_TRUE(errors);
    std::mt19937 random(11);
    std::normal_distribution<double> normal(0, 1);
    double horizontal_m2 = 0, vertical_m2 = 0, most_m = 0;
    for (int i = 0; i < 200; ++i) {
        const StampNs stamp_ns =
            45'000'000LL * i;  // mostly between two poses, where the nearest is up to 0.5 m away
        const Eigen::Vector3d e_m(normal(random), normal(random), 2 * normal(random));
        errors->take(*fix_on(*reference, stamp_ns, {2, -0.5, 1.5}, e_m, true, "a"), stamp_ns);
        horizontal_m2 += e_m.head<2>().squaredNorm();
        vertical_m2 += e_m.z() * e_m.z();
        most_m = std::max(most_m, e_m.head<2>().norm());
    }
    const auto metrics = errors->metrics();
    // A chord of 1 m is up to 6 mm from the circle.
    EXPECT_NEAR(value(metrics, "gnss_horizontal_rmse_m"), std::sqrt(horizontal_m2 / 200), 0.007);
    EXPECT_NEAR(value(metrics, "gnss_vertical_rmse_m"), std::sqrt(vertical_m2 / 200), 1e-4);
    EXPECT_NEAR(value(metrics, "gnss_horizontal_max_m"), most_m, 0.007);
    EXPECT_EQ(std::get<std::int64_t>(metrics.at("gnss_fixes_compared")), 200);
    EXPECT_EQ(metrics.size(), 4u) << "one receiver";
}

TEST(FixErrors, of_several_receivers_are_told_apart_and_heights_are_not_invented) {
    const auto reference = circle();
    const auto errors = FixErrors::against(reference);
    for (int i = 0; i < 10; ++i) {
        errors->take(*fix_on(*reference, i * tenth_ns, {0, 0, 0}, {3, 0, 0}, false, "flat"), i * tenth_ns);
        errors->take(*fix_on(*reference, i * tenth_ns, {0, 0, 0}, {0, 1, 2}, true, "high"), i * tenth_ns);
    }
    mrpt::obs::CObservationGPS nothing;
    errors->take(nothing, tenth_ns);
    errors->take(*fix_on(*reference, 20'000'000'000, {0, 0, 0}, {9, 9, 9}, true, "high"), 20'000'000'000);
    const auto metrics = errors->metrics();
    EXPECT_NEAR(value(metrics, "gnss_flat_horizontal_rmse_m"), 3, 1e-5);
    EXPECT_EQ(metrics.count("gnss_flat_vertical_rmse_m"), 0u);
    EXPECT_NEAR(value(metrics, "gnss_high_horizontal_rmse_m"), 1, 1e-5);
    EXPECT_NEAR(value(metrics, "gnss_horizontal_rmse_m"), std::sqrt(5), 1e-5);
    EXPECT_NEAR(value(metrics, "gnss_vertical_rmse_m"), 2, 1e-5);
    EXPECT_EQ(std::get<std::int64_t>(metrics.at("gnss_high_fixes_compared")), 10)
        << "one comes when no truth is known";
}

TEST(FixErrors, need_a_truth_with_headings_that_lies_on_the_earth) {
    EXPECT_FALSE(FixErrors::against(nullptr));
    auto reference = circle();
    reference->truth_has_orientation = false;
    EXPECT_FALSE(FixErrors::against(reference));
    reference = circle();
    reference->surveyed.earth.reset();
    EXPECT_FALSE(FixErrors::against(reference));
}

TEST(ReferencePoses, between_two_of_the_truth_are_on_the_way_from_one_to_the_other) {
    const StampedPath path(std::vector<StampedPose>{{0, Pose3(Pose2{0, 0, 3})},
                                                    {tenth_ns, Pose3(Pose2{1, 0, -3})},
                                                    {10 * tenth_ns, Pose3(Pose2{10, 0, 0})}});
    ReferencePoses poses(path, 0.1, ReferencePoses::Kind::poses_between);
    const auto quarter = poses.at(tenth_ns / 4);
    ASSERT_TRUE(quarter);
    EXPECT_NEAR(quarter->translation_m.x(), 0.25, 1e-12);
    EXPECT_NEAR(quarter->yaw_rad(), 3 + (2 * M_PI - 6) / 4, 1e-9) << "the short way";
    EXPECT_EQ(poses.at(tenth_ns)->translation_m.x(), 1) << "as it is";
    EXPECT_EQ(poses.at(3 * tenth_ns / 2)->translation_m.x(), 1)
        << "the next is too far away to say what lies between";
    EXPECT_FALSE(poses.at(5 * tenth_ns));
    EXPECT_FALSE(poses.at(-tenth_ns / 2)) << "where a moving vehicle was before, it does not say";
    EXPECT_EQ(poses.at(-1000)->translation_m.x(), 0) << "but a rounded stamp is the same one";
}

/// A path that is exactly the truth's has no error, though its times are others.
TEST(EvaluateRun, does_not_take_the_time_to_the_nearest_true_pose_for_an_error) {
    auto reference = std::make_shared<EvaluationReference>();
    Trajectory trajectory;
    for (int i = 0; i < 50; ++i) {
        reference->truth.push_back({i * tenth_ns, Pose3(Pose2{2.0 * i, 0, 0})});  // 20 m/s
        if (i == 49) continue;
        const StampNs stamp_ns = i * tenth_ns + 50'000'000 - 1'000'000 * (i % 7);
        trajectory.append(static_cast<std::uint64_t>(i), stamp_ns,
                          Pose3(Pose2{20 * seconds_between(0, stamp_ns), 0, 0}), Matrix6d::Zero());
    }
    reference->surveyed.earth = EarthFrame{48, 11, 500, 0};
    const auto metrics = evaluate_run(trajectory, reference, {}, EarthFrame{48, 11, 500, 0}).metrics;
    EXPECT_NEAR(value(metrics, "earth_horizontal_rmse_m"), 0, 1e-9);
    EXPECT_NEAR(value(metrics, "ate_max_m"), 0, 1e-9);
}
