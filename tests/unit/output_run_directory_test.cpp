/// The run directory as a whole: which files, metrics, manifest, what happens when the disk refuses.
#include <gtest/gtest.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <iomanip>
#include <limits>
#include <nlohmann/json.hpp>

#include "commands/command.h"
#include "output/output_file.h"
#include "output/run_directory.h"
#include "output_test_support.h"

using namespace loopline;
using output_test::content;
using output_test::Folder;
using output_test::random_trajectory;
namespace fs = std::filesystem;

namespace {

RunRecord example(const Trajectory& trajectory, const Trajectory& odometry) {
    RunRecord record;
    record.trajectory = &trajectory;
    record.odometry = &odometry;
    record.scans_read = 12;
    record.scans_used = 10;
    record.first_stamp_ns = 1'000'000'000;
    record.last_stamp_ns = 5'500'000'000;
    record.wall_s = 0.5;
    record.cpu_s = 0.25;
    record.peak_memory_mb = 61;
    record.inputs.push_back({"a.rawlog", 123456789012, "ab12", 24, ""});
    record.results.metrics = {
        {"updates", std::int64_t{7}}, {"mode", std::string("joint")}, {"closed", true}, {"residual_m", 0.1}};
    record.results.line_map = LineMap(1);
    record.modules["line_slam"] = {4, 10.0, 6.0, 1.5};
    record.config_path = "x.ini";
    record.effective_ini = "[run]\nseed = 3\n";
    record.seed = 3;
    return record;
}

std::vector<std::string> names_in(const fs::path& folder) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder))
        names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

nlohmann::json json_of(const fs::path& file) {
    return nlohmann::json::parse(content(file));
}

}  // namespace

TEST(OutputRunDirectory, holds_the_files_asked_for_and_the_manifest_lists_them) {
    const Folder folder;
    const Trajectory trajectory = random_trajectory(10, 1), odometry = random_trajectory(10, 2);
    write_run_directory(folder.path(), example(trajectory, odometry), {});
    const std::vector<std::string> expected = {
        "config.ini",   "covariance.csv", "manifest.json",    "map.lines.csv",  "map.lines.geojson",
        "metrics.json", "odometry.tum",   "trajectory.kitti", "trajectory.tum", "trajectory_online.tum"};
    EXPECT_EQ(names_in(folder.path()), expected);
    auto listed = json_of(folder / "manifest.json")["files"].get<std::vector<std::string>>();
    std::sort(listed.begin(), listed.end());
    EXPECT_EQ(listed, expected);
    EXPECT_EQ(content(folder / "config.ini"), "[run]\nseed = 3\n");
}

TEST(OutputRunDirectory, near_a_pole_has_everything_but_the_utm_grid_and_says_so_once) {
    const Folder folder;
    const Trajectory trajectory = random_trajectory(10, 1), odometry = random_trajectory(10, 2);
    RunRecord record = example(trajectory, odometry);
    StoredCloud cloud;
    cloud.push_back({{1, 2, 3}, 0, 0, 0});
    record.cloud = &cloud;
    record.cloud_on_trajectory = true;
    auto points = mrpt::maps::CSimplePointsMap::Create();
    points->insertPoint(1, 2, 3);
    record.results.maps.push_back({"points", points});
    for (const double latitude_deg : {49.0, 89.9}) {
        record.results.earth = EarthFrame{latitude_deg, 8.4, 100, 0};
        write_run_directory(folder.path(), record, {});
        const auto json = json_of(folder / "manifest.json");
        const bool on_grid = latitude_deg < 84;
        EXPECT_EQ(fs::exists(folder / "map.cloud_utm.las"), on_grid);
        EXPECT_EQ(fs::exists(folder / "map.points_utm.las"), on_grid);
        EXPECT_TRUE(fs::exists(folder / "trajectory.geojson"));
        EXPECT_TRUE(fs::exists(folder / "trajectory.kml"));
        EXPECT_EQ(json.value("warnings", nlohmann::json::array()).size(), on_grid ? 0u : 1u);
    }
    record.cloud_on_trajectory = false;
    record.results.earth = EarthFrame{49, 8.4, 100, 0};
    write_run_directory(folder.path(), record, {});
    EXPECT_FALSE(fs::exists(folder / "map.cloud_utm.las")) << "a cloud in another frame";
}

TEST(OutputRunDirectory, a_second_run_leaves_no_file_of_the_first_and_no_other_file_is_touched) {
    const Folder folder;
    const Trajectory trajectory = random_trajectory(10, 1), odometry = random_trajectory(10, 2);
    const RunRecord record = example(trajectory, odometry);
    std::ofstream(folder / "notes.txt") << "mine";
    write_run_directory(folder.path(), record, {});
    fs::create_directory(folder / "snapshots");
    std::ofstream(folder / "snapshots/top.png") << "picture";
    add_to_manifest(folder.path(), {"snapshots/top.png", "snapshots/top.png"});
    const auto files = json_of(folder / "manifest.json")["files"].get<std::vector<std::string>>();
    EXPECT_EQ(std::count(files.begin(), files.end(), "snapshots/top.png"), 1);

    OutputSettings estimate_less;
    estimate_less.trajectory = false;
    estimate_less.maps = false;
    write_run_directory(folder.path(), record, estimate_less);
    EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"config.ini", "manifest.json",
                                                                 "metrics.json", "notes.txt", "snapshots"}));
    EXPECT_FALSE(fs::exists(folder / "snapshots/top.png"));
}

TEST(OutputRunDirectory, what_this_run_has_already_written_stays) {
    const Folder folder;
    std::ofstream(folder / "recorded.rawlog") << "first";
    write_run_directory(folder.path(), RunRecord(), {});
    add_to_manifest(folder.path(), {"recorded.rawlog"});
    std::ofstream(folder / "recorded.rawlog") << "second";
    fs::last_write_time(folder / "recorded.rawlog",
                        fs::last_write_time(folder / "manifest.json") + std::chrono::milliseconds(1));
    write_run_directory(folder.path(), RunRecord(), {});
    EXPECT_EQ(content(folder / "recorded.rawlog"), "second");
}

TEST(OutputRunDirectory, a_hostile_manifest_removes_nothing_outside) {
    const Folder folder;
    fs::create_directory(folder / "run");
    std::ofstream(folder / "precious") << "x";
    std::ofstream(folder / "run/manifest.json")
        << R"({"files":["../precious", ")" << (folder / "precious").string() << R"(", "", 5]})";
    write_run_directory(folder / "run", RunRecord(), {});
    EXPECT_TRUE(fs::exists(folder / "precious"));
    std::ofstream(folder / "run/manifest.json") << "{ damaged";
    write_run_directory(folder / "run", RunRecord(), {});
    EXPECT_EQ(json_of(folder / "run/manifest.json")["status"], "done");
}

TEST(OutputRunDirectory, same_record_same_bytes) {
    const Folder folder;
    const Trajectory trajectory = random_trajectory(10, 1), odometry = random_trajectory(10, 2);
    for (const char* name : {"a", "b"}) {
        fs::create_directory(folder / name);
        write_run_directory(folder / name, example(trajectory, odometry), {});
    }
    for (const auto& name : names_in(folder / "a"))
        EXPECT_EQ(content(folder / "a" / name), content(folder / "b" / name)) << name;
}

TEST(OutputMetrics, flat_keys_with_types_and_time_per_module) {
    const Folder folder;
    const Trajectory trajectory = random_trajectory(10, 1), odometry = random_trajectory(10, 2);
    write_metrics(folder.path(), example(trajectory, odometry));
    const auto m = json_of(folder / "metrics.json");
    EXPECT_EQ(m["status"], "done");
    EXPECT_EQ(m["scans_read"], 12);
    EXPECT_EQ(m["scans_used"], 10);
    EXPECT_EQ(m["log_s"], 4.5);
    EXPECT_EQ(m["real_time_factor"], 9.0);
    EXPECT_EQ(m["cpu_s"], 0.25);
    EXPECT_EQ(m["distance_m"], trajectory.length_m());
    EXPECT_TRUE(m["updates"].is_number_integer());
    EXPECT_EQ(m["updates"], 7);
    EXPECT_EQ(m["residual_m"], 0.1);
    EXPECT_EQ(m["mode"], "joint");
    EXPECT_EQ(m["closed"], true);
    EXPECT_EQ(m["modules"]["line_slam"]["calls"], 4);
    EXPECT_EQ(m["modules"]["line_slam"]["mean_ms"], 2.5);
    EXPECT_EQ(m["modules"]["line_slam"]["worst_ms"], 6.0);
    EXPECT_EQ(m["modules"]["line_slam"]["finish_ms"], 1.5);
    for (const auto& [key, value] : m.items()) EXPECT_EQ(value.is_structured(), key == "modules") << key;
    for (const char* absent : {"ate_rmse_m", "input_damage", "refused", "poses_left_out"})
        EXPECT_FALSE(m.contains(absent)) << absent;
}

TEST(OutputMetrics, what_does_not_apply_or_is_not_finite_is_absent) {
    const Folder folder;
    RunRecord record;
    record.results.metrics = {{"ate_rmse_m", std::numeric_limits<double>::quiet_NaN()},
                              {"worst", std::numeric_limits<double>::infinity()},
                              {"status", std::string("a module's idea")}};
    record.modules["idle"] = {};
    write_metrics(folder.path(), record);
    const auto m = json_of(folder / "metrics.json");
    EXPECT_EQ(m["status"], "done") << "a module can't replace what the host knows";
    for (const char* absent :
         {"ate_rmse_m", "worst", "log_s", "real_time_factor", "distance_m", "peak_memory_mb"})
        EXPECT_FALSE(m.contains(absent)) << absent;
    EXPECT_EQ(m["modules"]["idle"]["mean_ms"], 0.0);
    EXPECT_EQ(content(folder / "metrics.json").find("null"), std::string::npos);
}

TEST(OutputManifest, says_inputs_versions_seed_damage_and_what_was_left_out) {
    const Folder folder;
    Trajectory trajectory = random_trajectory(10, 1);
    Pose3 bad;
    bad.translation_m.x() = std::numeric_limits<double>::quiet_NaN();
    trajectory.revise(4, bad, Matrix6d::Zero());
    RunRecord record = example(trajectory, trajectory);
    record.status = "damaged_input";
    record.exit_code = 3;
    record.inputs[0].damage = "a.rawlog breaks off after 24 objects.";
    record.warnings = {"stamps go backwards 3 times"};
    write_run_directory(folder.path(), record, {});
    const auto m = json_of(folder / "manifest.json");
    EXPECT_EQ(m["inputs"][0]["path"], "a.rawlog");
    EXPECT_EQ(m["inputs"][0]["bytes"].get<std::uint64_t>(), 123456789012u);
    EXPECT_EQ(m["inputs"][0]["sha256"], "ab12");
    EXPECT_EQ(m["inputs"][0]["damage"], "a.rawlog breaks off after 24 objects.");
    EXPECT_EQ(m["seed"], 3);
    EXPECT_EQ(m["exit_code"], 3);
    EXPECT_EQ(m["versions"]["loopline"], LOOPLINE_VERSION);
    EXPECT_EQ(m["versions"]["mrpt"].get<std::string>().find_first_not_of("0123456789."), std::string::npos);
    EXPECT_FALSE(m["versions"]["compiler"].get<std::string>().empty());
    const auto warnings = m["warnings"].get<std::vector<std::string>>();
    EXPECT_EQ(warnings[0], "stamps go backwards 3 times");
    EXPECT_NE(warnings[1].find("trajectory.tum leaves out 1 poses"), std::string::npos);
    const auto metrics = json_of(folder / "metrics.json");
    EXPECT_EQ(metrics["input_damage"], "a.rawlog breaks off after 24 objects.");
    EXPECT_EQ(metrics["poses_left_out"], 1);
    EXPECT_FALSE(metrics.contains("distance_m"));
}

TEST(OutputManifest, a_path_that_is_not_utf8_is_still_written) {
    const Folder folder;
    RunRecord record;
    record.config_path = "caf\xe9.ini";
    write_run_directory(folder.path(), record, {});
    EXPECT_EQ(json_of(folder / "manifest.json")["config"].get<std::string>().substr(0, 3), "caf");
}

TEST(OutputFile, nothing_is_left_of_a_file_that_was_not_committed) {
    const Folder folder;
    std::ofstream(folder / "a.txt") << "before";
    {
        OutputFile out(folder / "a.txt");
        out.text("half");
    }
    EXPECT_EQ(content(folder / "a.txt"), "before");
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"a.txt"});
}

TEST(OutputFile, long_content_crosses_the_buffer_unharmed) {
    const Folder folder;
    std::string expected;
    OutputFile out(folder / "a.txt");
    for (int i = 0; i < 40000; ++i) {
        out.integer(-i).text(" ").count(static_cast<std::uint64_t>(i)).text(" ").number(i / 8.0).text("\n");
        std::ostringstream line;
        line << -i << ' ' << i << ' ' << std::setprecision(17) << i / 8.0 << '\n';
        expected += line.str();
    }
    const std::string block(200000, 'x');
    out.text(block).commit();
    EXPECT_EQ(content(folder / "a.txt"), expected + block);
}

TEST(OutputFile, stamps_are_written_as_seconds_text_does) {
    const Folder folder;
    for (const StampNs stamp_ns :
         {StampNs{0}, StampNs{-1}, StampNs{1137834225973760001}, std::numeric_limits<StampNs>::min(),
          std::numeric_limits<StampNs>::max()}) {
        OutputFile out(folder / "t");
        out.seconds(stamp_ns).commit();
        EXPECT_EQ(content(folder / "t"), seconds_text(stamp_ns));
    }
}

TEST(OutputFile, a_missing_folder_is_one_sentence) {
    const Folder folder;
    try {
        write_whole_file(folder / "nowhere" / "a.txt", "x");
        FAIL();
    } catch (const CommandError& e) {
        EXPECT_EQ(e.code(), exit_configuration);
        EXPECT_NE(std::string(e.what()).find("nowhere/a.txt"), std::string::npos);
        EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    }
}

TEST(OutputFile, a_disk_that_is_full_is_one_sentence_and_leaves_no_half_file) {
    const Folder folder;
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{1000, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    std::string said;
    try {
        write_whole_file(folder / "a.txt", std::string(100000, 'x'));
    } catch (const CommandError& e) {
        said = e.what();
    }
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    EXPECT_NE(said.find("can't write"), std::string::npos) << said;
    EXPECT_TRUE(names_in(folder.path()).empty());
}
