/// Poses of a planar odometry, and its motion between any two times that they span.
#pragma once

#include <deque>
#include <optional>

#include "api/pose2.h"
#include "api/stamp.h"
#include "api/twist2.h"

namespace loopline {

class PlanarPath {
 public:
    /// False if it is not later than the one before.
    bool take(StampNs stamp_ns, const Pose2& T_odom_base);
    /// None unless poses lie at or before the one and at or after the other.
    std::optional<Twist2> motion(StampNs from_ns, StampNs to_ns) const;
    /// Whether a pose has come that is not older than this.
    bool reaches(StampNs stamp_ns) const { return !samples_.empty() && samples_.back().stamp_ns >= stamp_ns; }
    /// Forgets what no motion from `stamp_ns` on needs.
    void forget_before(StampNs stamp_ns);

 private:
    template <class Archive>
    friend void fields(Archive&, PlanarPath&);
    struct Sample {
        StampNs stamp_ns = 0;
        Pose2 T_odom_base;
    };
    std::optional<Pose2> at(StampNs stamp_ns) const;
    std::deque<Sample> samples_;
};

template <class Archive>
void fields(Archive& archive, PlanarPath& path) {
    archive.each(path.samples_,
                 [](Archive& a, PlanarPath::Sample& sample) { a(sample.stamp_ns, sample.T_odom_base); });
}

}  // namespace loopline
