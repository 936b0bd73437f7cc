/// Feature points of a survey, measured by the run: table 1 of Hu 2012. The estimate of a point is the mean
/// of the laser returns that truly hit within 5 cm of it during the vehicle's closest pass, carried through
/// the estimated poses at their own times; the same returns carried by dead reckoning show what was
/// corrected.
///
/// Which returns those are is known from the truth alone, so they are picked while the log streams by, before
/// there is an estimate. The closest pass is the stretch of the true path round its place nearest to the
/// point on which the vehicle stays within 5 m, or 1.5 times its least distance if that is more. Where no
/// return hits on it (the point was hidden), the next closest such stretch counts.
#pragma once

#include <mrpt/obs/CObservation2DRangeScan.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/pose3_motion.h"
#include "api/trajectory.h"
#include "evaluate/surveyed_truth.h"
#include "output/tum.h"

namespace loopline {

/// A point in the map frame, as it is and as the run sees it.
struct PointEstimate {
    int number = 0;
    std::size_t returns = 0;  ///< that hit it
    Eigen::Vector2d true_m = Eigen::Vector2d::Zero();
    Eigen::Vector2d estimate_m = Eigen::Vector2d::Zero();
    /// The same returns carried by the true poses: off the point by what the walls round it and the noise of
    /// the laser do.
    Eigen::Vector2d by_true_poses_m = Eigen::Vector2d::Zero();
    std::optional<Eigen::Vector2d> odometry_m;  ///< none without dead reckoning

    double estimate_error_m() const { return (estimate_m - true_m).norm(); }
    std::optional<double> odometry_error_m() const {
        if (!odometry_m) return std::nullopt;
        return (*odometry_m - true_m).norm();
    }
};

/// A true path, interpolated at constant twist.
class TruePath {
 public:
    /// Poses in any order.
    TruePath(const std::vector<StampedPose>& poses) : TruePath(std::make_shared<const StampedPath>(poses)) {}
    /// The same, without a copy if they are in order.
    explicit TruePath(std::shared_ptr<const StampedPath> poses);

    /// `nullopt` outside of the path and in gaps of more than a second. Quick for times in order.
    std::optional<Pose3> at(StampNs stamp_ns);
    const StampedPath& poses() const { return *poses_; }  ///< in the order of their stamps

 private:
    /// Between a pose and the one before it.
    struct Segment {
        std::size_t right = 0;  ///< of the two; 0: none yet
        ScrewSegment screw;
    };
    const ScrewSegment& segment_to(std::size_t right);

    std::shared_ptr<const StampedPath> poses_;
    std::size_t right_ = 0;  ///< of the pair in use; 0: none
    Segment even_, odd_;     ///< the latest with such a `right`: a scan lies on two as a rule
};

/// From the truth's frame to the map's, that is of the estimate's first pose that the truth has a pose for.
std::optional<Pose3> map_from_truth(const Trajectory& estimate, TruePath& truth);

class FeaturePointHits {
 public:
    static constexpr double hit_radius_m = 0.05;

    /// `scan_duration_s`: from the first beam of a scan, which has its stamp, to the last.
    FeaturePointHits(std::vector<FeaturePoint> points, TruePath truth, double scan_duration_s);

    /// Picks the returns of a scan that hit a point. Only lasers that are never tilted count.
    void take(const mrpt::obs::CObservation2DRangeScan& scan, StampNs stamp_ns, std::uint64_t sequence);

    struct Outcome {
        std::vector<PointEstimate> points;  ///< in the order of the truth
        std::vector<int> missed;            ///< numbers of those that no return hit, or none with a pose
    };
    Outcome estimates(const Trajectory& estimate, const Trajectory* odometry);

 private:
    struct Pass {
        StampNs first_ns, last_ns;
        double least_m;  ///< distance of the vehicle
    };
    struct Hit {
        std::uint64_t sequence;
        StampNs time_ns;
        Eigen::Vector3d p_base;
        std::size_t pass;
        const std::string* sensor;
    };
    struct Watched {
        FeaturePoint point;
        std::vector<Pass> passes;
        std::vector<Hit> hits;
    };

    void find_passes(Watched& watched) const;
    bool is_level(const mrpt::obs::CObservation2DRangeScan& scan);
    void look_for(Watched& watched, std::size_t pass, const mrpt::obs::CObservation2DRangeScan& scan,
                  const Pose3& T_base_sensor, StampNs stamp_ns, std::uint64_t sequence);
    std::vector<Hit> hits_of_closest_pass(const Watched& watched) const;

    TruePath truth_;
    std::vector<Watched> watched_;
    double scan_duration_s_;
    /// Of a laser.
    struct Level {
        bool yes = true;                       ///< false for good once a scan was tilted
        mrpt::math::CMatrixDouble33 rotation;  ///< of the latest scan
    };
    std::map<std::string, Level> levels_;  ///< by label
};

}  // namespace loopline
