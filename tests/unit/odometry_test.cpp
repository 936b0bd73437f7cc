/// Dead reckoning: arcs, encoder ticks, growing covariance, and the pose of a scan in logs of every kind.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <random>

#include "odometry/odometry_module.h"

using namespace loopline;

namespace {

StampNs at_s(double seconds) {
    return static_cast<StampNs>(std::llround(seconds * 1e9));
}

/// On a circle: 1 m/s, 0.5 rad/s.
Pose2 on_circle(double seconds) {
    return exp_se2(Twist2{1.0, 0, 0.5} * seconds);
}

void expect_pose(const Pose2& pose, const Pose2& expected, double tolerance) {
    EXPECT_NEAR(pose.x_m, expected.x_m, tolerance);
    EXPECT_NEAR(pose.y_m, expected.y_m, tolerance);
    EXPECT_NEAR(wrap_to_pi(pose.phi_rad - expected.phi_rad), 0, tolerance);
}

struct Published {
    mrpt::obs::CObservationOdometry::Ptr observation;
    std::uint64_t sequence;
};

class Collector : public Publisher {
 public:
    void publish(const mrpt::obs::CObservation::Ptr& observation) override { publish(observation, 0); }
    void publish(const mrpt::obs::CObservation::Ptr& observation, std::uint64_t sequence) override {
        published.push_back(
            {std::dynamic_pointer_cast<mrpt::obs::CObservationOdometry>(observation), sequence});
    }
    std::vector<Published> published;
};

/// The module with a log fed to it item by item.
class OdometryModule : public ::testing::Test {
 protected:
    void configure(const std::string& key, const std::string& value) {
        auto table = module.parameters();
        ASSERT_NE(table.find(key), nullptr) << key;
        ASSERT_FALSE(table.find(key)->parse(value)) << key;
    }
    template <class Observation>
    void feed(const std::shared_ptr<Observation>& observation, double stamp_s, const std::string& label) {
        observation->sensorLabel = label;
        observation->timestamp = stamp_to_mrpt(at_s(stamp_s));
        module.process({sequence++, at_s(stamp_s), observation}, collector);
    }
    void odometry(double stamp_s, const Pose2& pose, const std::string& label = "ODOM") {
        auto observation = mrpt::obs::CObservationOdometry::Create();
        observation->odometry = {pose.x_m, pose.y_m, pose.phi_rad};
        feed(observation, stamp_s, label);
    }
    void ticks(double stamp_s, std::int32_t left, std::int32_t right) {
        auto observation = mrpt::obs::CObservationOdometry::Create();
        observation->hasEncodersInfo = true;
        observation->encoderLeftTicks = left;
        observation->encoderRightTicks = right;
        feed(observation, stamp_s, "ODOM");
    }
    void scan(double stamp_s) { feed(mrpt::obs::CObservation2DRangeScan::Create(), stamp_s, "LASER"); }
    Pose2 published_pose(std::size_t i) const {
        const auto& p = collector.published.at(i).observation->odometry;
        return {p.x(), p.y(), p.phi()};
    }

    Odometry module;
    Collector collector;
    std::uint64_t sequence = 100;
};

}  // namespace

TEST(Twist2, exponential_and_logarithm_are_inverse_and_follow_the_circle) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> length(-5, 5), turn(-3.14, 3.14);
    for (int i = 0; i < 500; ++i) {
        const Twist2 twist{length(random), length(random), i % 5 == 0 ? turn(random) * 1e-9 : turn(random)};
        const Twist2 back = log_se2(exp_se2(twist));
        EXPECT_NEAR(back.forward_m, twist.forward_m, 1e-11);
        EXPECT_NEAR(back.left_m, twist.left_m, 1e-11);
        EXPECT_NEAR(back.turn_rad, twist.turn_rad, 1e-12);
    }
    // A quarter of a circle of radius 2: ends at (2, 2), heading left.
    expect_pose(exp_se2({M_PI, 0, M_PI / 2}), {2, 2, M_PI / 2}, 1e-12);
    // Euler's method with a million steps is the brute force.
    Pose2 walked;
    const Twist2 twist{1.3, -0.4, 2.1};
    for (int i = 0; i < 1000000; ++i)
        walked = walked * Pose2{twist.forward_m * 1e-6, twist.left_m * 1e-6, twist.turn_rad * 1e-6};
    expect_pose(exp_se2(twist), walked, 5e-6);
}

TEST(DifferentialDrive, ticks_follow_the_closed_form_and_counters_may_overflow) {
    const DifferentialDrive drive{0.001, 0.001, 0.5};
    // Left stands, right rolls 0.5 * pi / 2: a quarter turn about the left wheel, 0.25 m beside the axle's
    // middle.
    const auto ticks = static_cast<std::int64_t>(std::llround(0.5 * M_PI / 2 / 0.001));
    const Pose2 turned = exp_se2(motion_from_ticks(drive, {0, 0}, {0, ticks}));
    const double angle = static_cast<double>(ticks) * 0.001 / 0.5;
    expect_pose(turned, {0.25 * std::sin(angle), 0.25 * (1 - std::cos(angle)), angle}, 1e-12);
    EXPECT_NEAR(angle, M_PI / 2, 1e-3);

    TickUnwrapper unwrap;
    unwrap(2147483600, -2147483600);
    const WheelTicks after = unwrap(-2147483596, 2147483596);  // both 100 on, across the overflow
    EXPECT_EQ(after.left, 2147483700);
    EXPECT_EQ(after.right, -2147483700);
}

TEST(OdometryNoise, covariance_agrees_with_a_monte_carlo_walk) {
    const OdometryNoise noise{0.03, 0.02, 0.01, 0.05};
    const int steps = 40, runs = 20000;
    const Pose2 step = exp_se2({0.1, 0, 0.03});
    Eigen::Matrix3d predicted = Eigen::Matrix3d::Zero();
    Pose2 truth;
    for (int i = 0; i < steps; ++i) {
        const Pose2 next = truth * step;
        predicted = propagate_covariance(predicted, truth, next, noise);
        truth = next;
    }
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    Eigen::Matrix3d sampled = Eigen::Matrix3d::Zero();
    const double way_m = step.translation().norm();
    const double sigma_turn = std::sqrt(0.01 * 0.01 * way_m + 0.05 * 0.05 * 0.03 / (2 * M_PI));
    for (int run = 0; run < runs; ++run) {
        Pose2 pose;
        for (int i = 0; i < steps; ++i) {
            const Pose2 half{0, 0, 0.015};
            const Pose2 error =
                half *
                Pose2{0.03 * std::sqrt(way_m) * normal(random), 0.02 * std::sqrt(way_m) * normal(random), 0} *
                half.inverse();
            pose = pose * Pose2{step.x_m + error.x_m, step.y_m + error.y_m,
                                step.phi_rad + sigma_turn * normal(random)};
        }
        const Eigen::Vector3d e(pose.x_m - truth.x_m, pose.y_m - truth.y_m,
                                wrap_to_pi(pose.phi_rad - truth.phi_rad));
        sampled += e * e.transpose() / runs;
    }
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(predicted(i, i) / sampled(i, i), 1, 0.05) << i;
        for (int j = 0; j < i; ++j)
            EXPECT_NEAR(predicted(i, j), sampled(i, j), 0.05 * std::sqrt(sampled(i, i) * sampled(j, j)))
                << i << j;
    }
    // One long step or many short ones of a straight way: the same covariance.
    Eigen::Matrix3d once = propagate_covariance(Eigen::Matrix3d::Zero(), {}, {4, 0, 0}, {0.03, 0, 0, 0});
    EXPECT_NEAR(once(0, 0), 4 * 0.03 * 0.03, 1e-15);
}

TEST_F(OdometryModule, interpolates_exactly_on_an_arc) {
    module.start({});
    for (int i = 0; i <= 20; ++i) {
        odometry(0.2 * i, on_circle(0.2 * i));
        scan(0.2 * i + 0.13);
    }
    EXPECT_EQ(collector.published.size(), 20u) << "the last scan waits";
    module.drain(collector);
    ASSERT_EQ(collector.published.size(), 21u);
    Results results;
    module.finish(results);
    for (std::size_t i = 0; i < 21; ++i) {
        const auto& published = collector.published[i];
        const double stamp_s = 0.2 * static_cast<double>(i) + 0.13;
        EXPECT_EQ(published.sequence, 101 + 2 * i) << "of the scan";
        EXPECT_EQ(published.observation->sensorLabel, "odometry_at_scan");
        EXPECT_EQ(stamp_from_mrpt(published.observation->timestamp), at_s(stamp_s) / 100 * 100);
        expect_pose(published_pose(i), on_circle(stamp_s),
                    1e-9);  // also the extrapolated one: constant velocity
        EXPECT_NEAR(published.observation->velocityLocal.vx, 1.0, 1e-9);
        EXPECT_NEAR(published.observation->velocityLocal.omega, 0.5, 1e-9);
        const auto& entry = module.trajectory()->entries()[i];
        expect_pose(entry.T_map_base.planar(), on_circle(0.13).inverse() * on_circle(stamp_s), 1e-9);
        EXPECT_EQ(entry.sequence, published.sequence);
    }
    EXPECT_EQ(module.trajectory()->entries()[0].covariance.matrix().norm(), 0);
    EXPECT_GT(module.trajectory()->entries()[20].covariance(0, 0),
              module.trajectory()->entries()[10].covariance(0, 0));
    EXPECT_EQ(std::get<std::int64_t>(results.metrics.at("odometry_scans_extrapolated")), 1);
    EXPECT_EQ(results.metrics.count("odometry_scans_by_file_order"), 0u);
}

TEST_F(OdometryModule, action_frame_logs_wait_for_nothing_even_if_stamps_go_backwards) {
    module.start({});
    const double stamps_s[] = {10.0, 10.2, 9.9, 10.1, 10.3, 9.5, 10.5};
    for (std::size_t i = 0; i < 7; ++i) {
        odometry(stamps_s[i], {double(i), -double(i), 0.1 * double(i)});
        scan(stamps_s[i]);
        ASSERT_EQ(collector.published.size(), i + 1);
        expect_pose(published_pose(i), {double(i), -double(i), 0.1 * double(i)}, 1e-12);
    }
}

TEST_F(OdometryModule, a_clock_that_jumps_back_leaves_neighbours_in_the_file) {
    module.start({});
    for (int i = 0; i < 10; ++i) {
        odometry(1000 + 0.1 * i, {0.1 * i, 0, 0});
        scan(1000 + 0.1 * i + 0.05);
    }
    for (int i = 0; i < 10; ++i) {  // 500 s earlier, and then through the same times
        odometry(500 + 0.1 * i, {1 + 0.1 * i, 0, 0});
        scan(500 + 0.1 * i + 0.05);
    }
    module.drain(collector);
    ASSERT_EQ(collector.published.size(), 20u);
    for (std::size_t i = 0; i < 20; ++i) {
        EXPECT_NEAR(published_pose(i).x_m, 0.1 * static_cast<double>(i) + 0.05, i == 9 ? 0.0501 : 1e-8) << i;
        EXPECT_EQ(collector.published[i].sequence, 101 + 2 * i);
    }
}

TEST_F(OdometryModule, a_scan_that_was_logged_late_finds_its_time) {
    module.start({});
    for (int i = 0; i <= 50; ++i) odometry(0.02 * i, on_circle(0.02 * i));
    scan(0.551);
    ASSERT_EQ(collector.published.size(), 1u);
    expect_pose(published_pose(0), on_circle(0.551), 1e-9);
}

TEST_F(OdometryModule, one_absurd_stamp_does_not_hold_up_the_others) {
    module.start({});
    for (int i = 0; i < 100; ++i) {
        odometry(0.1 * i, {0.1 * i, 0, 0});
        scan(i == 20 ? 1e6 : 0.1 * i + 0.01);
    }
    EXPECT_GT(collector.published.size(), 95u);
    module.drain(collector);
    ASSERT_EQ(collector.published.size(), 100u);
    EXPECT_NEAR(published_pose(20).x_m, 2.0, 0.11);
    EXPECT_NEAR(published_pose(21).x_m, 2.11, 1e-9);
}

TEST_F(OdometryModule, scans_before_the_first_odometry_stand_at_it) {
    module.start({});
    scan(0.5);
    scan(0.9);
    odometry(1.0, {3, 4, 0.5});
    ASSERT_EQ(collector.published.size(), 2u);
    expect_pose(published_pose(0), {3, 4, 0.5}, 1e-12);
    Results results;
    module.finish(results);
    expect_pose(module.trajectory()->entries()[1].T_map_base.planar(), {0, 0, 0}, 1e-12);
}

TEST_F(OdometryModule, without_odometry_nothing_is_made_up) {
    module.start({});
    for (int i = 0; i < 5; ++i) scan(i);
    module.drain(collector);
    EXPECT_TRUE(collector.published.empty());
    EXPECT_TRUE(module.trajectory()->empty());
    Results results;
    module.finish(results);
    EXPECT_EQ(std::get<std::int64_t>(results.metrics.at("odometry_scans_without")), 5);
}

TEST_F(OdometryModule, odometry_that_ends_early_is_continued_but_not_far) {
    module.start({});
    odometry(0, {0, 0, 0});
    odometry(0.1, {0.1, 0, 0});
    scan(0.3);
    scan(5);
    module.drain(collector);
    ASSERT_EQ(collector.published.size(), 2u);
    EXPECT_NEAR(published_pose(0).x_m, 0.3, 1e-9);
    EXPECT_NEAR(published_pose(1).x_m, 0.6, 1e-9) << "0.1 m and half a second at 1 m/s";
}

TEST_F(OdometryModule, ticks_become_the_pose_of_the_closed_form) {
    configure("source", "ticks");
    EXPECT_FALSE(module.check().empty());
    configure("metres_per_tick_left_m", "0.001");
    configure("metres_per_tick_right_m", "0.002");
    configure("track_width_m", "0.4");
    EXPECT_TRUE(module.check().empty());
    module.start({});
    // Each step: left 100 mm, right 140 mm: forward 0.12 m, turn 0.1 rad; a circle of radius 1.2 m.
    for (int i = 0; i <= 30; ++i) {
        ticks(0.1 * i, 500 + 100 * i, -7 + 70 * i);
        scan(0.1 * i);
    }
    ASSERT_EQ(collector.published.size(), 31u);
    for (std::size_t i = 0; i <= 30; ++i) {
        const double a = 0.1 * static_cast<double>(i);
        expect_pose(published_pose(i), {1.2 * std::sin(a), 1.2 * (1 - std::cos(a)), a}, 1e-9);
        EXPECT_EQ(collector.published[i].observation->encoderLeftTicks, 500 + 100 * static_cast<int>(i));
    }
}

TEST_F(OdometryModule, ticks_asked_for_and_not_there_is_refused_with_a_sentence) {
    configure("source", "ticks");
    module.start({});
    odometry(0, {});
    scan(0);
    module.drain(collector);
    Results results;
    module.finish(results);
    ASSERT_TRUE(results.refused);
    EXPECT_NE(results.refused->find("use source = pose"), std::string::npos);
}

TEST_F(OdometryModule, takes_one_sensor_and_never_its_own_recording) {
    module.start({});
    odometry(0.0, {50, 0, 0}, "odometry_at_scan");
    odometry(0.1, {1, 0, 0}, "wheels");
    odometry(0.1, {90, 0, 0}, "visual");
    scan(0.1);
    ASSERT_EQ(collector.published.size(), 1u);
    EXPECT_NEAR(published_pose(0).x_m, 1, 1e-12);
    Results results;
    module.finish(results);
    EXPECT_EQ(std::get<std::int64_t>(results.metrics.at("odometry_ignored")), 2);
}

TEST_F(OdometryModule, a_pose_that_is_not_a_number_is_left_out) {
    module.start({});
    odometry(0.0, {0, 0, 0});
    odometry(0.1, {std::nan(""), 0, 0});
    odometry(0.2, {0.2, 0, 0});
    scan(0.1);
    ASSERT_EQ(collector.published.size(), 1u);
    EXPECT_NEAR(published_pose(0).x_m, 0.1, 1e-12);
}
