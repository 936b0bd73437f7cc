/// How far the points of a survey cloud lie from the true walls.
#pragma once

#include <mrpt/maps/CPointsMap.h>

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "api/pose3.h"
#include "evaluate/surveyed_truth.h"

namespace loopline {

double distance_to_wall_m(const Eigen::Vector3d& p_m, const TrueWall& wall);

/// The nearest of many walls, exactly: space is divided into cubes, each with the walls that are the nearest
/// one to some point in it. With d(c) a wall's distance to the cube's centre and h half the cube's diagonal,
/// no wall with d(c) > min d(c) + 2 h can be.
class WallDistance {
 public:
    explicit WallDistance(std::vector<TrueWall> walls) : walls_(std::move(walls)) {}
    /// To the nearest wall; infinite if there is none.
    double operator()(const Eigen::Vector3d& p_m);

 private:
    const std::vector<std::size_t>& candidates(const Eigen::Vector3d& p_m);

    std::vector<TrueWall> walls_;
    std::unordered_map<std::uint64_t, std::vector<std::size_t>> cubes_;
};

struct CloudDistance {
    std::size_t points = 0;  ///< that count
    double median_m = 0, percentile_95_m = 0;
};

/// Of the points that are neither within 10 cm of a level (a floor is near itself wherever the vehicle
/// thought to be) nor below the lowest or above the highest of the levels. `T_truth_map` takes the cloud into
/// the truth's frame.
CloudDistance cloud_to_walls(const mrpt::maps::CPointsMap& cloud, const Pose3& T_truth_map,
                             const SurveyedTruth& truth);

}  // namespace loopline
