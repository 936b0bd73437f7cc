/// The Intel lab's run localised, from a start that it finds itself, in a map of its first part.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/built_files.h"
#include "support/run_program.h"
#include "support/shared_data.h"

using namespace loopline;

namespace {

/// (x, y) by the text of the stamp.
std::map<std::string, std::pair<double, double>> places_of(const std::filesystem::path& tum) {
    std::map<std::string, std::pair<double, double>> places;
    std::istringstream lines(test::file_text(tum));
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string stamp;
        double x = 0, y = 0;
        if (line[0] != '#' && words >> stamp >> x >> y) places[stamp] = {x, y};
    }
    return places;
}

}  // namespace

TEST(GridLocalisationLogs, intel_lab_in_a_map_of_its_first_part_agrees_with_mapping_all_of_it) {
    const std::string part = "intel/intel_part1_full_rate.sf.rawlog";
    NEEDS_SHARED_DATA(part);
    NEEDS_SHARED_DATA("intel/intel_1of5.sf.rawlog");
    const test::TemporaryFolder folder;
    const std::string data = test::shared_data().string(), ini = test::source_folder() + "/ini/real/";
    const auto run = [&](const std::string& name, const std::string& out, std::vector<std::string> more) {
        std::vector<std::string> arguments{"run",
                                           ini + name,
                                           "--out",
                                           (folder / out).string(),
                                           "--quiet",
                                           "--set",
                                           "outputs.snapshots=false",
                                           "--set",
                                           "outputs.report=false"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const auto result = test::run_loopline(arguments, {"LOOPLINE_DATA=" + data});
        EXPECT_EQ(result.exit_code, 0) << result.err;
        return folder / out;
    };
    const auto map = run("intel_grid.ini", "map", {"--rawlog", data + "/" + part, "--set", "run.maps=grid"});
    const std::string picture = test::file_text(map / "map.grid.pgm");
    const auto whole = run("intel_grid.ini", "whole", {"--set", "outputs.maps=false"});
    const auto found =
        run("intel_localisation.ini", "found", {"--set", "grid_localisation.map=" + map.string()});
    EXPECT_EQ(test::file_text(map / "map.grid.pgm"), picture);

    const auto metrics = nlohmann::json::parse(test::file_text(found / "metrics.json"));
    EXPECT_TRUE(metrics.at("localised").get<bool>());
    EXPECT_LT(metrics.at("localised_after_m").get<double>(), 15);
    EXPECT_GT(metrics.at("share_matched").get<double>(), 0.8);
    const auto a = places_of(found / "trajectory.tum"), b = places_of(whole / "trajectory.tum");
    ASSERT_EQ(a.size(), b.size());
    double squares = 0;
    for (const auto& [stamp, place] : a) {
        ASSERT_TRUE(b.count(stamp));
        const double off_m = std::hypot(place.first - b.at(stamp).first, place.second - b.at(stamp).second);
        squares += off_m * off_m;
        EXPECT_LT(off_m, 0.5) << stamp;
    }
    EXPECT_LT(std::sqrt(squares / static_cast<double>(a.size())), 0.08);
}
