/// Where a path lies on the Earth, before any filter can know: fixes beside it, until they tell the heading.
#pragma once

#include <optional>
#include <vector>

#include "fusion/heading_search.h"
#include "fusion/wheel_motion.h"

namespace loopline::fusion {

class HeadingStart {
 public:
    struct Settings {
        double sigma_rad = 3 * M_PI / 180;  ///< with which the heading is taken to be known
        /// Lasting errors of the wheels, if the path is theirs, by WheelError.
        WheelErrors wheels = WheelErrors::Zero();
    };

    /// The next fix, at `time_s`: where the antenna is by the path and by the fix. The heading, once it is
    /// known.
    std::optional<FoundHeading> see(double time_s, const Eigen::Vector3d& p_local_m,
                                    const Eigen::Vector3d& p_enu_m, gnss::SigmaOfFix sigma,
                                    const Settings& settings);
    void clear() { seen_ = {}; }

 private:
    template <class Archive>
    friend void fields(Archive&, HeadingStart&);
    std::vector<SeenFix> seen_;
};

}  // namespace loopline::fusion
