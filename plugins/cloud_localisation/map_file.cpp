#include "cloud_localisation/map_file.h"

#include <stdexcept>

namespace loopline::cloud_localisation {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t fewest_points = 1000;

}  // namespace

fs::path file_of_cloud(const fs::path& named, std::string& problem) {
    std::error_code none;
    if (!fs::is_directory(named, none)) return named;
    for (const char* name : {"map.cloud.ply", "map.cloud.pcd", "map.cloud.las"})
        if (fs::exists(named / name, none)) return named / name;
    problem = "there is no cloud map in the folder " + named.string() +
              "; run an experiment with module cloud_map or [run] maps = final_cloud_map, or name a PLY, PCD "
              "or LAS file";
    return {};
}

bool open_cloud_map(const fs::path& named, CloudMapFile& map, std::string& problem) {
    map.file = file_of_cloud(named, problem);
    if (!problem.empty()) return false;
    try {
        map.points = open_point_file(map.file);
        std::error_code none;
        if (const fs::path beside = map.file.parent_path() / "georeference.txt"; fs::exists(beside, none)) {
            map.georeference_file = beside;
            map.georeference = gnss::read_georeference(beside.string());
            const fs::path folder = map.file.parent_path();
            const PathFiles path{folder / "trajectory.tum", folder / "covariance.csv"};
            if (fs::exists(path.trajectory, none) && fs::exists(path.covariance, none)) map.path = path;
        }
    } catch (const PointFileError& error) {
        problem = std::string(error.what()) + "; give a PLY, PCD or LAS file as a run writes it";
    } catch (const std::runtime_error& error) {
        problem = error.what();
    }
    if (!problem.empty()) return false;
    if (map.points->size() < fewest_points)
        problem = map.file.string() + " has " + std::to_string(map.points->size()) +
                  " points, which make no map; give the cloud of a spinning lidar";
    else if (!map.points->grid_origin_m().isZero())
        problem = map.file.string() +
                  " lies on a grid of the Earth, whose axes are bent; give the cloud in its own frame, which "
                  "georeference.txt places there, such as map.cloud.ply of the same run";
    return problem.empty();
}

}  // namespace loopline::cloud_localisation
