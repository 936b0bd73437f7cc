#include "lidar_mapping/lasting_error.h"

#include <algorithm>
#include <cmath>

#include "api/dense_algebra.h"

namespace loopline::lidar_mapping {
namespace {

/// By which a turn counts as much as a shift: it counts by what it moves.
Vector6d lever_of(const Registration& found) {
    return (Vector6d() << 1, 1, 1, Eigen::Vector3d::Constant(found.mean_range_m)).finished();
}

}  // namespace

Matrix6d what_is_new(const Registration& found, const Matrix6d& before) {
    const Vector6d lever = lever_of(found);
    const Matrix6d more = found.by_prediction - propagated(found.left, before);
    const Spectrum spectrum = spectrum_of(lever.asDiagonal() * more * lever.asDiagonal());
    const Matrix6d directions = lever.cwiseInverse().asDiagonal() * spectrum.vectors;
    return propagated(directions, spectrum.values.cwiseMax(0.0).asDiagonal().toDenseMatrix());
}

Matrix6d of_coming_back(const Registration& found, const Matrix6d& before) {
    const Vector6d back = before * solved(found.predicted, found.correction);
    return back * back.transpose();
}

Matrix6d what_lasts(const Registration& found) {
    // Where the surroundings hold a sweep better than this, it is not by chance.
    constexpr double well_held_m = 0.004;
    const Vector6d lever = lever_of(found);
    const Spectrum spectrum = spectrum_of(lever.asDiagonal() * found.by_scan * lever.asDiagonal());
    const double renewed = 1 / std::max(1.0, found.age_sweeps);
    Vector6d lasting_m2 = spectrum.values.cwiseMax(0);
    for (double& m2 : lasting_m2) {
        const double doubt = std::pow(m2 / (well_held_m * well_held_m), 2);
        m2 *= renewed + (1 - renewed) * doubt / (1 + doubt);
    }
    const Matrix6d directions = lever.cwiseInverse().asDiagonal() * spectrum.vectors;
    return propagated(directions, lasting_m2.asDiagonal().toDenseMatrix());
}

}  // namespace loopline::lidar_mapping
