/// Feature points of a run as feature_points.csv, and as table1.md to read: table 1 of Hu 2012.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "evaluate/evaluation_reference.h"
#include "evaluate/feature_points.h"

namespace loopline {

/// number,true_x_m,true_y_m,odometry_x_m,odometry_y_m,estimate_x_m,estimate_y_m: map frame, rounded to 0.001
/// mm; cells of odometry are empty where there is none.
void write_feature_points_csv(const std::filesystem::path& file, const std::vector<PointEstimate>& points);

/// A Markdown table with the error of each point in mm, their mean, RMS and maximum, and beside them the
/// errors of `published` figures for the points of the same number.
std::string feature_points_table(const std::vector<PointEstimate>& points,
                                 const std::vector<PublishedPoint>& published);

}  // namespace loopline
