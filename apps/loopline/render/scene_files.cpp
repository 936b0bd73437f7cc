/// What a run directory, or a single file of one, has to show.
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "commands/command.h"
#include "output/line_map_csv.h"
#include "output/map_server_grid.h"
#include "output/tum.h"
#include "render/point_files.h"
#include "render/scene_content.h"

namespace loopline {
namespace {

namespace fs = std::filesystem;

/// Points of a file that rise by more than this, and are not a handful, are drawn as a cloud in space.
constexpr double level_m = 1;
constexpr std::size_t fewest_of_cloud = 10'000;

std::vector<Pose3> path_from_tum(const fs::path& file) {
    std::vector<Pose3> poses;
    for (const auto& stamped : read_tum(file)) poses.push_back(stamped.T_map_base);
    return poses;
}

mrpt::maps::COccupancyGridMap2D::Ptr grid_from(const fs::path& file) {
    if (file.extension() == ".yaml") return read_map_server_grid(file);
    auto grid = mrpt::maps::COccupancyGridMap2D::Create();
    try {
        mrpt::io::CFileGZInputStream in(file.string());
        mrpt::serialization::archiveFrom(in) >> *grid;
    } catch (const std::exception&) {
        // MRPT's text says where in its source; what the user needs is which file.
        throw CommandError(exit_input_data, file.string() + " is not a grid map that MRPT can read.");
    }
    return grid;
}

void add_simple_map(const fs::path& file, SceneContent& content) {
    mrpt::maps::CSimpleMap map;
    mrpt::maps::CSimplePointsMap points;
    try {
        if (!map.loadFromFile(file.string())) throw std::runtime_error("unreadable");
        points.insertionOptions.minDistBetweenLaserPoints = 0;
        points.insertionOptions.also_interpolate = false;
        points.loadFromSimpleMap(map);
    } catch (const std::exception&) {
        throw CommandError(exit_input_data, file.string() + " is not a simple map that MRPT can read.");
    }
    for (std::size_t i = 0; i < map.size(); ++i) {
        const auto [pose, observations] = map.get(i);
        if (!pose) continue;
        mrpt::poses::CPose3D mean;
        pose->getMean(mean);
        mrpt::math::CQuaternionDouble q;
        mean.getAsQuaternion(q);
        content.estimated_path.emplace_back(Eigen::Vector3d(mean.x(), mean.y(), mean.z()),
                                            Eigen::Quaterniond(q.r(), q.x(), q.y(), q.z()));
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        float x = 0, y = 0, z = 0;
        points.getPoint(i, x, y, z);
        content.points_m.emplace_back(x, y, z);
    }
}

/// Whether points are of a map in space rather than of level scans.
bool are_cloud(const PointSource& points) {
    if (points.size() < fewest_of_cloud) return false;
    float low_m = INFINITY, high_m = -INFINITY;
    points.for_each(1, [&](const Eigen::Vector3f& p) {
        if (!p.allFinite()) return;
        low_m = std::min(low_m, p.z());
        high_m = std::max(high_m, p.z());
    });
    return high_m - low_m > level_m;
}

mrpt::maps::CPointsMap::Ptr cloud_from(const fs::path& file) {
    const auto cloud = mrpt::maps::CSimplePointsMap::Create();
    for (const auto& p : finite_points(*points_of_file(file))) cloud->insertPointFast(p.x(), p.y(), p.z());
    cloud->mark_as_modified();
    return cloud;
}

/// map.NAME.ply or map.NAME_odometry.ply, which comes after it in name order.
void add_survey(const fs::path& file, SceneContent& content) {
    const std::string stem = file.stem().string().substr(4), suffix = "_odometry";
    const bool is_raw =
        stem.size() > suffix.size() && stem.compare(stem.size() - suffix.size(), suffix.size(), suffix) == 0;
    const std::string name = is_raw ? stem.substr(0, stem.size() - suffix.size()) : stem;
    auto& surveys = content.surveys;
    auto found = std::find_if(surveys.begin(), surveys.end(), [&](const auto& s) { return s.name == name; });
    if (found == surveys.end()) found = surveys.insert(surveys.end(), {name, nullptr, nullptr});
    (is_raw ? found->raw : found->corrected) = cloud_from(file);
}

/// The files of `folder` whose names begin and end like this, in name order.
std::vector<fs::path> files_like(const fs::path& folder, const std::string& start, const std::string& end) {
    std::vector<fs::path> files;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
        const std::string name = entry.path().filename().string();
        if (name.size() >= start.size() + end.size() && name.compare(0, start.size(), start) == 0 &&
            name.compare(name.size() - end.size(), end.size(), end) == 0)
            files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

bool has_content(const SceneContent& content) {
    return !content.estimated_path.empty() || !content.odometry_path.empty() || !content.points_m.empty() ||
           (content.lines && !content.lines->empty()) || content.grid || !content.surveys.empty() ||
           content.cloud;
}

SceneContent scene_from_run(const fs::path& folder) {
    SceneContent content;
    if (fs::exists(folder / "trajectory.tum"))
        content.estimated_path = path_from_tum(folder / "trajectory.tum");
    if (fs::exists(folder / "odometry.tum")) content.odometry_path = path_from_tum(folder / "odometry.tum");
    if (fs::exists(folder / "map.lines.csv")) content.lines = read_line_map_csv(folder / "map.lines.csv");
    for (const auto& file : files_like(folder, "map.", ".ply")) {
        if (file.filename() == "map.cloud.ply") {
            content.cloud = points_of_file(file);
            continue;
        }
        if (file.filename().string().rfind("map.points", 0) != 0) {
            add_survey(file, content);
            continue;
        }
        const bool is_odometry = file.filename().string().find("odometry") != std::string::npos;
        auto& all = is_odometry ? content.points_odometry_m : content.points_m;
        const auto points_m = finite_points(*points_of_file(file));
        all.insert(all.end(), points_m.begin(), points_m.end());
    }
    for (const char* end : {".gridmap", ".yaml"})
        if (const auto grids = files_like(folder, "map.", end); !content.grid && !grids.empty())
            content.grid = grid_from(grids.front());
    return content;
}

SceneContent scene_from_file(const fs::path& file) {
    SceneContent content;
    const std::string extension = file.extension().string();
    if (extension == ".tum") {
        (file.filename() == "odometry.tum" ? content.odometry_path : content.estimated_path) =
            path_from_tum(file);
    } else if (extension == ".ply" || extension == ".pcd" || extension == ".las") {
        const auto points = points_of_file(file);
        if (are_cloud(*points))
            content.cloud = points;
        else
            content.points_m = finite_points(*points);
    } else if (extension == ".gridmap" || extension == ".yaml") {
        content.grid = grid_from(file);
    } else if (extension == ".simplemap") {
        add_simple_map(file, content);
    } else if (extension == ".csv") {
        content.lines = read_line_map_csv(file);
    } else {
        throw CommandError(exit_input_data,
                           file.string() +
                               " is of no kind that can be drawn; a run directory, .tum, .ply, .pcd, .las, "
                               ".gridmap, .yaml, .simplemap or a map.lines.csv can.");
    }
    return content;
}

}  // namespace

SceneContent scene_from_path(const std::filesystem::path& run_directory_or_file) {
    const fs::path& path = run_directory_or_file;
    std::error_code error;
    if (!fs::exists(path, error))
        throw CommandError(exit_input_data, "There is no file or folder " + path.string() + ".");
    const bool is_folder = fs::is_directory(path, error);
    SceneContent content = is_folder ? scene_from_run(path) : scene_from_file(path);
    if (!has_content(content))
        throw CommandError(exit_input_data,
                           path.string() + " holds nothing to draw" +
                               (is_folder ? ": no trajectory.tum, odometry.tum or map.* of a run." : "."));
    const fs::path whole = fs::absolute(path, error).lexically_normal();
    content.title = (whole.has_filename() ? whole : whole.parent_path()).filename().string();
    return content;
}

}  // namespace loopline
