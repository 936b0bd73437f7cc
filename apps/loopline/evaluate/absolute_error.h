/// Absolute trajectory error (ATE): distances of the positions after the best rigid alignment. Sturm et al.
/// 2012, "A benchmark for the evaluation of RGB-D SLAM systems", section IV.
#pragma once

#include <vector>

#include "evaluate/association.h"
#include "evaluate/statistics.h"

namespace loopline {

enum class Alignment {
    automatic,  ///< planar if both trajectories are, else spatial
    planar,     ///< shift in x and y, turn about z; heights are not compared
    spatial,    ///< shift and rotation
    none        ///< the frames are the same
};

/// The rigid motion T_ref_map that brings the estimated positions onto the reference ones with the least sum
/// of squares, in the plane: Horn's closed form, phi = atan2(sum of cross products, sum of dot products) of
/// the centred points.
Pose3 align_planar(const std::vector<PosePair>& pairs);

/// The same in space, without scale: Umeyama 1991, "Least-squares estimation of transformation parameters".
Pose3 align_spatial(const std::vector<PosePair>& pairs);

/// All heights within a micrometre of the first, and no roll or pitch beyond a microradian, in both
/// trajectories.
bool is_planar(const std::vector<PosePair>& pairs);

struct AbsoluteError {
    Alignment alignment = Alignment::planar;  ///< the one that was used
    Pose3 T_ref_map;
    std::vector<double> distances_m;  ///< one a pair; in the plane if the alignment is planar
    Statistics distance_m;
};

AbsoluteError absolute_error(const std::vector<PosePair>& pairs, Alignment alignment);
AbsoluteError absolute_error(const PosePairs& pairs, Alignment alignment);

}  // namespace loopline
