#include "render/earth_content.h"

#include <cmath>

#include "evaluate/association.h"
#include "gnss/geo_reference.h"

namespace loopline {
namespace {

constexpr double max_difference_s = 0.1;  // to the nearest truth

/// The truth in the frame of the run's trajectory.
class TruthOnEarth {
 public:
    TruthOnEarth(const EvaluationReference& reference, const EarthFrame& earth)
        : poses_(reference.truth, max_difference_s, ReferencePoses::Kind::poses_between),
          T_map_ref_(
              gnss::T_between(gnss::GeoReference(earth), gnss::GeoReference(*reference.surveyed.earth))) {}

    std::optional<Pose3> at(StampNs stamp_ns) {
        const auto pose = poses_.at(stamp_ns);
        return pose ? std::optional(T_map_ref_ * *pose) : std::nullopt;
    }

 private:
    ReferencePoses poses_;
    Pose3 T_map_ref_;
};

void set_error(const TrajectoryEntry& entry, const Pose3& T_map_base_true, const Eigen::Matrix3d& R_enu_map,
               EarthMoment& moment) {
    const Pose3& T_map_base = entry.T_map_base;
    const Eigen::Matrix3d covariance_enu =
        R_enu_map * entry.covariance.matrix().topLeftCorner<3, 3>() * R_enu_map.transpose();
    moment.error << R_enu_map * (T_map_base.translation_m - T_map_base_true.translation_m),
        wrap_to_pi(T_map_base.yaw_rad() - T_map_base_true.yaw_rad());
    moment.sigma << covariance_enu.diagonal().cwiseSqrt(), std::sqrt(entry.covariance(5, 5));
}

void add_fixes(const PlacedFixes& fixes, EarthContent& content) {
    if (fixes.empty()) return;
    fixes.list->for_each(0, fixes.list->size(), [&content](const PlacedFix& fix) {
        auto& list = fix.fate == 0 ? content.fixes_used_m : content.fixes_refused_m;
        list.emplace_back(fix.p_map_m[0], fix.p_map_m[1]);
    });
}

}  // namespace

std::optional<EarthContent> earth_content(const RunRecord& record, const EvaluationReference* reference,
                                          const std::string& title) {
    const Results& results = record.results;
    if (record.trajectory == nullptr || !results.earth || !results.uncorrected) return std::nullopt;
    EarthContent content;
    content.title = title;
    content.cloud_lies_below = record.cloud_on_trajectory;
    content.uncorrected_name = results.uncorrected->name;
    const gnss::GeoReference frame(*results.earth);
    std::optional<TruthOnEarth> truth;
    if (reference != nullptr && reference->truth_has_orientation && reference->surveyed.earth &&
        !reference->truth.empty())
        truth.emplace(*reference, *results.earth);
    if (record.trajectory->empty()) return std::nullopt;
    const StampNs first_ns = (*record.trajectory)[0].stamp_ns;
    double way_m = 0;
    for (const TrajectoryEntry entry : record.trajectory->entries()) {
        if (!entry.T_map_base.translation_m.allFinite()) continue;
        EarthMoment moment;
        moment.p_m = entry.T_map_base.translation_m;
        if (!content.moments.empty()) way_m += (moment.p_m - content.moments.back().p_m).norm();
        moment.way_m = way_m;
        moment.time_s = seconds_between(first_ns, entry.stamp_ns);
        const auto other = results.uncorrected->path->find(entry.sequence);
        if (other) moment.p_uncorrected_m = other->T_map_base.translation_m;
        const auto true_pose = truth ? truth->at(entry.stamp_ns) : std::nullopt;
        if (true_pose) {
            content.has_truth = true;
            moment.p_true_m = true_pose->translation_m;
            set_error(entry, *true_pose, frame.R_enu_map(), moment);
        }
        moment.height_m = frame.geodetic(moment.p_m).height_m;
        moment.height_uncorrected_m = frame.geodetic(moment.p_uncorrected_m).height_m;
        moment.height_true_m = frame.geodetic(moment.p_true_m).height_m;
        content.moments.push_back(moment);
    }
    if (content.moments.empty()) return std::nullopt;
    add_fixes(results.fixes, content);
    return content;
}

}  // namespace loopline
