/// What of the filter goes into a checkpoint.
#pragma once

#include "api/state_archive.h"
#include "line_slam/ekf.h"

namespace loopline::line_slam {

template <class Archive>
void fields(Archive& archive, PlanarLine& line) {
    archive(line.rho_m, line.alpha_rad);
}

template <class Archive>
void fields(Archive& archive, WheelCalibration& calibration) {
    archive(calibration.left, calibration.right, calibration.track);
}

template <class Archive>
void fields(Archive& archive, Compression& c) {
    archive(c.phi, c.psi, c.chi);
}

template <class Archive>
void fields(Archive& archive, LocalMap& map) {
    archive(map.lines, map.origin_m, map.P, map.since_entered, map.kept);
}

template <class Archive>
void fields(Archive& archive, Ekf& ekf) {
    archive(ekf.T_map_base_, ekf.calibration_, ekf.lines_, ekf.lines_on_leaving_, ekf.first_normals_,
            ekf.anchors_m_);
    archive.each(ekf.slots_, [](auto& a, auto& slot) { a(slot.map, slot.position); });
    archive(ekf.maps_, ekf.motion_error_noise_, ekf.motion_error_covariance_);
}

}  // namespace loopline::line_slam
