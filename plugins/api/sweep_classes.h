/// Classes of the observations that hold a sweep of a spinning lidar.
#pragma once

#include <string>
#include <vector>

namespace loopline {

/// By name: two of them lie in a library of MRPT that only those need who look into a sweep.
inline const std::vector<std::string>& sweep_classes() {
    static const std::vector<std::string> names{"CObservationRotatingScan", "CObservationVelodyneScan",
                                                "CObservationPointCloud"};
    return names;
}

}  // namespace loopline
