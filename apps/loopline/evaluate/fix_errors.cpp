#include "evaluate/fix_errors.h"

#include <algorithm>
#include <cmath>

#include "gnss/gps_observation.h"

namespace loopline {

void FixErrors::Sums::add(const Eigen::Vector3d& error_m, bool has_height) {
    ++fixes;
    horizontal_m2 += error_m.head<2>().squaredNorm();
    most_horizontal_m = std::max(most_horizontal_m, error_m.head<2>().norm());
    if (!has_height) return;
    ++heights;
    vertical_m2 += error_m.z() * error_m.z();
}

void FixErrors::Sums::write(const std::string& prefix, std::map<std::string, MetricValue>& metrics) const {
    metrics[prefix + "horizontal_rmse_m"] = std::sqrt(horizontal_m2 / static_cast<double>(fixes));
    metrics[prefix + "horizontal_max_m"] = most_horizontal_m;
    metrics[prefix + "fixes_compared"] = static_cast<std::int64_t>(fixes);
    if (heights > 0)
        metrics[prefix + "vertical_rmse_m"] = std::sqrt(vertical_m2 / static_cast<double>(heights));
}

FixErrors::FixErrors(const std::shared_ptr<const EvaluationReference>& reference)
    : reference_(reference),
      truth_(reference->truth, 0.1, ReferencePoses::Kind::poses_between),
      frame_(*reference->surveyed.earth) {}

std::unique_ptr<FixErrors> FixErrors::against(const std::shared_ptr<const EvaluationReference>& reference) {
    if (!reference || reference->truth.empty() || !reference->truth_has_orientation ||
        !reference->surveyed.earth)
        return nullptr;
    return std::unique_ptr<FixErrors>(new FixErrors(reference));
}

void FixErrors::take(const mrpt::obs::CObservationGPS& observation, StampNs stamp_ns) {
    const auto fix = gnss::fix_from_mrpt(observation, stamp_ns);
    if (!fix || !fix->has_position) return;
    const auto T_ref_base = truth_.at(stamp_ns);
    if (!T_ref_base) return;
    const Eigen::Vector3d p_ref_antenna_m = *T_ref_base * fix->p_base_antenna_m;
    gnss::Geodetic place = fix->antenna;
    // Without a height, the fix is put at the antenna's: nothing horizontal depends on it.
    if (!fix->has_height) place.height_m = frame_.geodetic(p_ref_antenna_m).height_m;
    const Eigen::Vector3d error_m = frame_.p_map_m(place) - p_ref_antenna_m;
    all_.add(error_m, fix->has_height);
    by_label_[observation.sensorLabel].add(error_m, fix->has_height);
}

std::map<std::string, MetricValue> FixErrors::metrics() const {
    std::map<std::string, MetricValue> metrics;
    if (all_.fixes == 0) return metrics;
    all_.write("gnss_", metrics);
    if (by_label_.size() > 1)
        for (const auto& [label, sums] : by_label_) sums.write("gnss_" + label + "_", metrics);
    return metrics;
}

}  // namespace loopline
