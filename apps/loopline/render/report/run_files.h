/// What the report needs from a run directory. A file that is missing or damaged leaves its part empty: a
/// report of half a run is better than none.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "output/tum.h"

namespace loopline {

/// A row of covariance.csv: standard deviations of x, y (m) and heading (rad).
struct Sigma {
    StampNs stamp_ns = 0;
    double x_m = 0, y_m = 0, yaw_rad = 0;
};

struct RunFile {
    std::string path;  ///< relative to the run directory
    std::uintmax_t bytes = 0;
};

struct RunFiles {
    std::filesystem::path folder;
    nlohmann::ordered_json metrics = nlohmann::ordered_json::object();
    nlohmann::ordered_json manifest = nlohmann::ordered_json::object();
    std::vector<StampedPose> estimate, odometry;
    std::vector<Sigma> sigmas;
    std::string config_ini;
    std::string feature_points_table;  ///< table1.md
    std::vector<RunFile> files;        ///< all of them but the report itself, in name order
};

RunFiles read_run_files(const std::filesystem::path& folder);

}  // namespace loopline
