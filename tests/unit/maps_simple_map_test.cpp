/// The map of keyframes: which scans, with which pose and covariance.
#include <gtest/gtest.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include "api/mrpt_pose.h"
#include "maps/simple_map_module.h"
#include "maps_test_support.h"

using namespace loopline;
using namespace maps_test;
using mrpt::maps::CSimpleMap;

namespace {

CSimpleMap::Ptr draw_keyframes(const std::vector<StreamItem>& items, const Trajectory& trajectory,
                               Results& results,
                               const std::vector<std::pair<std::string, std::string>>& settings = {}) {
    SimpleMapBuilder builder;
    for (const auto& [key, value] : settings) set(builder, key, value);
    builder.start({}, trajectory);
    for (const auto& item : items) builder.insert(item);
    builder.finish(results);
    return only_map<CSimpleMap>(results);
}

std::vector<double> keyframe_x(const CSimpleMap& map) {
    std::vector<double> x;
    for (std::size_t i = 0; i < map.size(); ++i) x.push_back(map.getAsPair(i).pose->getMeanVal().x());
    return x;
}

}  // namespace

TEST(MapsSimpleMap, keyframes_by_distance_and_by_angle_for_every_sensor) {
    Trajectory trajectory;
    std::vector<StreamItem> items;
    const double x[] = {0, 0.4, 1.0, 1.5, 2.1, 2.2, 2.3}, phi[] = {0, 0, 0, 0, 0, 0.6, 0.7};
    for (std::uint64_t i = 0; i < 7; ++i) {
        trajectory.append(i, 0, Pose3(Pose2{x[i], 0, phi[i]}), Matrix6d::Identity());
        items.push_back(item_of(i, scan_of({1, 2, 3}, M_PI)));
    }
    auto second_sensor = scan_of({1, 2, 3}, M_PI);
    second_sensor->sensorLabel = "REAR";
    items.back().observation = second_sensor;
    Results results, all;
    const auto map = draw_keyframes(items, trajectory, results, {{"distance_m", "1"}, {"angle_deg", "30"}});
    EXPECT_EQ(keyframe_x(*map), (std::vector<double>{0, 1.0, 2.1, 2.2, 2.3}));
    EXPECT_EQ(std::get<std::int64_t>(results.metrics.at("keyframes")), 5);
    EXPECT_EQ(draw_keyframes(items, trajectory, all, {{"distance_m", "0"}})->size(), 7u);
}

TEST(MapsSimpleMap, covariance_is_in_mrpts_order_and_the_scan_is_whole) {
    Matrix6d covariance = Matrix6d::Zero();
    for (int i = 0; i < 6; ++i) covariance(i, i) = i + 1;
    covariance(0, 5) = covariance(5, 0) = 0.25;  // x with yaw
    covariance(1, 3) = covariance(3, 1) = 0.5;   // y with roll
    const mrpt::poses::CPose3D T_map_base(1, 2, 3, 0.3, 0.2, -0.1);
    Trajectory trajectory;
    trajectory.append(4, 0, pose3_from_mrpt(T_map_base), covariance);
    const auto scan = scan_of({1, 2, 3}, M_PI, {0.1, 0, 0.5, 0, 0, 0});
    Results results;
    const auto map = draw_keyframes({item_of(4, scan), item_of(5, scan)}, trajectory, results);
    ASSERT_EQ(map->size(), 1u);
    const auto pair = map->getAsPair(0);
    const auto pdf = std::dynamic_pointer_cast<mrpt::poses::CPose3DPDFGaussian>(pair.pose);
    ASSERT_TRUE(pdf);
    EXPECT_LT((pdf->mean.asVectorVal() - T_map_base.asVectorVal()).norm(), 1e-12);
    const double diagonal[] = {1, 2, 3, 6, 5, 4};
    for (int i = 0; i < 6; ++i) EXPECT_EQ(pdf->cov(i, i), diagonal[i]);
    EXPECT_EQ(pdf->cov(0, 3), 0.25);
    EXPECT_EQ(pdf->cov(1, 5), 0.5);
    const auto kept = pair.sf->getObservationByClass<mrpt::obs::CObservation2DRangeScan>();
    ASSERT_TRUE(kept);
    EXPECT_NE(kept.get(), scan.get());
    EXPECT_EQ(kept->getScanRange(2), 3.0f);
    EXPECT_EQ(kept->sensorPose, scan->sensorPose);
}

TEST(MapsSimpleMap, the_limit_holds_and_what_it_cost_is_told) {
    Trajectory trajectory;
    std::vector<StreamItem> items;
    for (std::uint64_t i = 0; i < 9; ++i) {
        trajectory.append(i, 0, Pose3(Pose2{static_cast<double>(i), 0, 0}), Matrix6d::Identity());
        items.push_back(item_of(i, scan_of({1, 2, 3}, M_PI)));
    }
    Results results;
    EXPECT_EQ(draw_keyframes(items, trajectory, results, {{"max_keyframes", "4"}})->size(), 4u);
    EXPECT_EQ(std::get<std::int64_t>(results.metrics.at("keyframes_left_out")), 5);
}
