/// Sweeps: what is run, and what the tables say.
#include <gtest/gtest.h>

#include <fstream>

#include "commands/command.h"
#include "output/feature_points_files.h"
#include "support/run_program.h"
#include "sweep/sweep_plan.h"
#include "sweep/sweep_table.h"

using namespace loopline;

namespace {

SweepRun run_of(const std::vector<std::string>& combination, const std::string& log, int exit_code,
                const std::map<std::string, double>& metrics) {
    return {combination, log, exit_code, metrics};
}

/// Two values on three logs; one run of the second failed.
SweepTable small_table() {
    SweepTable table;
    table.variations = {{"line_slam.interval_scans", {"1", "20"}}};
    table.metrics = {"ate_rmse_m", "updates"};
    table.runs = {run_of({"1"}, "seed1", 0, {{"ate_rmse_m", 0.01}, {"updates", 100}}),
                  run_of({"1"}, "seed2", 0, {{"ate_rmse_m", 0.03}, {"updates", 110}}),
                  run_of({"1"}, "seed3", 0, {{"ate_rmse_m", 0.08}, {"updates", 120}}),
                  run_of({"20"}, "seed1", 0, {{"ate_rmse_m", 0.02}, {"updates", 5}}),
                  run_of({"20"}, "seed2", 4, {{"updates", 1}}),
                  run_of({"20"}, "seed3", 0, {{"ate_rmse_m", 0.04}, {"updates", 6}})};
    return table;
}

}  // namespace

TEST(SweepPlan, variations_and_seeds_from_the_command_line) {
    const Variation variation = variation_from_text("line_slam.interval_scans=1, 5,adaptive");
    EXPECT_EQ(variation.key, "line_slam.interval_scans");
    EXPECT_EQ(variation.values, (std::vector<std::string>{"1", "5", "adaptive"}));
    EXPECT_EQ(variation_from_text("a.b=c=d").values, (std::vector<std::string>{"c=d"}));
    for (const char* wrong : {"", "a.b", "a.b=", "ab=1", ".b=1", "a.=1", "a=1.5"})
        EXPECT_THROW(variation_from_text(wrong), CommandError) << wrong;
    EXPECT_EQ(seeds_from_text("3"), (std::vector<std::uint64_t>{3}));
    EXPECT_EQ(seeds_from_text("1-3,7, 9-10"), (std::vector<std::uint64_t>{1, 2, 3, 7, 9, 10}));
    for (const char* wrong : {"", "a", "3-1", "-2", "1-", "1.5", "1-99999999"})
        EXPECT_THROW(seeds_from_text(wrong), CommandError) << wrong;
}

TEST(SweepPlan, every_combination_the_last_key_fastest) {
    const std::vector<std::vector<std::string>> expected = {{"a", "1"}, {"a", "2"}, {"a", "3"},
                                                            {"b", "1"}, {"b", "2"}, {"b", "3"}};
    EXPECT_EQ(combinations_of({{"x.y", {"a", "b"}}, {"x.z", {"1", "2", "3"}}}), expected);
    EXPECT_EQ(combinations_of({}), (std::vector<std::vector<std::string>>{{}}));
}

TEST(SweepTable, numbers_inside_others_and_the_time_in_all_modules) {
    const auto flat = flat_metrics(nlohmann::ordered_json::parse(
        R"({"status": "done", "ate_rmse_m": 0.5, "updates": 7, "modules":
            {"lines": {"calls": 100, "mean_ms": 2.5}, "line_slam": {"calls": 50, "mean_ms": 10}}})"));
    EXPECT_EQ(flat.at("ate_rmse_m"), 0.5);
    EXPECT_EQ(flat.at("updates"), 7);
    EXPECT_EQ(flat.at("modules.lines.mean_ms"), 2.5);
    EXPECT_DOUBLE_EQ(flat.at("modules_s"), 0.75);
    EXPECT_EQ(flat.count("status"), 0u);
    EXPECT_TRUE(flat_metrics(nlohmann::ordered_json::parse("[1]")).empty());
    EXPECT_EQ(usual_metrics(small_table().runs), (std::vector<std::string>{"ate_rmse_m", "updates"}));
}

TEST(SweepTable, mean_median_and_worst_over_the_logs) {
    const SweepTable table = small_table();
    const auto one = summary_of(table.runs, {"1"}, "ate_rmse_m"),
               twenty = summary_of(table.runs, {"20"}, "ate_rmse_m");
    EXPECT_EQ(one.count, 3u);
    EXPECT_DOUBLE_EQ(one.mean, 0.04);
    EXPECT_DOUBLE_EQ(one.median, 0.03);
    EXPECT_DOUBLE_EQ(one.min, 0.01);
    EXPECT_DOUBLE_EQ(one.max, 0.08);
    EXPECT_EQ(twenty.count, 2u);
    EXPECT_DOUBLE_EQ(twenty.median, 0.03);
    EXPECT_EQ(
        table.markdown(),
        "| interval_scans | runs | ate_rmse_m: mean / median / worst | updates: mean / median / worst |\n"
        "| ---: | ---: | ---: | ---: |\n"
        "| 1 | 3 | 0.04 / 0.03 / 0.08 | 110 / 110 / 120 |\n"
        "| 20 | 2 of 3 | 0.03 / 0.03 / 0.04 | 4 / 5 / 6 |\n");
    EXPECT_EQ(table.csv_of_runs().rfind(
                  "line_slam.interval_scans,log,exit_code,ate_rmse_m,updates\n1,seed1,0,0.01,100\n"
                  "1,seed2,0,0.03,110\n",
                  0),
              0u)
        << table.csv_of_runs();
    EXPECT_NE(table.csv_of_runs().find("20,seed2,4,,1\n"), std::string::npos);
    EXPECT_EQ(table.csv().substr(0, table.csv().find('\n')),
              "line_slam.interval_scans,runs,runs_good,ate_rmse_m_mean,ate_rmse_m_median,ate_rmse_m_min,"
              "ate_rmse_m_max,updates_mean,updates_median,updates_min,updates_max");
}

TEST(SweepTable, one_run_a_combination_gives_plain_numbers) {
    SweepTable table = small_table();
    table.runs = {table.runs[0], table.runs[3]};
    EXPECT_EQ(table.markdown(),
              "| interval_scans | runs | ate_rmse_m | updates |\n| ---: | ---: | ---: | ---: |\n"
              "| 1 | 1 | 0.01 | 100 |\n| 20 | 1 | 0.02 | 5 |\n");
}

TEST(FeaturePointFiles, table_and_csv) {
    PointEstimate one, two;
    one.number = 1;
    one.returns = 12;
    one.true_m = {4.2, 1.23};
    one.estimate_m = {4.23, 1.27};
    one.odometry_m = Eigen::Vector2d(4.2, 2.23);
    two.number = 2;
    two.returns = 3;
    two.estimate_m = {0.1, 0};
    const test::TemporaryFolder folder;
    write_feature_points_csv(folder / "p.csv", {one, two});
    EXPECT_EQ(test::file_text(folder / "p.csv"),
              "number,true_x_m,true_y_m,odometry_x_m,odometry_y_m,estimate_x_m,estimate_y_m\n"
              "1,4.2,1.23,4.2,2.23,4.23,1.27\n2,0,0,,,0.1,0\n");
    EXPECT_EQ(feature_points_table({one, two}, {}),
              "| point | true x, y m | odometry x, y m | corrected x, y m | odometry, error mm | corrected, "
              "error mm "
              "| returns |\n| ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n"
              "| 1 | 4.200, 1.230 | 4.200, 2.230 | 4.230, 1.270 | 1000 | 50 | 12 |\n"
              "| 2 | 0.000, 0.000 |  | 0.100, 0.000 |  | 100 | 3 |\n"
              "| mean | | | | 1000 | 75 | |\n| RMS | | | | 1000 | 79 | |\n| max | | | | 1000 | 100 | |\n");
    const std::string with_published =
        feature_points_table({one, two}, {{1, {4.2, 1.73}, {4.2, 1.43}}, {9, {0, 0}, {0, 0}}});
    EXPECT_NE(with_published.find("| 1000 | 50 | 500 | 200 | 12 |"), std::string::npos) << with_published;
    EXPECT_NE(with_published.find("| 100 |  |  | 3 |"), std::string::npos) << with_published;
}
