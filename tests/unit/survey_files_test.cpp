/// Survey clouds on their way to files and pictures, and back.
#include <gtest/gtest.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include <opencv2/imgcodecs.hpp>
#include <random>

#include "output/map_files.h"
#include "render/cloud_splat.h"
#include "render/render.h"
#include "support/points_in.h"
#include "support/run_program.h"

using namespace loopline;

namespace {

mrpt::maps::CSimplePointsMap::Ptr cloud_of(const std::vector<Eigen::Vector3f>& points) {
    auto cloud = mrpt::maps::CSimplePointsMap::Create();
    for (const auto& p : points) cloud->insertPointFast(p.x(), p.y(), p.z());
    return cloud;
}

/// Floor, ceiling at 2.5 m and four walls of a room of 8 m x 4 m.
std::vector<Eigen::Vector3f> room_points(bool with_ceiling) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<float> u(0, 1);
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < 20000; ++i) {
        const float a = u(random), b = u(random);
        points.emplace_back(8 * a, 4 * b, 0.0f);
        if (with_ceiling) points.emplace_back(8 * a, 4 * b, 2.5f);
        points.emplace_back(8 * a, i % 2 ? 0.0f : 4.0f, 2.5f * b);
        points.emplace_back(i % 2 ? 0.0f : 8.0f, 4 * a, 2.5f * b);
    }
    return points;
}

Results survey_results(const std::vector<Eigen::Vector3f>& points) {
    Results results;
    NamedMap map{"survey", cloud_of(points)};
    map.survey = true;
    results.maps.push_back(map);
    return results;
}

}  // namespace

TEST(SurveyFiles, clouds_come_back_from_ply_and_pcd_bit_for_bit) {
    const test::TemporaryFolder folder;
    const auto points = room_points(true);
    std::vector<Eigen::Vector3f> moved = points;
    for (auto& p : moved) p.x() += 1;
    FileList list;
    Results results = survey_results(points);
    results.maps.push_back({"points", cloud_of({{1, 2, 3}})});
    write_map_files(folder.path(), results, list);
    write_odometry_points(folder.path(), survey_results(moved), list);
    const std::vector<std::string> expected = {"map.points.ply",          "map.points.pcd",
                                               "map.survey.ply",          "map.survey.pcd",
                                               "map.survey_odometry.ply", "map.survey_odometry.pcd"};
    EXPECT_EQ(list.files, expected);
    EXPECT_EQ(test::points_in(folder / "map.survey.ply"), points);
    EXPECT_EQ(test::points_in(folder / "map.survey.pcd"), points);
    EXPECT_EQ(test::points_in(folder / "map.survey_odometry.ply"), moved);

    const SceneContent content = scene_from_path(folder.path());
    EXPECT_EQ(content.points_m.size(), 1u) << "a survey is no part of the plan's points";
    ASSERT_EQ(content.surveys.size(), 1u);
    EXPECT_EQ(content.surveys[0].corrected->size(), points.size());
    EXPECT_EQ(content.surveys[0].raw->size(), points.size());
}

TEST(SurveyPictures, a_ceiling_is_taken_off_and_a_room_without_one_stays_whole) {
    const auto closed = height_colours(PointsInMemory(room_points(true)));
    EXPECT_LT(closed.cut_m, 2.45);
    EXPECT_GT(closed.cut_m, 2.2);
    EXPECT_NEAR(closed.lowest_m, 0, 0.01);
    const auto open = height_colours(PointsInMemory(room_points(false)));
    EXPECT_TRUE(std::isinf(open.cut_m));
    EXPECT_NEAR(open.highest_m, 2.5, 0.02);
}

TEST(SurveyPictures, the_nearest_point_is_seen_and_depth_is_returned) {
    cv::Mat picture(20, 20, CV_8UC3, cv::Scalar(255, 255, 255));
    ParallelView view;  // one pixel a metre, seen from above
    const PointsInMemory cloud({{5, 5, 0}, {5, 5, 1}, {5, 5, 0.5f}, {12, 12, 0}, {50, 50, 0}});
    const auto depth = splat_cloud(picture, cloud, view, {0, 1, INFINITY});
    EXPECT_EQ(depth(5, 5), 1);
    EXPECT_EQ(depth(12, 12), 0);
    EXPECT_TRUE(std::isinf(depth(0, 0)));
    const Colour high = palette::height(1), low = palette::height(0);
    EXPECT_EQ(picture.at<cv::Vec3b>(5, 5), cv::Vec3b(high.blue, high.green, high.red));
    EXPECT_EQ(picture.at<cv::Vec3b>(12, 12), cv::Vec3b(low.blue, low.green, low.red));
    EXPECT_EQ(picture.at<cv::Vec3b>(0, 0), cv::Vec3b(255, 255, 255));
    // With a cut, what is above it is not there.
    const auto cut = splat_cloud(picture, cloud, view, {0, 1, 0.7});
    EXPECT_EQ(cut(5, 5), 0.5f);
}

TEST(SurveyPictures, both_views_are_drawn_of_full_half_and_empty_content) {
    const test::TemporaryFolder folder;
    SceneContent content;
    content.title = "room";
    const auto draw = [&](View view) {
        render_picture(content, view, {640, 480}, folder / "p.png");
        return cv::imread((folder / "p.png").string());
    };
    for (const View view : {View::survey_top, View::survey_axonometric}) {
        content.surveys.clear();
        const cv::Mat empty = draw(view);
        content.surveys.push_back({"survey", cloud_of(room_points(true)), nullptr});
        const cv::Mat half = draw(view);
        content.surveys[0].raw = cloud_of(room_points(true));
        const cv::Mat full = draw(view);
        EXPECT_EQ(full.size(), cv::Size(640, 480));
        EXPECT_GT(cv::norm(full, half, cv::NORM_L1), 0);
        EXPECT_GT(cv::norm(half, empty, cv::NORM_L1), 0);
    }
}
