#include "lidar_mapping/shared_errors.h"

#include <algorithm>
#include <cmath>

#include "api/dense_algebra.h"

namespace loopline::lidar_mapping {
namespace {

constexpr double first_ring_m = 8;  // each is twice as far

}  // namespace

void SharedErrors::add(const Eigen::Vector3d& arm_m, const SweepVector& gradient) {
    const double turns = std::atan2(arm_m.y(), arm_m.x()) / (2 * M_PI) + 0.5;
    const auto sector = std::min(static_cast<std::size_t>(turns * sectors), sectors - 1);
    std::size_t ring = 0;
    for (double end_m = first_ring_m; ring + 1 < rings && arm_m.norm() >= end_m; end_m *= 2) ++ring;
    clusters_[sector * rings + ring] += gradient;
}

/// With V such that V' alone V = I and V' S V = diag(lambda), S the sum over clusters of g g'.
SweepMatrix SharedErrors::covariance(const SweepMatrix& alone) const {
    // The largest eigenvalue of so few clusters that err by chance (Marchenko and Pastur 1967).
    static const double by_chance =
        std::pow(1 + std::sqrt(static_cast<double>(sweep_errors) / (sectors * rings)), 2);
    SweepMatrix together = SweepMatrix::Zero();
    for (const SweepVector& g : clusters_) together += g * g.transpose();
    const Spectrum spectrum = spectrum_relative_to(alone, together);
    if (!(spectrum.values[sweep_errors - 1] > by_chance)) return alone;
    const Eigen::VectorXd lambda = (spectrum.values.array() + (1 - by_chance)).cwiseMax(1.0);
    return propagated(alone * spectrum.vectors, lambda.asDiagonal().toDenseMatrix());
}

}  // namespace loopline::lidar_mapping
