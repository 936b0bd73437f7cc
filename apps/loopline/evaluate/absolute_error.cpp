#include "evaluate/absolute_error.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace loopline {
namespace {

bool is_level(const Eigen::Quaterniond& q) {
    return std::hypot(q.x(), q.y()) < 0.5e-6;
}

template <class Pairs>
Pose3 planar_alignment(const Pairs& pairs) {
    const auto n = static_cast<double>(pairs.size());
    if (pairs.empty()) return {};
    Eigen::Vector2d mean_estimate_m(0, 0), mean_reference_m(0, 0);
    for (const PosePair& pair : pairs) {
        mean_estimate_m += pair.T_map_base_estimate.translation_m.head<2>() / n;
        mean_reference_m += pair.T_ref_base_reference.translation_m.head<2>() / n;
    }
    double cross = 0, dot = 0;
    for (const PosePair& pair : pairs) {
        const Eigen::Vector2d a = pair.T_map_base_estimate.translation_m.head<2>() - mean_estimate_m;
        const Eigen::Vector2d b = pair.T_ref_base_reference.translation_m.head<2>() - mean_reference_m;
        cross += a.x() * b.y() - a.y() * b.x();
        dot += a.dot(b);
    }
    const Pose2 turn{0, 0, std::atan2(cross, dot)};
    const Eigen::Vector2d shift_m = mean_reference_m - turn * mean_estimate_m;
    return Pose3(Pose2{shift_m.x(), shift_m.y(), turn.phi_rad});
}

/// Pairs may lie on disk, so they are gone through twice rather than gathered in matrices for
/// Eigen::umeyama().
template <class Pairs>
Pose3 spatial_alignment(const Pairs& pairs) {
    if (pairs.empty()) return {};
    const auto n = static_cast<double>(pairs.size());
    Eigen::Vector3d mean_estimate_m(0, 0, 0), mean_reference_m(0, 0, 0);
    for (const PosePair& pair : pairs) {
        mean_estimate_m += pair.T_map_base_estimate.translation_m / n;
        mean_reference_m += pair.T_ref_base_reference.translation_m / n;
    }
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // Umeyama 1991, eq. (38)
    for (const PosePair& pair : pairs)
        covariance += (pair.T_ref_base_reference.translation_m - mean_reference_m) / n *
                      (pair.T_map_base_estimate.translation_m - mean_estimate_m).transpose();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d sign(1, 1, 1);  // eq. (39): no reflection
    if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign.z() = -1;
    const Eigen::Matrix3d R = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();  // eq. (40)
    return {mean_reference_m - R * mean_estimate_m, Eigen::Quaterniond(R).normalized()};      // eq. (41)
}

template <class Pairs>
bool all_planar(const Pairs& pairs) {
    if (pairs.empty()) return true;
    const Pose3 first_estimate = pairs[0].T_map_base_estimate,
                first_reference = pairs[0].T_ref_base_reference;
    return std::all_of(pairs.begin(), pairs.end(), [&](const PosePair& pair) {
        const Pose3 &estimate = pair.T_map_base_estimate, &reference = pair.T_ref_base_reference;
        return is_level(estimate.rotation) && is_level(reference.rotation) &&
               std::abs(estimate.translation_m.z() - first_estimate.translation_m.z()) < 1e-6 &&
               std::abs(reference.translation_m.z() - first_reference.translation_m.z()) < 1e-6;
    });
}

template <class Pairs>
AbsoluteError error_of(const Pairs& pairs, Alignment alignment) {
    AbsoluteError error;
    if (alignment == Alignment::automatic)
        alignment = all_planar(pairs) ? Alignment::planar : Alignment::spatial;
    error.alignment = alignment;
    error.distances_m.reserve(pairs.size());
    if (alignment == Alignment::planar) error.T_ref_map = planar_alignment(pairs);
    if (alignment == Alignment::spatial) error.T_ref_map = spatial_alignment(pairs);
    for (const PosePair& pair : pairs) {
        const Eigen::Vector3d e = error.T_ref_map * pair.T_map_base_estimate.translation_m -
                                  pair.T_ref_base_reference.translation_m;
        error.distances_m.push_back(alignment == Alignment::planar ? e.head<2>().norm() : e.norm());
    }
    error.distance_m = statistics_of(error.distances_m);
    return error;
}

}  // namespace

Pose3 align_planar(const std::vector<PosePair>& pairs) {
    return planar_alignment(pairs);
}

Pose3 align_spatial(const std::vector<PosePair>& pairs) {
    return spatial_alignment(pairs);
}

bool is_planar(const std::vector<PosePair>& pairs) {
    return all_planar(pairs);
}

AbsoluteError absolute_error(const std::vector<PosePair>& pairs, Alignment alignment) {
    return error_of(pairs, alignment);
}

AbsoluteError absolute_error(const PosePairs& pairs, Alignment alignment) {
    return error_of(pairs, alignment);
}

}  // namespace loopline
