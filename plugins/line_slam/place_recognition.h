/// Have we been here before? Lines of the last stretch of the path against lines unseen for long: the
/// displacement that brings most of the one onto the other, if there is one that stands out.
///
/// One line alone says little: corridors look alike. A displacement of the plane is fixed by two lines that
/// are not parallel; every such pair of pairings is tried, and those count that agree with it.
#pragma once

#include <optional>
#include <vector>

#include "line_slam/planar_line.h"

namespace loopline::line_slam {

struct RecognitionParameters {
    double max_shift_m = 0.5;  ///< of the displacement; grows by the next with the way
    double max_turn_rad = 0.1;
    double tolerance_m = 0.12;  ///< between matched lines over their common stretch
    double tolerance_rad = 0.06;
    int min_lines = 3;        ///< that agree, not all parallel
    double min_length_m = 5;  ///< of their common stretches together
    double min_share = 0.4;   ///< of the recent lines' length
    double max_rival = 0.7;   ///< score of the next best displacement elsewhere, as a share of the best
};

struct PlaceLine {
    int id = 0;
    PlanarLine line;
    Extent extent;
};

struct Recognition {
    Pose2 T_old_recent;  ///< displacement of the recent lines that puts them on the old ones
    std::vector<std::pair<int, int>> matches;  ///< (recent id, old id), ordered by recent id
    double score_m = 0;                        ///< common length
    double rival_m = 0;                        ///< of the best displacement elsewhere
};

/// `centre_m`: about which the displacement is bounded, the place of the vehicle.
std::optional<Recognition> recognise_place(const std::vector<PlaceLine>& recent,
                                           const std::vector<PlaceLine>& old, const Eigen::Vector2d& centre_m,
                                           const RecognitionParameters& parameters);

}  // namespace loopline::line_slam
