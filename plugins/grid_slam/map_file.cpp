#include "grid_slam/map_file.h"

#include <algorithm>
#include <vector>

#include "api/parameters.h"

namespace loopline::grid_slam {
namespace {

namespace fs = std::filesystem;

/// Maps in a run directory, in the order of their names.
std::vector<fs::path> maps_in(const fs::path& folder) {
    std::vector<fs::path> maps;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(folder, none))
        if (entry.path().extension() == ".yaml") maps.push_back(entry.path());
    std::sort(maps.begin(), maps.end());
    return maps;
}

}  // namespace

fs::path yaml_of_map(const fs::path& named, std::string& problem) {
    std::error_code none;
    if (!fs::is_directory(named, none)) {
        fs::path yaml = named;
        const bool is_description = yaml.extension() == ".yaml" || yaml.extension() == ".yml";
        return is_description ? yaml : yaml.replace_extension(".yaml");
    }
    if (const fs::path usual = named / "map.grid.yaml"; fs::exists(usual, none)) return usual;
    const auto maps = maps_in(named);
    if (maps.size() == 1) return maps.front();
    problem = maps.empty() ? "there is no grid map in the folder " + named.string() +
                                 "; run an experiment with [run] maps = grid, or name a map's YAML file"
                           : "there are " + std::to_string(maps.size()) + " grid maps in the folder " +
                                 named.string() + "; name the YAML file of one";
    return {};
}

bool read_map(const fs::path& named, MapServerMap& map, std::string& problem) {
    const fs::path yaml = yaml_of_map(named, problem);
    if (!problem.empty()) return false;
    if (!read_map_server_map(yaml, map, problem)) {
        problem = "can't read the grid map " + yaml.string() + ": " + problem +
                  "; give a YAML file as map_server and map_saver have it";
        return false;
    }
    constexpr double finest_m = 0.01, coarsest_m = 0.5;
    const auto has = [&map](MapCell cell) {
        return std::find(map.cells.begin(), map.cells.end(), cell) != map.cells.end();
    };
    if (map.resolution_m < finest_m - 1e-9 || map.resolution_m > coarsest_m + 1e-9)
        problem = "the grid map " + yaml.string() + " has a resolution of " + number_text(map.resolution_m) +
                  " m; give one with cells of 0.01 to 0.5 m";
    else if (!has(MapCell::occupied))
        problem = "the grid map " + yaml.string() +
                  " has no occupied cell; check its thresholds and negate, or give another map";
    else if (!has(MapCell::free))
        problem = "the grid map " + yaml.string() +
                  " has no free cell; check its thresholds and negate, or give another map";
    return problem.empty();
}

}  // namespace loopline::grid_slam
