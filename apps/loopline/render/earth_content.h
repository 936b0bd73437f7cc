/// What pictures of a path on the Earth show.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "evaluate/evaluation_reference.h"
#include "pipeline/run_record.h"

namespace loopline {

/// The run at one time. What is not known there is not finite.
struct EarthMoment {
    double time_s = 0;  ///< since the first
    double way_m = 0;   ///< of the result since then
    /// In the frame of the run's trajectory.
    Eigen::Vector3d p_m = unknown(), p_uncorrected_m = unknown(), p_true_m = unknown();
    double height_m = 0, height_uncorrected_m = NAN, height_true_m = NAN;  ///< above the ellipsoid
    /// Of the result against the truth: east, north, up in m, heading in rad.
    Eigen::Vector4d error = Eigen::Vector4d::Constant(NAN), sigma = Eigen::Vector4d::Constant(NAN);

    static Eigen::Vector3d unknown() { return Eigen::Vector3d::Constant(NAN); }
};

struct EarthContent {
    std::string title;
    std::string uncorrected_name;  ///< "without fixes"
    std::vector<EarthMoment> moments;
    bool has_truth = false;
    bool cloud_lies_below = false;  ///< the run's cloud is in the frame of the trajectory
    std::vector<Eigen::Vector2d> fixes_used_m, fixes_refused_m;
};

/// None if the run's trajectory is not on the Earth or there is nothing to compare it with. A truth counts if
/// its place on the Earth is known.
std::optional<EarthContent> earth_content(const RunRecord& record, const EvaluationReference* reference,
                                          const std::string& title);

}  // namespace loopline
