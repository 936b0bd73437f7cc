/// Pictures: size, content where it belongs, scale, odd sizes, hostile content.
#include <gtest/gtest.h>
#include <mrpt/opengl/COpenGLScene.h>

#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "commands/command.h"
#include "render/canvas.h"
#include "render/content_bounds.h"
#include "render/figure.h"
#include "render/offscreen.h"
#include "render/plan_views.h"
#include "render/render.h"
#include "render/scale.h"
#include "render/spatial_scene.h"
#include "render/spatial_views.h"
#include "render/view_camera.h"
#include "support/run_program.h"

using namespace loopline;

namespace {

std::filesystem::path scratch(const std::string& name) {
    static const test::TemporaryFolder folder;
    return folder / name;
}

MapLine wall(double x0, double y0, double x1, double y1) {
    MapLine line;
    line.start_m = {x0, y0};
    line.end_m = {x1, y1};
    return line;
}

/// A square room of 10 m, a path through it, points on its walls.
SceneContent room() {
    SceneContent content;
    content.title = "Room";
    content.lines = LineMap{wall(0, 0, 10, 0), wall(10, 0, 10, 10), wall(10, 10, 0, 10), wall(0, 10, 0, 0)};
    for (int i = 0; i <= 40; ++i) {
        content.estimated_path.emplace_back(Pose2{2 + 0.1 * i, 3, 0});
        content.odometry_path.emplace_back(Pose2{2 + 0.1 * i, 3 + 0.02 * i, 0});
    }
    for (int i = 0; i < 200; ++i) {
        content.points_m.emplace_back(0.05f * static_cast<float>(i), 0.f, 0.f);
        content.points_odometry_m.emplace_back(0.05f * static_cast<float>(i), 0.01f * static_cast<float>(i),
                                               0.f);
    }
    return content;
}

double distance(const cv::Vec3b& pixel, Colour colour) {
    return std::hypot(pixel[2] - colour.red, pixel[1] - colour.green, pixel[0] - colour.blue);
}

/// The window that draw_top_view() uses, from the same layout.
MapWindow top_window(const SceneContent& content, const cv::Mat& picture) {
    // The panel's frame: the outermost column and row of frame colour.
    int left = -1, right = -1, top = -1, bottom = -1;
    for (int x = 0; x < picture.cols; ++x) {
        int count = 0;
        for (int y = 0; y < picture.rows; ++y)
            count += distance(picture.at<cv::Vec3b>(y, x), palette::frame) < 60;
        if (count > picture.rows * 6 / 10) {
            if (left < 0) left = x;
            right = x;
        }
    }
    for (int y = 0; y < picture.rows; ++y) {
        int count = 0;
        for (int x = 0; x < picture.cols; ++x)
            count += distance(picture.at<cv::Vec3b>(y, x), palette::frame) < 60;
        if (count > picture.cols * 6 / 10) {
            if (top < 0) top = y;
            bottom = y;
        }
    }
    EXPECT_GE(left, 0);
    EXPECT_GE(top, 0);
    return fitting_window(bounds_of(content),
                          {double(left), double(top), double(right - left), double(bottom - top)});
}

}  // namespace

TEST(RenderScale, round_numbers_and_texts) {
    EXPECT_DOUBLE_EQ(round_number_below(9.99), 5);
    EXPECT_DOUBLE_EQ(round_number_below(10), 10);
    EXPECT_DOUBLE_EQ(round_number_below(0.3), 0.2);
    EXPECT_DOUBLE_EQ(round_number_below(0.5), 0.5);
    EXPECT_DOUBLE_EQ(round_number_below(2047), 2000);
    EXPECT_EQ(length_text(0.2), "20 cm");
    EXPECT_EQ(length_text(5), "5 m");
    EXPECT_EQ(length_text(2000), "2 km");
    EXPECT_EQ(length_text(0.005), "5 mm");
    EXPECT_EQ(tick_text(-20, 10), "\u221220");
    EXPECT_EQ(tick_text(-1e-17, 0.1), "0.0");
    EXPECT_EQ(tick_text(0.25, 0.05), "0.25");
}

TEST(RenderScale, ticks_are_round_inside_and_few) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> exponent(-4, 6), place(-1, 1);
    for (int i = 0; i < 500; ++i) {
        const double span = std::pow(10, exponent(random)), low = place(random) * 3 * span;
        double step = 0;
        const auto values = ticks(low, low + span, 8, step);
        ASSERT_GE(values.size(), 2u) << low << " " << span;
        ASSERT_LE(values.size(), 9u) << low << " " << span;
        EXPECT_NEAR(round_number_below(step), step, 1e-9 * step);
        for (const double value : values) {
            EXPECT_GE(value, low - 1e-6 * step);
            EXPECT_LE(value, low + span + 1e-6 * step);
            EXPECT_NEAR(std::remainder(value, step), 0, 1e-6 * step);
        }
    }
}

TEST(RenderCanvas, shapes_lie_at_their_sub_pixel_place) {
    Canvas canvas(40, 20, palette::paper);
    canvas.polyline({{10, 0}, {10, 20}}, 4, palette::wall);
    const cv::Mat picture = canvas.finish();
    // 4 px wide and centred on x = 10; OpenCV's soft edges add up to 0.4 px on either side.
    double sum = 0, moment = 0;
    for (int x = 0; x < 40; ++x) {
        const double ink = 255 - picture.at<cv::Vec3b>(10, x)[1];
        sum += ink;
        moment += ink * (x + 0.5);
    }
    EXPECT_NEAR(moment / sum, 10, 0.3);
    EXPECT_NEAR(sum / (255 - palette::wall.green), 4, 0.8);
}

TEST(RenderCanvas, thinning_keeps_the_shape) {
    Pixels path;
    for (int i = 0; i < 10000; ++i) path.push_back({i * 0.01, std::sin(i * 0.001) * 50});
    path[5000].x() = std::numeric_limits<double>::quiet_NaN();
    const Pixels kept = thinned(path, 0.5);
    EXPECT_LT(kept.size(), 700u);
    EXPECT_EQ(kept.front(), path.front());
    EXPECT_EQ(kept.back(), path.back());
    for (const auto& p : path) {
        if (!p.allFinite()) continue;
        double nearest = 1e9;
        for (const auto& k : kept) nearest = std::min(nearest, (p - k).norm());
        EXPECT_LT(nearest, 0.5);
    }
}

TEST(RenderTopView, walls_and_path_are_where_the_projection_says) {
    const SceneContent content = room();
    const cv::Mat picture = draw_top_view(content, {1280, 960});
    ASSERT_EQ(picture.cols, 1280);
    ASSERT_EQ(picture.rows, 960);
    const MapWindow window = top_window(content, picture);
    const auto at = [&](double x_m, double y_m) {
        const Eigen::Vector2d p = window.pixel({x_m, y_m});
        return picture.at<cv::Vec3b>(static_cast<int>(p.y()), static_cast<int>(p.x()));
    };
    EXPECT_LT(distance(at(5, 10), palette::wall), 40);
    EXPECT_LT(distance(at(10, 7), palette::wall), 40);
    EXPECT_LT(distance(at(0, 7.3), palette::wall), 40);
    EXPECT_LT(distance(at(4.1, 3), palette::estimate), 40);
    EXPECT_LT(distance(at(6, 3.8), palette::dead_reckoning), 40);
    EXPECT_LT(distance(at(5, 8.3), palette::paper), 40) << "empty floor";
    const double off_m = 6 / window.px_per_m;
    EXPECT_GT(distance(at(5, 10 - off_m), palette::wall), 200) << "the wall is thin";
}

TEST(RenderFigure, scale_bar_has_the_length_it_says) {
    for (const double px_per_m : {0.031, 3.7, 88.0, 1234.0}) {
        Figure figure({1280, 960}, {});
        figure.scale_bar(px_per_m);
        const cv::Mat picture = figure.finish();
        // The longest run of dark pixels in a row of the strip is the bar.
        int longest = 0;
        for (int y = picture.rows * 9 / 10; y < picture.rows; ++y)
            for (int x = 0, run = 0; x < picture.cols; ++x) {
                run = distance(picture.at<cv::Vec3b>(y, x), palette::ink) < 90 ? run + 1 : 0;
                longest = std::max(longest, run);
            }
        const double length_m = longest / px_per_m, round_m = round_number_below(length_m * 1.02);
        EXPECT_NEAR(longest, round_m * px_per_m, 1.5) << length_text(round_m);
        EXPECT_GT(longest, 30);
    }
}

TEST(RenderPicture, every_view_and_size_has_its_size_and_is_not_blank) {
    const SceneContent content = room();
    for (const auto& [width, height] : {std::pair{320, 240},
                                        {321, 241},
                                        {1280, 960},
                                        {303, 777},
                                        {1023, 333},
                                        {64, 64},
                                        {67, 91},
                                        {1000, 64}})
        for (const View view : {View::top, View::axonometric, View::follow, View::before_after}) {
            const auto file = scratch("view.png");
            render_picture(content, view, {width, height}, file);
            const cv::Mat picture = cv::imread(file.string());
            ASSERT_EQ(picture.cols, width);
            ASSERT_EQ(picture.rows, height);
            cv::Scalar mean, deviation;
            cv::meanStdDev(picture, mean, deviation);
            EXPECT_GT(deviation[1], 4) << width << "x" << height << " view " << static_cast<int>(view);
        }
}

TEST(RenderPicture, same_content_same_bytes) {
    const SceneContent content = room();
    for (const View view : {View::top, View::axonometric, View::before_after}) {
        render_picture(content, view, {641, 480}, scratch("a.png"));
        // Another size in between changes what the off-screen buffer holds.
        if (view == View::axonometric) render_picture(content, view, {900, 700}, scratch("c.png"));
        render_picture(content, view, {641, 480}, scratch("b.png"));
        EXPECT_TRUE(test::file_text(scratch("a.png")) == test::file_text(scratch("b.png")))
            << static_cast<int>(view);
    }
}

TEST(RenderPicture, hostile_content_still_gives_a_picture) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    std::vector<SceneContent> contents(6);
    contents[1].estimated_path = {Pose3(Pose2{3, 4, 1})};
    contents[2] = room();
    contents[2].points_m.emplace_back(nan, 1.f, 1.f);
    contents[2].points_m.emplace_back(inf, -inf, 1e30f);
    contents[2].lines->push_back(wall(nan, 0, 1, 1));
    contents[2].lines->push_back(wall(1, 1, 1, 1));
    contents[2].estimated_path.emplace_back(Pose2{nan, inf, 0});
    contents[3].grid = mrpt::maps::COccupancyGridMap2D::Create(0.f, 2.f, 0.f, 2.f, 0.1f);
    for (int i = 0; i <= 500; ++i)
        contents[4].estimated_path.emplace_back(Pose2{10.0 * i, 2000 * std::sin(i * 0.01), 0});
    contents[4].title = std::string(3000, 'W') + "\xff\xfe \u00e4\n";
    contents[5].points_m.assign(1, Eigen::Vector3f(1e6f, -1e6f, 3.f));
    for (const auto& content : contents)
        for (const View view : {View::top, View::axonometric, View::follow, View::before_after}) {
            render_picture(content, view, {320, 240}, scratch("hostile.png"));
            EXPECT_EQ(cv::imread(scratch("hostile.png").string()).cols, 320);
        }
}

TEST(RenderSpatial, a_corner_of_a_wall_falls_where_the_camera_says) {
    // One marker, far from everything symmetric, in both projections and in shapes that crop the buffer
    // differently.
    const Eigen::Vector3d marker_m(3, 7, 1.5);
    for (const auto& [width, height] : {std::pair{800, 600}, {301, 517}, {640, 200}})
        for (const bool parallel : {true, false}) {
            ViewCamera camera;
            camera.target_m = {1, 6, 0.5};
            camera.azimuth_deg = -65;
            camera.elevation_deg = 40;
            camera.parallel = parallel;
            camera.distance_m = 15;
            camera.visible_height_m = 9;
            camera.near_m = 2;
            camera.far_m = 60;
            SceneContent content;
            content.points_m = {marker_m.cast<float>()};
            SceneSizes sizes;
            sizes.point_px = 12;
            auto scene = make_spatial_scene(content, sizes);
            const cv::Mat picture = render_offscreen(*scene, camera, width, height);
            double sum = 0;
            Eigen::Vector2d moment = Eigen::Vector2d::Zero();
            for (int y = 0; y < picture.rows; ++y)
                for (int x = 0; x < picture.cols; ++x)
                    if (distance(picture.at<cv::Vec3b>(y, x), palette::scan_point) < 20) {
                        sum += 1;
                        moment += Eigen::Vector2d(x + 0.5, y + 0.5);
                    }
            ASSERT_GT(sum, 4) << width << "x" << height << (parallel ? " parallel" : " perspective");
            const Eigen::Vector2d expected = camera.pixel(marker_m, width, height);
            EXPECT_NEAR((moment / sum - expected).norm(), 0, 1.0)
                << width << "x" << height << (parallel ? " parallel" : " perspective");
        }
}

TEST(RenderSpatial, a_near_wall_hides_what_is_behind_it) {
    SceneContent content;
    content.lines = LineMap{wall(-3, 0, 3, 0)};
    content.points_m.assign(1, Eigen::Vector3f(0.f, 0.6f, 0.3f));  // 0.6 m behind a wall of 2 m
    SceneSizes sizes;
    sizes.point_px = 12;
    ViewCamera camera;
    camera.azimuth_deg = -90;
    camera.elevation_deg = 20;
    camera.distance_m = 12;
    camera.near_m = 1;
    camera.far_m = 40;
    const auto blue_pixels = [&] {
        const cv::Mat picture = render_offscreen(*make_spatial_scene(content, sizes), camera, 400, 300);
        int count = 0;
        for (int y = 0; y < picture.rows; ++y)
            for (int x = 0; x < picture.cols; ++x)
                count += distance(picture.at<cv::Vec3b>(y, x), palette::scan_point) < 20;
        return count;
    };
    EXPECT_EQ(blue_pixels(), 0);
    camera.azimuth_deg = 90;
    EXPECT_GT(blue_pixels(), 10);
}

TEST(RenderSpatial, thinning_points_keeps_their_spread) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<float> place(-50, 50);
    std::vector<Eigen::Vector3f> points_m;
    for (int i = 0; i < 300'000; ++i)
        points_m.emplace_back(place(random), place(random), 0.01f * place(random));
    const auto kept = thinned_points(points_m, 20'000);
    EXPECT_LE(kept.size(), 20'000u);
    EXPECT_GT(kept.size(), 5'000u);
    // Every 10 m square keeps about its share.
    int squares[10][10] = {};
    for (const auto& p : kept)
        ++squares[std::min(9, int((p.x() + 50) / 10))][std::min(9, int((p.y() + 50) / 10))];
    for (const auto& row : squares)
        for (const int count : row) EXPECT_GT(count, static_cast<int>(kept.size()) / 200);
    EXPECT_EQ(thinned_points(kept, 20'000).size(), kept.size()) << "few points are all kept";
}

TEST(RenderSpatial, three_million_points_are_drawn_as_a_density) {
    SceneContent content;
    std::mt19937_64 random(9);
    std::normal_distribution<float> spread(0, 20);
    content.points_m.reserve(3'000'000);
    for (int i = 0; i < 3'000'000; ++i) content.points_m.emplace_back(spread(random), spread(random), 0.f);
    const cv::Mat picture = draw_top_view(content, {640, 480});
    const auto darkness = [&](double share_of_width) {
        const cv::Rect patch(static_cast<int>(share_of_width * picture.cols), picture.rows / 2, 9, 9);
        return 255 - cv::mean(picture(patch))[2];
    };
    EXPECT_GT(darkness(0.53), darkness(0.85) + 20) << "denser is darker";
    EXPECT_GT(darkness(0.85), 5) << "thin parts are seen";
}

TEST(Render3dScene, file_reloads_with_its_objects) {
    const auto file = scratch("room.3Dscene");
    write_3d_scene(room(), file);
    const std::string head = test::file_text(file).substr(0, 2);
    EXPECT_EQ(head, "\x1f\x8b") << "compressed";
    mrpt::opengl::COpenGLScene scene;
    ASSERT_TRUE(scene.loadFromFile(file.string()));
    for (const char* name :
         {"walls", "scan points", "estimated path", "dead reckoning", "start and end", "ground grid"})
        EXPECT_TRUE(scene.getByName(name)) << name;
    EXPECT_THROW(write_3d_scene(room(), "/nowhere/at/all.3Dscene"), CommandError);
}
