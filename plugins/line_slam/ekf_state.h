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
void fields(Archive& archive, Ekf& ekf) {
    archive(ekf.T_map_base_, ekf.calibration_, ekf.lines_);
    archive.each(ekf.slots_, [](auto& a, auto& slot) { a(slot.part, slot.position); });
    archive(ekf.active_, ekf.passive_, ekf.motion_error_noise_, ekf.motion_error_covariance_);
    archive(ekf.P_aa_, ekf.P_ab_, ekf.P_bb_, ekf.phi_, ekf.psi_, ekf.chi_);
}

}  // namespace loopline::line_slam
