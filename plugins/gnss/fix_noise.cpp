#include "gnss/fix_noise.h"

#include <algorithm>
#include <cmath>

namespace loopline::gnss {

ErrorProcess process_of(FixQuality quality) {
    switch (quality) {
        case FixQuality::rtk_fixed:
            return ErrorProcess::fixed;
        case FixQuality::rtk_float:
            return ErrorProcess::floating;
        case FixQuality::differential:
        case FixQuality::pps:
            return ErrorProcess::differential;
        default:
            return ErrorProcess::single;
    }
}

SigmaOfFix sigma_of(const GnssFix& fix, const FixNoiseSettings& settings) {
    const ErrorProcess process = process_of(fix.quality);
    const FixNoise& noise = process == ErrorProcess::fixed          ? settings.fixed
                            : process == ErrorProcess::floating     ? settings.floating
                            : process == ErrorProcess::differential ? settings.differential
                                                                    : settings.single;
    const Eigen::Vector3d kind(1, 1, settings.vertical_factor);
    const double both_m = std::hypot(noise.white_m, noise.correlated_m);
    Eigen::Vector3d more(1, 1, 1);
    if (fix.sigma_enu_m)
        for (int axis = 0; axis < 3; ++axis)
            more[axis] = std::max(1.0, (*fix.sigma_enu_m)[axis] / (both_m * kind[axis]));
    const Eigen::Vector3d factor = kind.cwiseProduct(more);
    return {noise.white_m * factor, noise.correlated_m * factor, noise.correlation_s};
}

}  // namespace loopline::gnss
