/// Whether the fixes of a receiver are stamped late, or early: told by a path that knows its own motion,
/// wherever the vehicle turns or its speed changes.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

namespace loopline::fusion {

/// A place on the plan at a time.
struct PlaceAt {
    double time_s = 0;
    Eigen::Vector2d p_m = Eigen::Vector2d::Zero();
};

struct FixLag {
    double lag_s = 0;  ///< a fix says where the antenna was so long before its stamp
    double sigma_s = 0;
    std::size_t stretches = 0;  ///< of the path that tell it
};

/// `path`: where the antenna was by the motion alone, in any frame, in the order of time; `fixes`: where it
/// was by the receiver, in the order of time. Each stretch of some seconds tells a lag of its own, whatever
/// its heading, place and scale are; the result is their median, since reflected signals and slips of wheels
/// make some of them wrong. None if too few tell.
std::optional<FixLag> lag_of_fixes(const std::vector<PlaceAt>& path, const std::vector<PlaceAt>& fixes);

}  // namespace loopline::fusion
