/// Localisation in a finished cloud as a user runs it: a street found again, and what is wrong in a sentence.
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "commands/command.h"
#include "support/placed_street_map.h"

using namespace loopline;
using namespace loopline::test;

namespace {

class CloudLocalisationRun : public ::testing::Test {
 protected:
    ProgramResult run(const std::string& map, std::vector<std::string> more = {},
                      const std::string& out = "out") const {
        const std::string ini = folder_.write(
            "run.ini", run_ini(placed_street_log(), "modules = cloud_localisation\n[cloud_localisation]\n" +
                                                        (map.empty() ? "" : "map = " + map + "\n")));
        std::vector<std::string> arguments{"run", ini, "--out", (folder_ / out).string(), "--quiet"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return run_loopline(arguments);
    }
    void expect_refusal(const ProgramResult& result, int code, const std::string& why) const {
        EXPECT_EQ(result.exit_code, code) << result.err;
        EXPECT_NE(result.err.find(why), std::string::npos) << result.err;
        EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
        EXPECT_FALSE(std::filesystem::exists(folder_ / "out/metrics.json"));
    }
    nlohmann::json metrics(const std::string& out) const {
        return nlohmann::json::parse(file_text(folder_ / (out + "/metrics.json")));
    }
    /// A copy of the cloud and where it lies, which a test may spoil.
    std::string copied_map() const {
        std::filesystem::create_directories(folder_ / "map");
        for (const char* name : {"map.cloud.ply", "georeference.txt"})
            std::filesystem::copy_file(placed_street_map() + "/" + name,
                                       folder_ / (std::string("map/") + name),
                                       std::filesystem::copy_options::overwrite_existing);
        return (folder_ / "map").string();
    }

    TemporaryFolder folder_;
};

}  // namespace

TEST_F(CloudLocalisationRun, finds_a_street_again_and_gives_the_same_bytes_for_any_number_of_threads) {
    for (const std::string threads : {"1", "2"}) {
        const auto result = run(placed_street_map(), {"--threads", threads}, threads);
        ASSERT_EQ(result.exit_code, 0) << result.err;
    }
    EXPECT_EQ(file_text(folder_ / "1/trajectory.tum"), file_text(folder_ / "2/trajectory.tum"));
    EXPECT_EQ(file_text(folder_ / "1/covariance.csv"), file_text(folder_ / "2/covariance.csv"));
    const auto found = metrics("1");
    EXPECT_EQ(found.at("localised"), true);
    EXPECT_LT(found.at("localised_after_s").get<double>(), 2);
    EXPECT_EQ(found.at("starts"), 1);
    EXPECT_EQ(found.at("times_lost"), 0);
    EXPECT_LT(found.at("earth_rmse_m").get<double>(), 0.06);
    // The path lies in the frame of the map, wherever the vehicle started.
    EXPECT_EQ(file_text(folder_ / "1/georeference.txt"),
              file_text(placed_street_map() + "/georeference.txt"));
    const auto manifest = nlohmann::json::parse(file_text(folder_ / "1/manifest.json"));
    ASSERT_EQ(manifest.at("inputs").size(), 5U);
    EXPECT_EQ(manifest["inputs"][1]["path"], placed_street_map() + "/map.cloud.ply");
    EXPECT_EQ(manifest["inputs"][2]["path"], placed_street_map() + "/georeference.txt");
    EXPECT_EQ(manifest["inputs"][3]["path"], placed_street_map() + "/trajectory.tum");
    EXPECT_EQ(manifest["inputs"][4]["path"], placed_street_map() + "/covariance.csv");
}

TEST_F(CloudLocalisationRun, needs_a_map_that_is_there_and_whole) {
    expect_refusal(run(""), exit_configuration, "map names no map; name a run directory");
    expect_refusal(run("nowhere/map.ply"), exit_configuration, "names a file that is not there: ");
    std::filesystem::create_directories(folder_ / "empty");
    expect_refusal(run((folder_ / "empty").string()), exit_input_data, "there is no cloud map in the folder");
    const std::string map = copied_map(), ply = map + "/map.cloud.ply";
    std::filesystem::resize_file(ply, std::filesystem::file_size(ply) / 2);
    expect_refusal(run(map), exit_input_data, "it was not written to its end; give a PLY, PCD or LAS file");
    std::filesystem::resize_file(ply, 100);
    expect_refusal(run(map), exit_input_data, "ends inside its header");
    folder_.write("few.ply",
                  "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                  "property float z\nend_header\n1 2 3\n");
    expect_refusal(run((folder_ / "few.ply").string()), exit_input_data, "has 1 points, which make no map");
    expect_refusal(run(placed_street_map() + "/map.cloud_utm.las"), exit_input_data,
                   "lies on a grid of the Earth, whose axes are bent");
}

TEST_F(CloudLocalisationRun, needs_to_know_where_the_map_lies_if_a_fix_is_to_tell_the_start) {
    const std::string map = copied_map();
    std::filesystem::remove(map + "/georeference.txt");
    expect_refusal(run(map), exit_input_data, "there is no georeference.txt beside ");
    folder_.write("map/georeference.txt", "latitude_deg = north\n");
    expect_refusal(run(map), exit_input_data, "latitude_deg is not a number; correct it");
    // The same map, said to lie 11 km to the north.
    std::string text = file_text(placed_street_map() + "/georeference.txt");
    const std::size_t at = text.find("latitude_deg = ") + 15;
    const double latitude_deg = std::stod(text.substr(at));
    text.replace(at, text.find('\n', at) - at, std::to_string(latitude_deg + 0.1));
    folder_.write("map/georeference.txt", text);
    const auto far = run(map, {"--set", "evaluation.truth_beside_log=false"}, "far");
    EXPECT_EQ(far.exit_code, exit_refused) << far.err;
    EXPECT_NE(far.err.find("never became certain: the fixes are 11"), std::string::npos) << far.err;
    EXPECT_NE(far.err.find("m outside of it, or farther; give the map of this place"), std::string::npos);
    EXPECT_EQ(std::count(far.err.begin(), far.err.end(), '\n'), 1) << far.err;
    EXPECT_EQ(metrics("far").at("localised"), false);
}

TEST_F(CloudLocalisationRun, takes_a_pose_that_is_given_and_refuses_one_that_is_wrong) {
    const std::string map = copied_map();
    std::filesystem::remove(map + "/georeference.txt");
    // The map's frame is that of the first fix, and the street lies as the receiver had it.
    std::istringstream first(file_text(placed_street_map() + "/trajectory.tum"));
    std::string line;
    while (std::getline(first, line) && line[0] == '#') {
    }
    std::istringstream numbers(line);
    double t, x, y, z, qx, qy, qz, qw;
    numbers >> t >> x >> y >> z >> qx >> qy >> qz >> qw;
    const auto given = [&](double turned_deg) {
        const std::string section = "cloud_localisation.";
        const double yaw_deg = 2 * std::atan2(qz, qw) * 180 / M_PI + turned_deg;
        return std::vector<std::string>{"--set", section + "start=given",
                                        "--set", section + "search_every_s=1",
                                        "--set", section + "start_x_m=" + std::to_string(x + 0.5),
                                        "--set", section + "start_y_m=" + std::to_string(y - 0.4),
                                        "--set", section + "start_z_m=" + std::to_string(z),
                                        "--set", section + "start_yaw_deg=" + std::to_string(yaw_deg)};
    };
    const auto right = run(map, given(6), "right");
    EXPECT_EQ(right.exit_code, 0) << right.err;
    EXPECT_LT(metrics("right").at("ate_rmse_m").get<double>(), 0.06);
    EXPECT_EQ(metrics("right").count("earth_rmse_m"), 0U);
    const auto wrong = run(map, given(95), "wrong");
    EXPECT_EQ(wrong.exit_code, exit_refused) << wrong.err;
    EXPECT_NE(wrong.err.find("never became certain: "), std::string::npos) << wrong.err;
}
