/// Which observation belongs to which map line. Hu, Chen, Zhang 2012, section 3.4, eq. (13), with what a line
/// needs beyond it: the seen parts must overlap, and pairings must agree with one another.
#pragma once

#include <vector>

#include "line_slam/ekf.h"
#include "line_slam/map_lines.h"

namespace loopline::line_slam {

enum class AssociationMethod {
    nearest,     ///< the paper's: each observation by itself, the map line with the least distance
    sequential,  ///< each given the ones before it, the longest first
    jcbb         ///< joint compatibility branch and bound: the largest set that agrees. Neira and Tardos 2001
};

struct AssociationParameters {
    AssociationMethod method = AssociationMethod::sequential;
    double probability = 0.999;  ///< of the gates, for the joint distance of more than one pairing
    double gate = 13.8;          ///< squared Mahalanobis distance of two degrees of freedom (0.999)
    double max_gap_m = 1.0;      ///< between the seen part of a map line and the observed one
    // A line out of sight for a while, alone, may not move the vehicle by more: one wall is easily taken for
    // the next. More takes several lines that agree, see place_recognition.h.
    double max_surprise_m = 0.15;
    double max_surprise_rad = 0.06;
};

struct Association {
    std::vector<Pairing> pairings;    ///< ordered by observation
    std::vector<bool> is_compatible;  ///< per observation: some line was within its own gate, paired or not
    int refused = 0;                  ///< observations within a line's gate that contradicted longer ones
};

/// Awake active lines alone take part.
Association associate(const Ekf& filter, const MapLineRecords& records,
                      const std::vector<LineObservation>& observations,
                      const AssociationParameters& parameters);

/// Common length of the seen part of a map line and an observation's part along it; negative: the gap.
double overlap_m(const Pose2& T_map_base, const PlanarLine& line_map, const Extent& seen,
                 const LineObservation& observation);

}  // namespace loopline::line_slam
