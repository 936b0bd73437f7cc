#include "output/run_directory.h"

#include <algorithm>

#include "gnss/geo_reference.h"
#include "output/covariance_csv.h"
#include "output/feature_points_files.h"
#include "output/file_name.h"
#include "output/kitti_poses.h"
#include "output/las_format.h"
#include "output/manifest_json.h"
#include "output/map_files.h"
#include "output/output_file.h"
#include "output/stored_cloud_files.h"
#include "output/trajectory_geojson.h"
#include "output/trajectory_kml.h"
#include "output/tum.h"
#include "output/utm_las.h"

namespace loopline {
namespace {

void write_path_on_earth(const std::filesystem::path& folder, const RunRecord& record, FileList& list) {
    const EarthFrame& earth = *record.results.earth;
    const Trajectory& path = *record.trajectory;
    write_whole_file(folder / "georeference.txt", gnss::georeference_text(gnss::GeoReference(earth)));
    list.add("georeference.txt");
    list.add("trajectory.geojson",
             write_trajectory_geojson(folder / "trajectory.geojson", path, earth, record.results.fixes),
             "poses");
    list.add("trajectory.kml", write_trajectory_kml(folder / "trajectory.kml", path, earth), "poses");
    if (const auto& other = record.results.uncorrected) {
        const std::string name = "trajectory_" + as_file_name(other->name) + ".tum";
        list.add(name, write_tum(folder / name, *other->path, Estimate::latest), "poses");
    }
}

void write_trajectories(const std::filesystem::path& folder, const RunRecord& record, FileList& list) {
    const auto tum = [&](const char* name, const Trajectory& trajectory, Estimate estimate) {
        list.add(name, write_tum(folder / name, trajectory, estimate), "poses");
    };
    if (record.trajectory) {
        tum("trajectory.tum", *record.trajectory, Estimate::latest);
        tum("trajectory_online.tum", *record.trajectory, Estimate::online);
        list.add("trajectory.kitti", write_kitti_poses(folder / "trajectory.kitti", *record.trajectory),
                 "poses");
        if (record.results.earth) write_path_on_earth(folder, record, list);
        list.add("covariance.csv", write_covariance_csv(folder / "covariance.csv", *record.trajectory),
                 "covariances");
    }
    if (record.odometry) tum("odometry.tum", *record.odometry, Estimate::latest);
}

void write_stored_cloud(const std::filesystem::path& folder, const StoredCloud& cloud, FileList& list) {
    write_ply(folder / "map.cloud.ply", cloud);
    list.add("map.cloud.ply");
    write_pcd(folder / "map.cloud.pcd", cloud);
    list.add("map.cloud.pcd");
    if (cloud.points().size() <= most_las_points) {
        write_las(folder / "map.cloud.las", cloud);
        list.add("map.cloud.las");
    } else {
        list.warnings.push_back("map.cloud.las is not written: its format ends at 4,294,967,295 points");
    }
}

/// On the grid of maps, what lies in the frame of a trajectory that is placed.
void write_points_on_utm(const std::filesystem::path& folder, const RunRecord& record, FileList& list) {
    if (!record.results.earth) return;
    const gnss::GeoReference reference(*record.results.earth);
    std::vector<std::pair<std::string, PointsOnMap>> clouds;
    if (record.cloud != nullptr && record.cloud_on_trajectory)
        clouds.emplace_back("map.cloud", points_on_map(*record.cloud));
    for (const auto& [stem, points] : point_maps(record.results))
        clouds.emplace_back(stem, points_on_map(*points, record.first_stamp_ns));
    if (clouds.empty()) return;
    const auto grid = grid_of(reference);
    if (!grid) {
        list.warnings.push_back(
            "the map is not written on the UTM grid, which ends at 84 degrees north and 80 degrees south; "
            "georeference.txt places its local coordinates");
        return;
    }
    for (const auto& [stem, points] : clouds) {
        const std::string file = stem + "_utm.las";
        if (points.count > most_las_points) {
            list.warnings.push_back(file + " is not written: its format ends at 4,294,967,295 points");
            continue;
        }
        write_utm_las(folder / file, points, reference, *grid);
        list.add(file);
    }
}

void write_feature_points(const std::filesystem::path& folder, const RunRecord& record, FileList& list) {
    const auto& points = record.feature_points.points;
    if (points.empty()) return;
    write_feature_points_csv(folder / "feature_points.csv", points);
    list.add("feature_points.csv");
    write_whole_file(folder / "table1.md", feature_points_table(points, record.published_points));
    list.add("table1.md");
}

/// Files of an earlier run in this folder: its manifest lists them, and they are not newer than it (the
/// present run may have written recorded.rawlog already). A manifest may come from anywhere: nothing outside
/// of the folder counts.
std::vector<std::string> files_of_earlier_run(const std::filesystem::path& folder) {
    const auto leads_out = [](const std::filesystem::path& file) {
        return file.empty() || file.is_absolute() ||
               std::any_of(file.begin(), file.end(), [](const auto& part) { return part == ".."; });
    };
    std::error_code none;  // a file that is gone is not newer
    const auto written = std::filesystem::last_write_time(folder / "manifest.json", none);
    std::vector<std::string> files;
    for (const auto& file : files_in_manifest(folder))
        if (!leads_out(file) && std::filesystem::last_write_time(folder / file, none) <= written)
            files.push_back(file);
    return files;
}

void remove_stale(const std::filesystem::path& folder, const std::vector<std::string>& before,
                  const std::vector<std::string>& now) {
    for (const auto& file : before) {
        if (std::find(now.begin(), now.end(), file) != now.end()) continue;
        std::error_code ignored;  // it may be gone already
        std::filesystem::remove(folder / file, ignored);
    }
}

}  // namespace

void write_run_directory(const std::filesystem::path& folder, const RunRecord& record,
                         const OutputSettings& outputs) {
    const auto before = files_of_earlier_run(folder);
    FileList list;
    if (outputs.trajectory) write_trajectories(folder, record, list);
    write_feature_points(folder, record, list);
    if (outputs.maps) {
        write_map_files(folder, record.results, list);
        write_odometry_points(folder, record.odometry_results, list);
        if (record.cloud != nullptr) write_stored_cloud(folder, *record.cloud, list);
        write_points_on_utm(folder, record, list);
    }
    write_whole_file(folder / "config.ini", record.effective_ini);
    list.add("config.ini");
    write_metrics(folder, record);
    list.add("metrics.json");
    list.add("manifest.json");
    for (const auto& state : record.states) list.add(state);
    remove_stale(folder, before, list.files);
    write_manifest(folder, record, list.warnings, list.files);
}

}  // namespace loopline
