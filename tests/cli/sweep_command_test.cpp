/// loopline sweep as a user runs it, and the survey of a simulated room from end to end.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/run_program.h"

using loopline::test::file_text;
using loopline::test::run_loopline;
using loopline::test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

/// Some metres of a corridor with two door jambs; the wheels slip a little.
const char* const scenario = R"([simulation]
seed = 1
sensors = commands wheels horizontal_laser survey_laser
[world]
height_m = 2.6
wall_m = -2 -1.2  9 -1.2  9 1.4  -2 1.4  -2 -1.2
door_m = 3 1.4  4 1.4  0.4
point_m = 1 3 1.4
point_m = 2 9 -1.2
[route]
waypoint_m = 0 0
waypoint_m = 6 0
[vehicle]
track_width_m = 0.4
straight_mps = 0.3
[survey_laser]
sweep_s = 5
)";

std::string scenario_ini(const TemporaryFolder& folder) {
    return folder.write("room.ini", scenario);
}

std::vector<std::string> lines_of(const fs::path& file) {
    std::istringstream in(file_text(file));
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

}  // namespace

TEST(SweepCommand, every_combination_on_every_seed_in_one_table) {
    const TemporaryFolder folder;
    const std::string config = folder.write("odometry.ini", "[run]\nmodules = odometry\n");
    const auto result = run_loopline({"sweep", config, "--scenario", scenario_ini(folder), "--seeds", "1-2",
                                      "--vary", "odometry.noise_along_m=0.01,0.02", "--metric", "scans_read",
                                      "--metric", "points_mean_error_m", "--out", (folder / "out").string()});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NE(result.out.find("| noise_along_m | runs | scans_read: mean / median / worst |"),
              std::string::npos)
        << result.out;
    const auto runs = lines_of(folder / "out/runs.csv");
    ASSERT_EQ(runs.size(), 5u);
    EXPECT_EQ(runs[0], "odometry.noise_along_m,log,exit_code,scans_read,points_mean_error_m");
    EXPECT_EQ(runs[1].substr(0, 13), "0.01,seed1,0,");
    EXPECT_EQ(runs[4].substr(0, 13), "0.02,seed2,0,");
    EXPECT_EQ(runs[1].substr(5), runs[3].substr(5)) << "this key changes no figure";
    EXPECT_NE(runs[1].substr(5), runs[2].substr(5));
    EXPECT_NE(file_text(folder / "out/sweep.md").find("`loopline sweep "), std::string::npos);
    EXPECT_EQ(lines_of(folder / "out/sweep.csv").size(), 3u);
    EXPECT_FALSE(fs::exists(folder / "out/runs/0001/trajectory.tum"))
        << "only figures, unless asked for more";
}

TEST(SweepCommand, a_wrong_key_ends_it_at_once_with_the_sentence_of_run) {
    const TemporaryFolder folder;
    const std::string config = folder.write("odometry.ini", "[run]\nmodules = odometry\n");
    const std::string log = folder.write("no.rawlog", "x");
    const auto result = run_loopline({"sweep", config, "--rawlog", log, "--vary",
                                      "odometry.noise_alnog_m=1,2", "--out", (folder / "out").string()});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.err.find("noise_along_m"), std::string::npos) << result.err;
    EXPECT_FALSE(fs::exists(folder / "out/runs/0002.txt"));
    EXPECT_EQ(run_loopline({"sweep", config, "--vary", "x", "--out", (folder / "o").string()}).exit_code, 2);
    EXPECT_EQ(run_loopline({"sweep", config, "--seeds", "9-1", "--out", (folder / "o").string()}).exit_code,
              2);
}

TEST(SurveyRun, a_simulated_corridor_its_points_its_cloud_and_its_pictures) {
    const TemporaryFolder folder;
    const std::string log = (folder / "room.rawlog").string();
    ASSERT_EQ(run_loopline({"simulate", scenario_ini(folder), "--out", log, "--quiet"}).exit_code, 0);
    const std::string config = folder.write(
        "survey.ini",
        "[run]\nmodules = odometry lines line_slam\nmaps = survey\n[lines]\nsensors = horizontal_laser\n"
        "[line_slam]\ntrack_width_m = 0.4\n[evaluation]\nscan_duration_s = 0.0135135\n"
        "[survey]\nsensors = survey_laser\nscan_duration_s = 0.0320513\n");
    const auto result =
        run_loopline({"run", config, "--rawlog", log, "--out", (folder / "run").string(), "--quiet"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    const auto rows = lines_of(folder / "run/feature_points.csv");
    ASSERT_EQ(rows.size(), 3u) << "the truth beside the log is found";
    EXPECT_EQ(rows[0], "number,true_x_m,true_y_m,odometry_x_m,odometry_y_m,estimate_x_m,estimate_y_m");
    EXPECT_EQ(rows[1].substr(0, 8), "1,3,1.4,");
    const auto metrics = nlohmann::json::parse(file_text(folder / "run/metrics.json"));
    EXPECT_LT(metrics["points_max_error_m"].get<double>(), 0.06);
    EXPECT_LT(metrics["survey_median_m"].get<double>(), 0.02);
    EXPECT_GT(metrics["survey_points"].get<int>(), 10000);
    for (const char* file :
         {"map.survey.ply", "map.survey.pcd", "map.survey_odometry.ply", "map.survey_odometry.pcd",
          "table1.md", "snapshots/survey_top.png", "snapshots/survey_axonometric.png"})
        EXPECT_TRUE(fs::exists(folder / "run" / file)) << file;
    EXPECT_NE(file_text(folder / "run/report.html").find("Feature points"), std::string::npos);
    EXPECT_NE(file_text(folder / "run/config.ini").find("room.truth.csv"), std::string::npos);

    const auto without =
        run_loopline({"run", config, "--rawlog", log, "--out", (folder / "run").string(), "--quiet", "--set",
                      "evaluation.truth_beside_log=false", "--set", "outputs.maps=false"});
    EXPECT_EQ(without.exit_code, 0);
    EXPECT_FALSE(fs::exists(folder / "run/feature_points.csv"));
}
