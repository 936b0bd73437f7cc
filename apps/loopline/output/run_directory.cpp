#include "output/run_directory.h"

#include <algorithm>

#include "gnss/geo_reference.h"
#include "output/covariance_csv.h"
#include "output/feature_points_files.h"
#include "output/kitti_poses.h"
#include "output/manifest_json.h"
#include "output/map_files.h"
#include "output/output_file.h"
#include "output/stored_cloud_files.h"
#include "output/tum.h"

namespace loopline {
namespace {

void write_trajectories(const std::filesystem::path& folder, const RunRecord& record, FileList& list) {
    const auto tum = [&](const char* name, const Trajectory& trajectory, Estimate estimate) {
        list.add(name, write_tum(folder / name, trajectory, estimate), "poses");
    };
    if (record.trajectory) {
        tum("trajectory.tum", *record.trajectory, Estimate::latest);
        tum("trajectory_online.tum", *record.trajectory, Estimate::online);
        list.add("trajectory.kitti", write_kitti_poses(folder / "trajectory.kitti", *record.trajectory),
                 "poses");
        if (record.results.earth) {
            write_whole_file(folder / "georeference.txt",
                             gnss::georeference_text(gnss::GeoReference(*record.results.earth)));
            list.add("georeference.txt");
        }
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
