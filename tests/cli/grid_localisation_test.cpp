/// Localisation as a user runs it: what is wrong is said in one sentence, with the exit code that fits.
#include "commands/command.h"
#include "run_support.h"

using namespace loopline;
using namespace loopline::testing;

namespace {

/// A room of 8 m x 6 m as a picture, seen from its middle, where the laser of run_support.h sees nothing like
/// it.
class GridLocalisationRun : public ::testing::Test {
 protected:
    GridLocalisationRun() {
        picture_ = std::string(200 * 160, static_cast<char>(205));
        for (int y = 20; y < 140; ++y)
            for (int x = 20; x < 180; ++x)
                picture_[static_cast<std::size_t>(y * 200 + x)] = static_cast<char>(
                    y == 20 || y == 139 || x == 20 || x == 179 || (x > 100 && x < 110 && y < 60) ? 0 : 254);
        write_map("");
        write_log(log_, drive(60));
    }
    void write_map(const std::string& keys, const std::string& pixels = {}) const {
        std::filesystem::create_directories(folder_ / "map");
        write_file(folder_ / "map/room.pgm", "P5\n200 160\n255\n" + (pixels.empty() ? picture_ : pixels));
        write_file(folder_ / "map/room.yaml",
                   "image: room.pgm\nresolution: 0.05\norigin: [-5, -4, 0]\n" + keys);
    }
    test::ProgramResult run(const std::string& map, std::vector<std::string> more = {},
                            const std::string& out = "out") const {
        write_file(folder_ / "run.ini", "[run]\nrawlog = " + log_ +
                                            "\nmodules = odometry grid_localisation\n[grid_localisation]\n" +
                                            (map.empty() ? "" : "map = " + map + "\n") +
                                            "[outputs]\nsnapshots = false\nreport = false\n");
        std::vector<std::string> arguments{"run", folder_ / "run.ini", "--out", folder_ / out, "--quiet"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return test::run_loopline(arguments);
    }
    void expect_refusal(const test::ProgramResult& result, int code, const std::string& why) const {
        EXPECT_EQ(result.exit_code, code) << result.err;
        EXPECT_NE(result.err.find(why), std::string::npos) << result.err;
        EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
        EXPECT_FALSE(std::filesystem::exists(folder_ / "out/metrics.json"));
    }

    Folder folder_;
    std::string picture_, log_ = folder_ / "room.rawlog";
};

}  // namespace

TEST_F(GridLocalisationRun, needs_a_map_that_is_there) {
    expect_refusal(run(""), exit_configuration, "map names no map; name a run directory");
    expect_refusal(run("nowhere/map.yaml"), exit_configuration, "names a file that is not there: ");
    std::filesystem::create_directories(folder_ / "empty");
    expect_refusal(run("empty"), exit_input_data, "there is no grid map in the folder");
    std::filesystem::copy_file(folder_ / "map/room.yaml", folder_ / "map/twice.yaml");
    expect_refusal(run("map"), exit_input_data, "there are 2 grid maps in the folder");
}

TEST_F(GridLocalisationRun, needs_a_map_that_says_something) {
    const std::size_t cells = picture_.size();
    write_map("", picture_.substr(0, 1000));
    expect_refusal(run("map"), exit_input_data, "room.pgm is missing or damaged; give a YAML file");
    write_map("", std::string(cells, static_cast<char>(205)));
    expect_refusal(run("map"), exit_input_data, "has no occupied cell");
    write_map("", std::string(cells, 0));
    expect_refusal(run("map/room.pgm"), exit_input_data, "has no free cell");
    write_map("negate: 2\nmode: odd\n");
    expect_refusal(run("map/room.yaml"), exit_input_data, "its mode is \"odd\"");
    write_map("resolution: 2\n");
    expect_refusal(run("map/room.yaml"), exit_input_data, "has a resolution of 2 m; give one with cells of");
}

TEST_F(GridLocalisationRun, does_not_write_into_the_folder_of_its_map) {
    expect_refusal(run("map", {}, "map"), exit_configuration, "which it would replace; name another folder");
    EXPECT_TRUE(file_bytes(folder_ / "map/room.pgm").find(picture_) != std::string::npos);
}

TEST_F(GridLocalisationRun, refuses_a_log_that_never_fits_and_keeps_what_it_computed) {
    const std::string before = file_bytes(folder_ / "map/room.pgm");
    // The place was given: dead reckoning goes on from there.
    const auto given = run("map");
    EXPECT_EQ(given.exit_code, exit_refused) << given.err;
    EXPECT_NE(given.err.find("% of the scans fit "), std::string::npos) << given.err;
    EXPECT_NE(given.err.find("check that the map is of this place"), std::string::npos) << given.err;
    EXPECT_EQ(rows_of(folder_ / "out/trajectory.tum"), 60U);
    // It was not: there is none, and it is said why.
    const auto global = run("map", {"--set", "grid_localisation.start=global"}, "other");
    EXPECT_EQ(global.exit_code, exit_refused) << global.err;
    EXPECT_NE(global.err.find("never became certain"), std::string::npos) << global.err;
    EXPECT_EQ(rows_of(folder_ / "other/trajectory.tum"), 0U);
    const auto metrics = nlohmann::json::parse(file_bytes(folder_ / "other/metrics.json"));
    EXPECT_EQ(metrics.at("localised"), false);
    EXPECT_EQ(metrics.at("status"), "refused");
    EXPECT_EQ(file_bytes(folder_ / "map/room.pgm"), before);

    const auto manifest = nlohmann::json::parse(file_bytes(folder_ / "other/manifest.json"));
    ASSERT_EQ(manifest.at("inputs").size(), 3U);
    EXPECT_EQ(manifest["inputs"][1]["path"], folder_ / "map/room.yaml");
    EXPECT_EQ(manifest["inputs"][2]["path"], folder_ / "map/room.pgm");
    EXPECT_EQ(manifest["inputs"][2]["sha256"].get<std::string>().size(), 64U);
    EXPECT_FALSE(manifest["inputs"][2].contains("objects_read"));
}
