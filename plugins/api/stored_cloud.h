/// A cloud of points in space that may be larger than memory.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "api/set_aside.h"
#include "api/stamp.h"

namespace loopline {

/// Whole numbers of 0.1 mm in the map frame: as exact 100 km from the origin as beside it.
struct CloudPoint {
    std::array<std::int32_t, 3> place{};
    std::uint32_t time_ticks = 0;  ///< of first sight, in 0.1 ms after StoredCloud::first_ns
    std::uint16_t intensity = 0;   ///< 65535 is the log's full scale; 0 where the log has none
    std::uint16_t reserved = 0;

    static constexpr double unit_m = 1e-4, tick_s = 1e-4;
    Eigen::Vector3d p_map_m() const { return Eigen::Vector3d(place[0], place[1], place[2]) * unit_m; }
    double time_s() const { return time_ticks * tick_s; }
};

class StoredCloud {
 public:
    StampNs first_ns = 0;  ///< UTC that times count from
    bool has_intensity = false;

    /// Points from now on go to a file in `folder`; only while there are none.
    void keep_in(const std::filesystem::path& folder, const std::string& name) {
        points_.keep_in(folder, name);
    }
    void push_back(const CloudPoint& point) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low_[axis] = std::min(low_[axis], point.place[axis]);
            high_[axis] = std::max(high_[axis], point.place[axis]);
        }
        points_.push_back(point);
    }
    const SetAside<CloudPoint>& points() const { return points_; }
    /// Corners of the box about all points, in units of a point's place; only where there are any.
    const std::array<std::int32_t, 3>& low() const { return low_; }
    const std::array<std::int32_t, 3>& high() const { return high_; }

 private:
    template <class Archive>
    friend void fields(Archive& archive, StoredCloud& cloud) {
        archive(cloud.first_ns, cloud.has_intensity, cloud.points_);
        for (auto* corner : {&cloud.low_, &cloud.high_})
            for (auto& x : *corner) archive(x);
    }
    SetAside<CloudPoint> points_;
    std::array<std::int32_t, 3> low_ = filled(std::numeric_limits<std::int32_t>::max()),
                                high_ = filled(std::numeric_limits<std::int32_t>::min());
    static constexpr std::array<std::int32_t, 3> filled(std::int32_t value) { return {value, value, value}; }
};

}  // namespace loopline
