/// Pictures of paths on the Earth: what they show, and charts whose curves are where their values are.
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "gnss/geo_reference.h"
#include "render/chart.h"
#include "render/earth_views.h"

using namespace loopline;

namespace {

/// A run along x whose truth is known in another frame, 3 m south of it and turned by 40 degrees.
struct EarthRun {
    Trajectory trajectory;
    SetAside<PlacedFix> fixes;
    EvaluationReference reference;
    RunRecord record;

    EarthRun() {
        const gnss::GeoReference map({49, 8.4, 100}, 0);
        const gnss::GeoReference truth_frame(map.geodetic({0, -3, 0}), 40);
        const Pose3 T_truth_map = gnss::T_between(truth_frame, map);
        auto without = std::make_shared<Trajectory>();
        Matrix6d covariance = Matrix6d::Identity() * 0.04;
        for (int i = 0; i < 200; ++i) {
            const StampNs stamp_ns = 1'000'000'000LL * i;
            const Pose3 T_map_base_true(Pose2{2.0 * i, 0, 0});
            Pose3 T_map_base(Pose2{2.0 * i + 0.1, -0.2, 0.01});
            T_map_base.translation_m.z() = 0.3;
            trajectory.append(static_cast<std::uint64_t>(i), stamp_ns, T_map_base, covariance);
            without->append(static_cast<std::uint64_t>(i), stamp_ns, Pose3(Pose2{2.0 * i, 0.05 * i, 0}), {});
            reference.truth.push_back({stamp_ns, T_truth_map * T_map_base_true});
            fixes.push_back({stamp_ns, {2.0 * i, i % 10 == 0 ? 30. : 0.5, 0}, i % 10 == 0 ? 5u : 0u});
        }
        const auto& origin = truth_frame.origin();
        reference.surveyed.earth = EarthFrame{origin.latitude_deg, origin.longitude_deg, origin.height_m, 40};
        record.trajectory = &trajectory;
        record.results.earth = EarthFrame{49, 8.4, 100, 0};
        record.results.uncorrected = NamedPath{"without fixes", without};
        record.results.fixes = {&fixes, {"used", "", "", "", "", "off_the_path"}};
    }
};

double apart_in_colour(const cv::Vec3b& pixel, Colour colour) {
    return std::hypot(pixel[2] - colour.red, pixel[1] - colour.green, pixel[0] - colour.blue);
}

std::size_t pixels_like(const cv::Mat& picture, Colour colour) {
    std::size_t count = 0;
    for (int y = 0; y < picture.rows; ++y)
        for (int x = 0; x < picture.cols; ++x)
            count += apart_in_colour(picture.at<cv::Vec3b>(y, x), colour) < 20;
    return count;
}

}  // namespace

TEST(RenderEarth, errors_are_against_a_truth_in_its_own_frame) {
    const EarthRun run;
    const auto content = earth_content(run.record, &run.reference, "Run");
    ASSERT_TRUE(content);
    EXPECT_TRUE(content->has_truth);
    ASSERT_EQ(content->moments.size(), 200u);
    EXPECT_EQ(content->fixes_used_m.size(), 180u);
    EXPECT_EQ(content->fixes_refused_m.size(), 20u);
    const EarthMoment& moment = content->moments[150];
    EXPECT_NEAR(moment.time_s, 150, 1e-9);
    EXPECT_NEAR(moment.way_m, 300, 1e-6);
    EXPECT_LT((moment.error - Eigen::Vector4d(0.1, -0.2, 0.3, 0.01)).norm(), 1e-6);
    EXPECT_LT((moment.sigma - Eigen::Vector4d::Constant(0.2)).norm(), 1e-12);
    EXPECT_NEAR(moment.height_m - moment.height_true_m, 0.3, 1e-5);
    EXPECT_NEAR(moment.height_m, 100.3 + 300 * 300 / (2 * 6.38e6), 1e-4)
        << "the Earth falls off below a level";
    EXPECT_NEAR(moment.p_uncorrected_m.y(), 7.5, 1e-12);
}

TEST(RenderEarth, without_a_truth_on_the_earth_there_are_no_errors_and_without_a_place_nothing) {
    EarthRun run;
    const auto none = earth_content(run.record, nullptr, "Run");
    ASSERT_TRUE(none);
    EXPECT_FALSE(none->has_truth);
    EXPECT_TRUE(std::isnan(none->moments[3].error.x()));
    run.reference.surveyed.earth.reset();
    EXPECT_FALSE(earth_content(run.record, &run.reference, "Run")->has_truth);
    run.record.results.earth.reset();
    EXPECT_FALSE(earth_content(run.record, &run.reference, "Run"));
}

TEST(RenderEarth, plan_and_curves_show_every_line_and_fix) {
    const EarthRun run;
    const auto content = earth_content(run.record, &run.reference, "Run");
    const cv::Mat plan = draw_earth_plan(*content, {}, {1280, 960});
    for (const Colour colour :
         {palette::estimate, palette::dead_reckoning, palette::ink, palette::start, palette::end})
        EXPECT_GT(pixels_like(plan, colour), 150u);
    const cv::Mat heights = draw_earth_heights(*content, {1280, 560});
    for (const Colour colour : {palette::estimate, palette::dead_reckoning, palette::ink})
        EXPECT_GT(pixels_like(heights, colour), 800u);
    const cv::Mat errors = draw_earth_errors(*content, {1280, 1200});
    EXPECT_GT(pixels_like(errors, palette::estimate), 2000u);
    // Small and odd ones, and those of one pose, are drawn, too.
    EarthContent single;
    single.moments.resize(1);
    single.moments[0].p_m = {0, 0, 0};
    for (const PictureSize size : {PictureSize{64, 64}, {2000, 80}, {90, 1500}})
        for (const EarthContent* some : {&*content, static_cast<const EarthContent*>(&single)}) {
            EXPECT_EQ(draw_earth_plan(*some, {}, size).cols, size.width_px);
            EXPECT_EQ(draw_earth_heights(*some, size).rows, size.height_px);
            EXPECT_EQ(draw_earth_errors(*some, size).rows, size.height_px);
        }
}

TEST(RenderChart, a_curve_is_where_its_values_are_and_breaks_where_there_are_none) {
    Figure figure({800, 400}, {});
    const Curve curve{{0, 1}, {10, 3}, {NAN, NAN}, {20, 3}, {30, -1}};
    const ChartWindow window = chart_about({curve}, figure.panel(0), 0);
    EXPECT_NEAR(window.low.y(), -1 - 0.06 * 4, 1e-12);
    EXPECT_NEAR(window.high.x(), 30, 1e-12);
    draw_curve(figure, window, curve, palette::estimate, 4);
    draw_band(figure, window, {{12, 0.5}, {18, 0.5}}, palette::end);
    const cv::Mat picture = figure.finish();
    const auto at = [&](double x, double y) {
        const Eigen::Vector2d pixel = window.pixel({x, y});
        return picture.at<cv::Vec3b>(static_cast<int>(pixel.y()), static_cast<int>(pixel.x()));
    };
    EXPECT_LT(apart_in_colour(at(5, 2), palette::estimate), 10);
    EXPECT_LT(apart_in_colour(at(25, 1), palette::estimate), 10);
    EXPECT_GT(apart_in_colour(at(15, 3), palette::estimate), 100) << "between the two parts";
    EXPECT_LT(apart_in_colour(at(15, 0.4), palette::end), 10);
    EXPECT_LT(apart_in_colour(at(15, -0.4), palette::end), 10);
    EXPECT_GT(apart_in_colour(at(15, 0.6), palette::end), 100);
    EXPECT_EQ(chart_about({}, figure.panel(0), 1).high, Eigen::Vector2d(1, 1));
}
