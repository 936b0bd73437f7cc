/// Pictures of corrections: a double wall becomes one, the largest are drawn, hostile ones still give a
/// picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "render/correction_view.h"
#include "render/palette.h"
#include "render/render.h"
#include "support/run_program.h"

using namespace loopline;
namespace fs = std::filesystem;

namespace {

/// A corridor of 20 m, once there and once back on the same line; on the way back it lies `apart_m` aside.
struct Corridor {
    PathCorrection correction;
    std::vector<std::vector<Eigen::Vector2f>> frame_points_base_m;

    explicit Corridor(double apart_m) {
        correction.stamp_ns = 90'000'000'000;
        correction.loop_from = 0;
        correction.loop_to = 39;
        for (int i = 0; i < 40; ++i) {
            const bool back = i >= 20;
            const Pose2 after{back ? 39.0 - i : i, 0, back ? M_PI : 0};
            correction.after.push_back(after);
            correction.before.push_back({after.x_m, after.y_m + (back ? apart_m : 0), after.phi_rad});
            auto& points_m = frame_points_base_m.emplace_back();
            for (int k = -250; k <= 250; ++k)
                for (const float side_m : {-2.f, 2.f})
                    points_m.emplace_back(0.004f * static_cast<float>(k), side_m);
        }
        correction.T_before_after = correction.before[39].inverse() * correction.after[39];
    }

    CorrectionContent content() const {
        return {correction, frame_points_base_m, "Corridor", "there and back"};
    }
};

double colour_distance(const cv::Vec3b& pixel, Colour colour) {
    return std::hypot(pixel[2] - colour.red, pixel[1] - colour.green, pixel[0] - colour.blue);
}

/// How many stripes of scan points lie one below the other in a part of a picture.
int stripes(const cv::Mat& part) {
    int count = 0;
    bool inside = false;
    for (int y = 0; y < part.rows; ++y) {
        int hits = 0;
        for (int x = 0; x < part.cols; ++x)
            hits += colour_distance(part.at<cv::Vec3b>(y, x), palette::scan_point) < 50 ||
                    colour_distance(part.at<cv::Vec3b>(y, x), palette::late_point) < 50;
        const bool is_wall = hits > part.cols / 3;
        count += is_wall && !inside;
        inside = is_wall;
    }
    return count;
}

fs::path correction_file(const std::string& name) {
    static const test::TemporaryFolder folder;
    return folder / ("correction_" + name);
}

}  // namespace

TEST(RenderCorrection, a_double_wall_becomes_one) {
    const Corridor corridor(0.3);
    const PictureSize size = correction_picture_size(corridor.content());
    const cv::Mat picture = draw_correction(corridor.content(), size);
    ASSERT_EQ(picture.rows, size.height_px);
    const int half = picture.cols / 2, lower = picture.rows / 2;
    const int lower_height = picture.rows - lower;
    EXPECT_EQ(stripes(picture({0, lower, half, lower_height})), 2) << "close-up before";
    EXPECT_EQ(stripes(picture({half, lower, half, lower_height})), 1) << "close-up after";
}

TEST(RenderCorrection, close_ups_only_where_they_are_closer) {
    const auto height_px = [](double apart_m) {
        return correction_picture_size(Corridor(apart_m).content()).height_px;
    };
    EXPECT_GT(height_px(0.3), 900);
    EXPECT_LT(height_px(8), 800) << "what is off by a third of the map is seen in the whole map";
}

TEST(RenderCorrection, misclosures_in_words_and_by_size) {
    EXPECT_EQ(misclosure_text({0.3, 0.4, 0.0227}), "0.50 m and 1.3\u00b0");
    EXPECT_EQ(misclosure_text({0.042, 0, -0.005}), "0.042 m and 0.29\u00b0");
    EXPECT_EQ(misclosure_text({-12.34, 0, M_PI}), "12.3 m and 180.0\u00b0");
    EXPECT_LT(misclosure_size_m({0.3, 0, 0}), misclosure_size_m({0.1, 0, -0.1})) << "turns count";
}

TEST(RenderCorrection, the_largest_are_drawn_under_their_numbers) {
    Results results;
    for (int i = 0; i < 15; ++i)
        results.corrections.push_back(Corridor(i == 4 ? 0.001 : i == 9 ? 0.002 : 0.3).correction);
    results.corrections[1].T_before_after.x_m = std::numeric_limits<double>::quiet_NaN();
    results.frame_points_base_m = Corridor(0).frame_points_base_m;
    const auto files = write_correction_pictures(results, 0, "Run", correction_file("many"));
    ASSERT_EQ(files.size(), most_correction_pictures);
    std::vector<std::string> names;
    for (const auto& file : files) {
        EXPECT_FALSE(cv::imread(file.string()).empty()) << file;
        names.push_back(file.filename().string());
    }
    EXPECT_EQ(names.front(), "correction_1.png");
    EXPECT_EQ(names.back(), "correction_15.png");
    for (const char* small : {"correction_2.png", "correction_5.png", "correction_10.png"})
        EXPECT_EQ(std::count(names.begin(), names.end(), small), 0) << small;
}

TEST(RenderCorrection, no_corrections_no_files) {
    EXPECT_TRUE(write_correction_pictures({}, 0, "Run", correction_file("none")).empty());
    EXPECT_FALSE(fs::exists(correction_file("none")));
}

TEST(RenderCorrection, same_correction_same_picture) {
    const Corridor corridor(0.3);
    const cv::Mat a = draw_correction(corridor.content(), {640, 700}),
                  b = draw_correction(corridor.content(), {640, 700});
    EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0);
}

TEST(RenderCorrection, hostile_content_still_gives_a_picture) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<Corridor> corridors(8, Corridor(0.3));
    corridors[0].correction = {};
    corridors[1].frame_points_base_m.clear();
    corridors[2].correction.after.resize(7);
    corridors[3].correction.loop_to = 4'000'000'000;
    corridors[4].correction.before[39].x_m = nan;
    corridors[4].correction.after[3].phi_rad = nan;
    corridors[4].frame_points_base_m[7][3].x() = std::numeric_limits<float>::infinity();
    corridors[5].correction.T_before_after = {nan, 0, nan};
    corridors[6].correction.after.assign(40, Pose2{});
    corridors[6].correction.before.assign(40, Pose2{});
    corridors[7].correction.before[0] = {1e300, -1e300, 1e9};
    for (const auto& corridor : corridors)
        for (const PictureSize size : {correction_picture_size(corridor.content()), PictureSize{64, 64},
                                       PictureSize{1000, 64}, PictureSize{303, 777}}) {
            ASSERT_TRUE(is_allowed(size));
            EXPECT_EQ(draw_correction(corridor.content(), size).cols, size.width_px);
        }
}
