/// Motion by landmarks that are points: trunks, poles, reflectors. Sightings are matched with the landmarks
/// that were seen within the last part of the way; what drifts is what the landmarks in view have not seen.
#pragma once

#include <cstdint>
#include <vector>

#include "api/pose_observation.h"
#include "landmark_odometry/landmark_filter.h"

namespace loopline::landmark_odometry {

struct LandmarkOdometrySettings {
    MotionNoise motion;
    double up_m = 0.02,
           tilt_rad = 0.15 * M_PI / 180;  ///< after 1 m, of which a plane tells nothing: the road
    double gate = 0.99;                   ///< part of good sightings that are to pass
    double new_beyond_m = 1;  ///< what is seen nearer to a landmark, and is not that one, is no new one
    int sightings_of_new = 3;
    double remember_m = 60;  ///< a landmark that was not seen on so much way is forgotten
    double begin_anew_m = 20;
};

/// What became of all sightings.
struct SightingCounts {
    std::int64_t matched = 0, ambiguous = 0, off = 0, tentative = 0, landmarks = 0;
    double sum_of_squares = 0;  ///< of those matched, each chi-square of two
};

class LandmarkOdometry {
 public:
    explicit LandmarkOdometry(const LandmarkOdometrySettings& settings) : settings_(settings) {}

    /// The next scan: what dead reckoning tells since the one before, and what is seen.
    void take(const Twist2& told, const std::vector<Sighting>& sightings);

    /// In the frame of the first scan; covariance along its axes, about the vehicle.
    PoseWithCovariance pose() const;
    const LandmarkFilter& filter() const { return filter_; }
    const SightingCounts& counts() const { return counts_; }

 private:
    template <class Archive>
    friend void fields(Archive&, LandmarkOdometry&);
    /// Of each landmark of the filter, in its order.
    struct Seen {
        double way_m = 0;  ///< when it was last seen
    };
    /// What may become a landmark, in the filter's frame.
    struct Tentative {
        Eigen::Vector2d p_local_m = Eigen::Vector2d::Zero();  ///< where it was seen first
        Eigen::Matrix2d covariance_m2 = Eigen::Matrix2d::Identity();
        int sightings = 0;
        std::int64_t scan = 0;  ///< that saw it last
    };
    enum class Fate : std::uint8_t { open, matched, ambiguous };

    std::vector<Fate> match(const std::vector<Sighting>& sightings);
    void consider_new(const Sighting& sighting);
    bool is_near_landmark(const Sighting& sighting) const;
    void forget();
    void begin_anew();
    /// What the plane does not tell.
    Matrix6d in_space(const Eigen::Matrix3d& covariance, double way_m) const;

    LandmarkOdometrySettings settings_;
    LandmarkFilter filter_;
    std::vector<Seen> seen_;
    std::vector<Tentative> tentative_;
    PoseWithCovariance origin_;  ///< of the filter's frame
    double way_m_ = 0, origin_way_m_ = 0;
    std::int64_t scans_ = 0;
    SightingCounts counts_;
};

}  // namespace loopline::landmark_odometry
