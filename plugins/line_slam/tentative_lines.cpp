#include "line_slam/tentative_lines.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "line_slam/line_observation.h"

namespace loopline::line_slam {
namespace {

LineObservation in_map(const Pose2& T_map_base, const LineObservation& z) {
    LineObservation m;
    m.line = transformed(T_map_base, z.line);
    const Eigen::Matrix2d G = augmentation_jacobians(T_map_base, m.line).observation;
    m.covariance = G * z.covariance * G.transpose();
    m.start_m = T_map_base * z.start_m;
    m.end_m = T_map_base * z.end_m;
    return m;
}

}  // namespace

void TentativeLines::move(const Eigen::Matrix3d& motion_error_covariance) {
    for (TentativeLine& t : lines_) t.drift += motion_error_covariance;
}

TentativeLine& TentativeLines::add(const Pose2& T_map_base, const LineObservation& observation, int scan,
                                   int& next_track) {
    const LineObservation z = in_map(T_map_base, observation);
    TentativeLine* best = nullptr;
    double least = parameters_.gate;
    for (TentativeLine& t : lines_) {
        const Eigen::Vector2d v = innovation(z.line, t.latest.line);
        const Matrix23 from_drift = augmentation_jacobians(T_map_base, z.line).pose;
        const Eigen::Matrix2d S =
            z.covariance + t.latest.covariance + from_drift * t.drift * from_drift.transpose();
        const double distance2 = v.dot(S.llt().solve(v));
        if (distance2 >= least) continue;
        if (t.extent.overlap_m(Extent::of(t.latest.line, z.start_m, z.end_m)) < -parameters_.max_gap_m)
            continue;
        least = distance2;
        best = &t;
    }
    if (!best) {
        lines_.push_back(
            {z, Extent::of(z.line, z.start_m, z.end_m), Eigen::Matrix3d::Zero(), next_track++, 0, scan - 1});
        best = &lines_.back();
    }
    const Extent seen = Extent::of(z.line, z.start_m, z.end_m);
    best->extent.extend(seen);
    best->latest = z;
    best->drift.setZero();
    if (best->last_scan != scan) ++best->scans;
    best->last_scan = scan;
    return *best;
}

void TentativeLines::remove(int track) {
    lines_.erase(
        std::remove_if(lines_.begin(), lines_.end(), [&](const auto& t) { return t.track == track; }),
        lines_.end());
}

void TentativeLines::forget_stale(int scan) {
    lines_.erase(
        std::remove_if(lines_.begin(), lines_.end(),
                       [&](const auto& t) { return scan - t.last_scan > parameters_.patience_scans; }),
        lines_.end());
}

}  // namespace loopline::line_slam
