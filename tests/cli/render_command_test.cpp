/// loopline render, run as a user would.
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>

#include "support/run_program.h"

using namespace loopline;

namespace {

std::string tum_path() {
    std::string text;
    for (int i = 0; i < 30; ++i) text += std::to_string(i) + ".0 " + std::to_string(i) + " 1 0 0 0 0 1\n";
    return text;
}

/// One sentence on standard error, nothing on standard output, no picture.
void expect_error(const test::TemporaryFolder& folder, const std::vector<std::string>& arguments,
                  int exit_code, const std::string& words) {
    const auto result = test::run_loopline(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "p.png"));
}

}  // namespace

TEST(RenderCommand, draws_every_view_of_a_run_directory_at_the_asked_size) {
    const test::TemporaryFolder folder;
    folder.write("run/trajectory.tum", tum_path());
    folder.write("run/odometry.tum", tum_path());
    for (const std::string view : {"top", "axonometric", "follow", "before_after"}) {
        const auto result = test::run_loopline({"render", folder / "run", "--view", view, "--size", "333x251",
                                                "--out", folder / (view + ".png")});
        EXPECT_EQ(result.exit_code, 0) << result.err;
        EXPECT_EQ(result.err, "");
        const cv::Mat picture = cv::imread((folder / (view + ".png")).string());
        EXPECT_EQ(picture.cols, 333);
        EXPECT_EQ(picture.rows, 251);
    }
    EXPECT_EQ(test::run_loopline({"render", folder / "run", "--out", folder / "default.png"}).exit_code, 0);
    EXPECT_EQ(cv::imread((folder / "default.png").string()).cols, 1280);
}

TEST(RenderCommand, needs_no_display_and_no_environment_and_repeats_its_bytes) {
    const test::TemporaryFolder folder;
    const std::string tum = folder.write("trajectory.tum", tum_path());
    const auto draw = [&](const std::string& name, const std::vector<std::string>& environment) {
        const auto result =
            test::run_loopline({"render", tum, "--view", "axonometric", "--out", folder / name}, environment);
        EXPECT_EQ(result.exit_code, 0) << result.err;
        return test::file_text(folder / name);
    };
    const std::string first = draw("a.png", {"DISPLAY", "WAYLAND_DISPLAY", "XDG_RUNTIME_DIR", "HOME"});
    EXPECT_TRUE(first == draw("b.png", {"LC_ALL=C", "TZ=Asia/Tokyo"}));
}

TEST(RenderCommand, wrong_arguments_are_answered_with_a_sentence) {
    const test::TemporaryFolder folder;
    const std::string tum = folder.write("trajectory.tum", tum_path()), out = folder / "p.png";
    for (const std::string size : {"1280", "1280x", "x960", "1280x960x3", "0x0", "-5x100", "63x64", "64x9000",
                                   "99999999999x5", "banana", "640X480", "640x480px"})
        expect_error(folder, {"render", tum, "--size=" + size, "--out", out}, 2, "not a picture size");
    expect_error(folder, {"render", tum, "--view", "side", "--out", out}, 2,
                 "top, axonometric, follow, before_after, survey_top or survey_axonometric");
    expect_error(folder, {"render", tum, "--out", folder / "p.jpg"}, 2, "must end in .png");
    expect_error(folder, {"render", tum, "--out", folder / "nowhere/p.png"}, 2, "nowhere");
    expect_error(folder, {"render", folder / "missing", "--out", out}, 3, "There is no file or folder");
    expect_error(folder, {"render", folder.write("empty.tum", ""), "--out", out}, 3, "nothing to draw");
    expect_error(folder, {"render", folder.write("bad.ply", "ply\n"), "--out", out}, 3,
                 "ends inside its header");
    EXPECT_EQ(test::run_loopline({"render", tum}).exit_code, 2);
    EXPECT_EQ(test::run_loopline({"render"}).exit_code, 2);
}

TEST(RenderCommand, without_a_driver_plans_are_drawn_and_spatial_views_refused_with_a_sentence) {
    const test::TemporaryFolder folder;
    const std::string tum = folder.write("trajectory.tum", tum_path());
    const std::vector<std::string> no_driver{"LIBGL_DRIVERS_PATH=/nowhere"};
    EXPECT_EQ(test::run_loopline({"render", tum, "--out", folder / "top.png"}, no_driver).exit_code, 0);
    const auto result =
        test::run_loopline({"render", tum, "--view", "axonometric", "--out", folder / "p.png"}, no_driver);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.err.find("loopline: Spatial pictures can't be rendered on this machine"),
              std::string::npos)
        << result.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "p.png"));
}
