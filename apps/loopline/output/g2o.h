/// A pose graph as g2o's text, which GTSAM, Ceres and most other tools for pose graphs read too.
#pragma once

#include <cstddef>
#include <filesystem>

#include "api/results.h"

namespace loopline {

/// VERTEX_SE2 in the order of the poses, numbered from 0, then EDGE_SE2 with the upper triangle of the
/// information. m and rad. A pose that is not finite is left out with its constraints, and so is a constraint
/// that is not finite or leads to no pose; returns how many were.
std::size_t write_g2o(const std::filesystem::path& file, const PoseGraph& graph);

}  // namespace loopline
