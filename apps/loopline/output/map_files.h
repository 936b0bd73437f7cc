/// The files of all maps of a run, by kind.
#pragma once

#include <mrpt/maps/CPointsMap.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "api/results.h"
#include "output/file_list.h"

namespace loopline {

/// Lines, grids, points, survey clouds and simple maps as `map.NAME.*`; NAME is "lines", "grid" or "points"
/// (and a simple map is plainly map.simplemap) where the kind has one map, the map's own name where it has
/// several. A survey cloud always has its own name.
void write_map_files(const std::filesystem::path& folder, const Results& results, FileList& list);

/// Scan points but survey clouds, each with the stem of its files.
std::vector<std::pair<std::string, mrpt::maps::CPointsMap::Ptr>> point_maps(const Results& results);

/// The points by dead reckoning as map.points_odometry.ply, for pictures of before and after; nothing if
/// there are none. Survey clouds as map.NAME_odometry.ply and .pcd.
void write_odometry_points(const std::filesystem::path& folder, const Results& odometry_results,
                           FileList& list);

}  // namespace loopline
