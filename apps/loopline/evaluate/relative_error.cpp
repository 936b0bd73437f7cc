#include "evaluate/relative_error.h"

#include <cmath>

namespace loopline {

double rotation_angle_rad(const Eigen::Quaterniond& rotation) {
    return 2 * std::atan2(rotation.vec().norm(), std::abs(rotation.w()));
}

std::vector<double> reference_way_m(const std::vector<PosePair>& pairs) {
    std::vector<double> way_m(pairs.size(), 0.0);
    for (std::size_t i = 1; i < pairs.size(); ++i)
        way_m[i] = way_m[i - 1] + (pairs[i].T_ref_base_reference.translation_m -
                                   pairs[i - 1].T_ref_base_reference.translation_m)
                                      .norm();
    return way_m;
}

RelativeError relative_error(const std::vector<PosePair>& pairs, const RelativeStep& step) {
    const std::vector<double> way_m = reference_way_m(pairs);
    const auto apart = [&](std::size_t i, std::size_t j) {
        switch (step.unit) {
            case RelativeStep::Unit::seconds:
                return seconds_between(pairs[i].stamp_ns, pairs[j].stamp_ns);
            case RelativeStep::Unit::metres:
                return way_m[j] - way_m[i];
            case RelativeStep::Unit::poses:
                break;
        }
        return static_cast<double>(j - i);
    };
    // Half a nanosecond, and as little of a metre: a step that is exactly as long as asked for counts.
    constexpr double slack = 5e-10;

    RelativeError error;
    std::size_t j = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        j = std::max(j, i + 1);
        if (step.unit == RelativeStep::Unit::seconds) j = i + 1;  // stamps need not be in order
        while (j < pairs.size() && apart(i, j) < step.length - slack) ++j;
        if (j >= pairs.size()) continue;
        const Pose3 motion_reference =
            pairs[i].T_ref_base_reference.inverse() * pairs[j].T_ref_base_reference;
        const Pose3 motion_estimate = pairs[i].T_map_base_estimate.inverse() * pairs[j].T_map_base_estimate;
        const Pose3 difference = motion_reference.inverse() * motion_estimate;
        error.translations_m.push_back(difference.translation_m.norm());
        error.rotations_deg.push_back(rotation_angle_rad(difference.rotation) * 180 / M_PI);
    }
    error.translation_m = statistics_of(error.translations_m);
    error.rotation_deg = statistics_of(error.rotations_deg);
    return error;
}

}  // namespace loopline
