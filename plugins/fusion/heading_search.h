/// Heading and place of a local path on the Earth, from the fixes along it: no pose has to be given (row
/// C11).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "api/pose3.h"
#include "gnss/fix_noise.h"

namespace loopline::fusion {

/// One fix beside the path: where the antenna was by the path, and by the fix.
struct SeenFix {
    double time_s = 0;
    Eigen::Vector3d p_local_m, p_enu_m;
    gnss::SigmaOfFix sigma;
};

struct FoundHeading {
    Pose3 T_enu_local;     ///< level: the local frame's z axis is taken to point up
    double sigma_rad = 0;  ///< of the heading
    double misfit = 0;     ///< mean of the normalised squares of what is left: 1 if the noise is as thought
};

/// The best heading and place, all fixes weighted by the inverse of their joint covariance, since slow errors
/// are nearly the same in neighbouring fixes: closed form, generalised least squares in the plane. None if
/// the path has no extent or the covariance can't be inverted.
std::optional<FoundHeading> find_heading(const std::vector<SeenFix>& fixes);

/// Squared distance of two fixes from what a path, turned by `heading`, has between their places, normalised:
/// 2 are expected by chance. What slow errors they share does not count.
double disagreement(const SeenFix& a, const SeenFix& b, const Eigen::Rotation2Dd& heading,
                    double sigma_heading_rad);

/// The most that one heading explains, in the order of time: signals that were reflected are left out.
/// (Consensus of samples: Fischler and Bolles 1981; here all pairs that are far enough apart.)
std::vector<SeenFix> agreeing(const std::vector<SeenFix>& fixes);

}  // namespace loopline::fusion
