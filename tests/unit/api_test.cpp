/// The contract's own values: poses, stamps, parameters, trajectories, cleaned scans; and its workers.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include <atomic>
#include <limits>
#include <random>

#include "api/parameters.h"
#include "api/planar_scan.h"
#include "api/pose3.h"
#include "api/stamp.h"
#include "api/trajectory.h"
#include "api/worker_pool.h"

using namespace loopline;

TEST(Pose2, composition_and_inverse_agree_with_matrices) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> length(-9, 9), angle(-M_PI, M_PI);
    for (int i = 0; i < 200; ++i) {
        const Pose2 T_a_b{length(random), length(random), angle(random)},
            T_b_c{length(random), length(random), angle(random)};
        const Eigen::Vector2d p_c{length(random), length(random)};
        EXPECT_LT(((T_a_b * T_b_c) * p_c - T_a_b * (T_b_c * p_c)).norm(), 1e-12);
        EXPECT_LT((T_a_b.inverse() * (T_a_b * p_c) - p_c).norm(), 1e-12);
        const Pose3 spatial = Pose3(T_a_b) * Pose3(T_b_c);
        const Pose2 planar = T_a_b * T_b_c;
        EXPECT_LT((spatial.planar().translation() - planar.translation()).norm(), 1e-12);
        EXPECT_NEAR(wrap_to_pi(spatial.planar().phi_rad - planar.phi_rad), 0, 1e-12);
    }
}

TEST(Stamp, text_keeps_every_digit_both_ways) {
    for (const StampNs stamp_ns :
         {StampNs{0}, StampNs{1}, StampNs{-1}, StampNs{1137834225973760001}, StampNs{-1500000000}})
        EXPECT_EQ(stamp_from_seconds_text(seconds_text(stamp_ns)), stamp_ns);
    EXPECT_EQ(seconds_text(1137834225973760000), "1137834225.973760000");
    EXPECT_EQ(stamp_from_seconds_text("12"), 12'000'000'000);
    for (const char* bad : {"", "-", ".", "1e9", "12 ", "x", "99999999999999"})
        EXPECT_FALSE(stamp_from_seconds_text(bad)) << bad;
}

TEST(Stamp, mrpt_clock_round_trip_and_invalid) {
    const StampNs stamp_ns = 1137834225973760000;
    EXPECT_EQ(stamp_from_mrpt(stamp_to_mrpt(stamp_ns)), stamp_ns);
    EXPECT_FALSE(stamp_from_mrpt(INVALID_TIMESTAMP));
}

TEST(ParameterTable, one_declaration_reads_checks_and_prints) {
    double sigma_m = 0.02, gate_rad = M_PI / 6;
    int count = 3;
    bool on = true;
    enum class Update { joint, paper_sum } update = Update::joint;
    ParameterTable table("line_slam", "test");
    table.real("sigma_range_m", sigma_m, {0, 1}, "Range noise.")
        .angle("gate_deg", gate_rad, {0, 90}, "Gate.")
        .integer("count", count, Range::at_least(1), "Count.")
        .boolean("on", on, "Switch.")
        .choice("update", update, {{"joint", Update::joint}, {"paper_sum", Update::paper_sum}}, "Form.");

    EXPECT_EQ(table.find("sigma_range_m")->unit, "m");
    EXPECT_EQ(table.find("gate_deg")->default_text, "30");
    EXPECT_EQ(table.find("update")->allowed, "joint | paper_sum");
    EXPECT_FALSE(table.find("sigma_range_m")->parse("0.5"));
    EXPECT_DOUBLE_EQ(sigma_m, 0.5);
    EXPECT_FALSE(table.find("gate_deg")->parse("45"));
    EXPECT_NEAR(gate_rad, M_PI / 4, 1e-15);
    EXPECT_FALSE(table.find("update")->parse("paper_sum"));
    EXPECT_EQ(update, Update::paper_sum);
    for (const char* bad : {"banana", "", "nan", "inf", "1.5", "-0.1", "0.5 m", "0,5"})
        EXPECT_TRUE(table.find("sigma_range_m")->parse(bad)) << bad;
    EXPECT_TRUE(table.find("count")->parse("0"));
    EXPECT_TRUE(table.find("count")->parse("2.5"));
    EXPECT_TRUE(table.find("on")->parse("maybe"));
    EXPECT_TRUE(table.find("update")->parse("paper"));
    EXPECT_DOUBLE_EQ(sigma_m, 0.5) << "a refused value must not be stored";
}

TEST(Trajectory, keeps_the_online_estimate_and_interpolates_the_latest) {
    Trajectory path;
    for (std::uint64_t i = 0; i < 5; ++i)
        path.append(10 * i, static_cast<StampNs>(i) * 1000, Pose3(Pose2{double(i), 0, 0}),
                    Matrix6d::Identity());
    path.revise(2, Pose3(Pose2{2, 1, 0}), Matrix6d::Zero());
    path.finish_revision();
    EXPECT_EQ(path.revision(), 1u);
    EXPECT_DOUBLE_EQ(path.T_map_base_online(2).translation_m.y(), 0);
    EXPECT_DOUBLE_EQ(path.find(20)->T_map_base.translation_m.y(), 1);
    EXPECT_FALSE(path.find(21));
    EXPECT_NEAR(path.pose_at(1500, 20)->translation_m.y(), 0.5, 1e-12);
    EXPECT_NEAR(path.pose_at(1500, 0)->translation_m.y(), 0.5, 1e-12);
    EXPECT_FALSE(path.pose_at(4001, 40));
}

TEST(PlanarScan, unusable_returns_become_zero_and_clockwise_is_turned_round) {
    mrpt::obs::CObservation2DRangeScan observation;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float ranges[] = {1, nan, 0, -1, std::numeric_limits<float>::infinity(), 80, 3};
    const char valid[] = {1, 1, 1, 1, 1, 1, 0};
    observation.aperture = static_cast<float>(M_PI);
    observation.maxRange = 80;
    observation.rightToLeft = false;
    observation.loadFromVectors(7, ranges, valid);
    PlanarScan scan;
    ASSERT_TRUE(to_planar_scan(observation, scan));
    EXPECT_EQ(scan.returns(), 1u);
    EXPECT_FLOAT_EQ(scan.ranges_m[6], 1);
    EXPECT_NEAR(scan.angle_rad(6), M_PI / 2, 1e-6);
    observation.aperture = nan;
    EXPECT_FALSE(to_planar_scan(observation, scan));
    EXPECT_EQ(scan.size(), 0u);
}

TEST(WorkerPool, runs_each_task_once) {
    for (const int threads : {1, 2, 5}) {
        WorkerPool workers(threads);
        for (int round = 0; round < 200; ++round) {
            std::vector<std::atomic<int>> runs(7);
            workers.run(runs.size(), [&](std::size_t k) { ++runs[k]; });
            for (const auto& count : runs) EXPECT_EQ(count, 1);
        }
    }
}
