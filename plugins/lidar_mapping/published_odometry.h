/// Poses that another odometry publishes under one label, and the motion between any two times by them.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "api/pose_observation.h"
#include "api/stamp.h"
#include "lidar_mapping/given_motion.h"

namespace mrpt::obs {
class CObservation;
}

namespace loopline::lidar_mapping {

struct PublishedOdometrySettings {
    std::string label;  ///< empty: there is none
    /// Of the motion between two sweeps, beside what its covariance says, if it has one: errors that
    /// neighbouring motions share, and that a lidar odometry has seen the same sweep.
    double sigma_m = 0.03, sigma_rad = 0.3 * 3.14159265358979323846 / 180;
    double sigma_scale = 0.01;  ///< of its ways, as a part of them
};

class PublishedOdometry {
 public:
    explicit PublishedOdometry(const PublishedOdometrySettings& settings) : settings_(settings) {}

    bool wanted() const { return !settings_.label.empty(); }
    /// Whether it was a pose of this odometry: CObservationRobotPose or CObservationOdometry.
    bool take(const mrpt::obs::CObservation& observation);
    /// How many poses have come.
    std::int64_t taken() const { return taken_; }
    /// Whether a pose has come that is not older than this.
    bool reaches(StampNs stamp_ns) const { return !poses_.empty() && poses_.back().stamp_ns >= stamp_ns; }
    /// None as long as there are not two poses; before the first and after the last the motion goes on.
    std::optional<GivenMotion> motion(StampNs from_ns, StampNs to_ns) const;
    /// Forgets what no motion from `stamp_ns` on needs.
    void forget_before(StampNs stamp_ns);

 private:
    template <class Archive>
    friend void fields(Archive&, PublishedOdometry&);
    struct Sample {
        StampNs stamp_ns = 0;
        PoseWithCovariance known;  ///< its map being the odometry's own
    };
    /// The first of the two poses that the motion at a time is told by.
    std::size_t before(StampNs stamp_ns) const;
    ScrewSegment segment(std::size_t first) const;

    PublishedOdometrySettings settings_;
    std::deque<Sample> poses_;
    bool planar_ = false;
    std::int64_t taken_ = 0;
};

}  // namespace loopline::lidar_mapping
