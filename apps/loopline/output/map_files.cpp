#include "output/map_files.h"

#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/maps/CSimpleMap.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "output/file_name.h"
#include "output/g2o.h"
#include "output/line_map_csv.h"
#include "output/line_map_geojson.h"
#include "output/map_server_grid.h"
#include "output/mrpt_object_file.h"
#include "output/point_cloud_files.h"

namespace loopline {
namespace {

namespace fs = std::filesystem;
using mrpt::maps::CSimpleMap;

/// The maps of one class with the stem of their files: `only` for a single one, else "map.NAME", numbered if
/// two have the same name.
template <class Map>
std::vector<std::pair<std::string, std::shared_ptr<Map>>> maps_of_kind(const Results& results,
                                                                       const std::string& only) {
    std::vector<std::pair<std::string, std::shared_ptr<Map>>> found;
    for (const auto& named : results.maps)
        if (auto map = named.survey ? nullptr : std::dynamic_pointer_cast<Map>(named.map)) {
            const std::string stem = "map." + as_file_name(named.name);
            const auto taken = [&found](const std::string& s) {
                return std::any_of(found.begin(), found.end(), [&s](const auto& f) { return f.first == s; });
            };
            std::string free_stem = stem;
            for (int i = 2; taken(free_stem); ++i) free_stem = stem + "_" + std::to_string(i);
            found.emplace_back(free_stem, std::move(map));
        }
    if (found.size() == 1) found[0].first = only;
    return found;
}

void write_cloud(const fs::path& folder, const std::string& stem, const mrpt::maps::CPointsMap& points,
                 FileList& list) {
    list.add(stem + ".ply", write_ply(folder / (stem + ".ply"), points), "points");
    list.add(stem + ".pcd", write_pcd(folder / (stem + ".pcd"), points), "points");
}

/// Survey clouds, each under its own name.
void write_surveys(const fs::path& folder, const Results& results, const std::string& suffix,
                   FileList& list) {
    for (const auto& named : results.maps)
        if (const auto cloud = std::dynamic_pointer_cast<mrpt::maps::CPointsMap>(named.map);
            cloud && named.survey)
            write_cloud(folder, "map." + as_file_name(named.name) + suffix, *cloud, list);
}

void write_lines(const fs::path& folder, const LineMap& lines, FileList& list) {
    list.add("map.lines.csv", write_line_map_csv(folder / "map.lines.csv", lines), "lines");
    list.add("map.lines.geojson", write_line_map_geojson(folder / "map.lines.geojson", lines), "lines");
}

/// Keyframes whose pose is finite, and how many were not.
std::pair<CSimpleMap, std::size_t> finite_keyframes(const CSimpleMap& map) {
    std::pair<CSimpleMap, std::size_t> result{{}, 0};
    for (std::size_t i = 0; i < map.size(); ++i) {
        auto [pose, frame] =
            const_cast<CSimpleMap&>(map).get(i);  // insert() wants what get() const doesn't give
        const auto mean = pose->getMeanVal();
        if (std::isfinite(mean.norm()) && std::isfinite(mean.yaw()) && std::isfinite(mean.pitch()) &&
            std::isfinite(mean.roll()))
            result.first.insert(pose, frame);
        else
            ++result.second;
    }
    return result;
}

}  // namespace

void write_map_files(const fs::path& folder, const Results& results, FileList& list) {
    if (results.line_map) write_lines(folder, *results.line_map, list);
    for (const auto& [stem, grid] : maps_of_kind<mrpt::maps::COccupancyGridMap2D>(results, "map.grid")) {
        write_map_server_grid(folder / (stem + ".yaml"), *grid);
        list.add(stem + ".pgm");
        list.add(stem + ".yaml");
        write_mrpt_object(folder / (stem + ".gridmap"), *grid);
        list.add(stem + ".gridmap");
    }
    for (const auto& [stem, points] : point_maps(results)) write_cloud(folder, stem, *points, list);
    write_surveys(folder, results, "", list);
    for (const auto& [stem, simple_map] : maps_of_kind<CSimpleMap>(results, "map")) {
        const auto [map, left_out] = finite_keyframes(*simple_map);
        write_mrpt_object(folder / (stem + ".simplemap"), map);
        list.add(stem + ".simplemap", left_out, "keyframes");
    }
    if (results.pose_graph && !results.pose_graph->poses.empty())
        list.add("pose_graph.g2o", write_g2o(folder / "pose_graph.g2o", *results.pose_graph),
                 "poses and constraints");
}

std::vector<std::pair<std::string, mrpt::maps::CPointsMap::Ptr>> point_maps(const Results& results) {
    return maps_of_kind<mrpt::maps::CPointsMap>(results, "map.points");
}

void write_odometry_points(const fs::path& folder, const Results& odometry_results, FileList& list) {
    const std::string stem = "map.points_odometry";
    for (const auto& [name, points] : maps_of_kind<mrpt::maps::CPointsMap>(odometry_results, stem)) {
        const std::string file = (name == stem ? stem : stem + name.substr(3)) + ".ply";
        list.add(file, write_ply(folder / file, *points), "points");
    }
    write_surveys(folder, odometry_results, "_odometry", list);
}

}  // namespace loopline
