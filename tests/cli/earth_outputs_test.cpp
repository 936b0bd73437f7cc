/// What a run leaves of a path on the Earth, from a simulated street to files, pictures and the report.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gnss/geo_reference.h"
#include "gnss/utm.h"
#include "output/tum.h"
#include "support/gdal.h"
#include "support/street_log.h"

using namespace loopline;
using namespace loopline::test;

namespace {

std::vector<std::string> files_of_run(const TemporaryFolder& folder, const std::string& keys) {
    const std::string ini = folder.write("run.ini", "[run]\nrawlog = " + placed_street_log() + "\n" + keys);
    const auto result = run_loopline({"run", ini, "--out", (folder / "out").string()});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(file_text(folder / "out/manifest.json"))
        .at("files")
        .get<std::vector<std::string>>();
}

bool has(const std::vector<std::string>& files, const std::string& file) {
    return std::find(files.begin(), files.end(), file) != files.end();
}

}  // namespace

TEST(EarthOutputs, of_a_run_that_is_placed_agree_with_one_another) {
    const TemporaryFolder folder;
    const auto files = files_of_run(folder,
                                    "modules = lidar_mapping fusion\nmaps = final_cloud_map\ntrajectory = "
                                    "fusion\n[final_cloud_map]\nmax_range_m = 15\n");
    for (const char* file : {"georeference.txt", "trajectory.geojson", "trajectory.kml",
                             "trajectory_without_fixes.tum", "map.cloud_utm.las", "snapshots/earth_plan.png",
                             "snapshots/earth_height.png", "snapshots/earth_error.png"})
        EXPECT_TRUE(has(files, file)) << file;
    const auto out = folder / "out";
    const auto reference = gnss::read_georeference((out / "georeference.txt").string());
    const auto path = read_tum(out / "trajectory.tum"),
               without = read_tum(out / "trajectory_without_fixes.tum");
    ASSERT_EQ(without.size(), path.size());
    EXPECT_LT((without[0].T_map_base.translation_m - path[0].T_map_base.translation_m).norm(), 1e-9)
        << "begins where the result does";
    EXPECT_LT((without.back().T_map_base.translation_m - path.back().T_map_base.translation_m).norm(), 1);
    EXPECT_GT((without.back().T_map_base.translation_m - path.back().T_map_base.translation_m).norm(), 1e-6);

    const auto json = nlohmann::json::parse(file_text(out / "trajectory.geojson"));
    const auto metrics = nlohmann::json::parse(file_text(out / "metrics.json"));
    std::size_t vertices = 0, used = 0, refused = 0;
    for (const auto& feature : json.at("features")) {
        const auto& properties = feature.at("properties");
        const auto& coordinates = feature.at("geometry").at("coordinates");
        if (properties.at("kind") == "trajectory") {
            vertices += coordinates.size();
            for (std::size_t i = 0; i < coordinates.size(); ++i) {
                const Eigen::Vector3d p_m =
                    reference.p_map_m({coordinates[i][1].get<double>(), coordinates[i][0].get<double>(),
                                       coordinates[i][2].get<double>()});
                ASSERT_LT((p_m - path[i].T_map_base.translation_m).norm(), 1e-6);
            }
        } else if (properties.at("kind") == "fixes") {
            (properties.at("fate") == "used" ? used : refused) += coordinates.size();
        }
    }
    EXPECT_EQ(vertices, path.size());
    EXPECT_EQ(used, metrics.at("gnss_used").get<std::size_t>());
    EXPECT_EQ(refused, metrics.at("gnss_refused").get<std::size_t>());
    // The simulated receiver says where the geoid is, so the globe's heights are above the sea.
    EXPECT_NE(file_text(out / "trajectory.kml").find("above the geoid"), std::string::npos);
    const std::string report = file_text(out / "report.html");
    EXPECT_NE(report.find("The path on the Earth, with and without"), std::string::npos);
    if (!has_gdal())
        GTEST_SKIP() << "GDAL's programs (gdal-bin) are not installed: files are not read by others";
    EXPECT_EQ(positions_by_gdal(out / "trajectory.geojson", "kind = 'trajectory'").size(), path.size());
    EXPECT_EQ(positions_by_gdal(out / "trajectory.kml", "Name = 'trajectory'").size(), path.size());
}

TEST(EarthOutputs, are_of_the_path_that_is_placed_and_of_no_other) {
    const TemporaryFolder folder;
    const auto files =
        files_of_run(folder,
                     "modules = lidar_mapping fusion\ntrajectory = lidar_mapping\n[outputs]\nreport = "
                     "false\n");
    EXPECT_TRUE(has(files, "trajectory.tum"));
    for (const char* file : {"georeference.txt", "trajectory.geojson", "trajectory.kml",
                             "trajectory_without_fixes.tum", "snapshots/earth_plan.png"})
        EXPECT_FALSE(has(files, file)) << file;
    // A cloud in the frame of the odometry is no map of the Earth, though the path is.
    const auto with_cloud =
        files_of_run(folder,
                     "modules = lidar_mapping cloud_map fusion\ntrajectory = "
                     "fusion\n[cloud_map]\nmax_range_m = 15\n[outputs]\nsnapshots = false\nreport = false\n");
    EXPECT_TRUE(has(with_cloud, "map.cloud.las"));
    EXPECT_TRUE(has(with_cloud, "georeference.txt"));
    EXPECT_FALSE(has(with_cloud, "map.cloud_utm.las"));
}
