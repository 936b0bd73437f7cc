/// What a picture shows, from a run in memory or from files.
#pragma once

#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/CPointsMap.h>

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/line_map.h"
#include "api/pose3.h"
#include "render/point_source.h"

namespace loopline {

struct RunRecord;

/// A survey cloud, with pictures of its own.
struct SurveyCloud {
    std::string name;
    mrpt::maps::CPointsMap::Ptr corrected;  ///< map frame; null if there is none
    mrpt::maps::CPointsMap::Ptr raw;        ///< by dead reckoning; null if there is none
};

struct SceneContent {
    std::string title;
    std::vector<Pose3> estimated_path;  ///< map frame
    std::vector<Pose3> odometry_path;   ///< map frame: both start at the same pose
    std::optional<LineMap> lines;
    std::vector<Eigen::Vector3f> points_m;           ///< scan points by the estimated path
    std::vector<Eigen::Vector3f> points_odometry_m;  ///< scan points by dead reckoning
    mrpt::maps::COccupancyGridMap2D::Ptr grid;       ///< null if there is none
    std::vector<SurveyCloud> surveys;
    /// Cloud of a map in three dimensions, drawn by its heights; null if there is none. What it is taken from
    /// outlives this.
    std::shared_ptr<const PointSource> cloud;
};

SceneContent scene_from_record(const RunRecord& record, const std::string& title);
/// A run directory, or one file: .tum, .ply, .pcd, .las, .gridmap, map_server .yaml, .simplemap, line .csv.
/// Throws CommandError(exit_input_data) with a sentence if there is nothing to draw.
SceneContent scene_from_path(const std::filesystem::path& run_directory_or_file);

}  // namespace loopline
