/// What was surveyed, or simulated, beside a log: feature points, walls and levels. A CSV file with the
/// columns
///     kind,number,x_m,y_m,x2_m,y2_m,bottom_m,top_m
/// of which a point needs the first four, a wall all eight, and a level (floor, ceiling) its height in the
/// third; a georeference has latitude_deg,longitude_deg,height_m,heading_deg of the frame there.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <vector>

#include "api/earth_frame.h"

namespace loopline {

/// A vertical edge: the corner of a wall, a door jamb.
struct FeaturePoint {
    int number = 0;
    Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
};

/// A vertical rectangle.
struct TrueWall {
    Eigen::Vector2d from_m = Eigen::Vector2d::Zero(), to_m = Eigen::Vector2d::Zero();
    double bottom_m = 0, top_m = 0;
};

/// In the frame of the true trajectory.
struct SurveyedTruth {
    std::vector<FeaturePoint> points;
    std::vector<TrueWall> walls;
    std::vector<double> levels_m;
    std::optional<EarthFrame> earth;
};

/// Rows of other kinds, a header and comments ("#") are passed over. Throws CommandError(exit_input_data)
/// with file:line if the file can't be read or a row is wrong; `what` says what it should be.
SurveyedTruth read_surveyed_truth(const std::filesystem::path& file, const std::string& what);

}  // namespace loopline
