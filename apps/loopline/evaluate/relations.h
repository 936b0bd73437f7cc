/// The relations metric: how well does a trajectory reproduce hand-checked motions between pairs of times?
/// Kuemmerle et al. 2009, "On measuring the accuracy of SLAM algorithms", eq. (4) with absolute errors.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "evaluate/statistics.h"
#include "output/tum.h"

namespace loopline {

struct Relation {
    StampNs first_ns = 0, second_ns = 0;
    Pose2 T_first_second;
};

/// Lines "t1 t2 x y z roll pitch yaw"; blank lines and "#" lines are skipped. z, roll and pitch are not used:
/// the metric is planar. Throws CommandError(exit_input_data), one sentence with file:line.
std::vector<Relation> read_relations(const std::filesystem::path& file);

struct RelationsSettings {
    double max_gap_s =
        2;  ///< a relation whose time is farther than this from both neighbouring poses is not used
};

struct RelationsError {
    std::size_t relations = 0;                          ///< in the file
    std::vector<double> translations_m, rotations_deg;  ///< of those that were used
    Statistics translation_m, rotation_deg;
};

/// The pose at the time of a relation is that of a trajectory pose within 2 microseconds, else it is
/// interpolated linearly between its neighbours in time; or, with `odometry` (not empty), the neighbour that
/// is nearer in time is carried there by the odometry's motion. The trajectory is sorted by stamp first.
RelationsError relations_error(const std::vector<Relation>& relations, std::vector<StampedPose> trajectory,
                               std::vector<StampedPose> odometry, const RelationsSettings& settings = {});

}  // namespace loopline
