/// Lines seen by too few scans to be trusted: people, doors that move, artefacts of the extraction. A line
/// enters the filter's state when several scans agree on it.
#pragma once

#include <vector>

#include "line_slam/map_lines.h"

namespace loopline::line_slam {

struct TentativeParameters {
    int scans = 3;            ///< that must have seen a line before it enters the state
    int patience_scans = 10;  ///< without being seen, after which it is forgotten
    double gate = 13.8;       ///< squared Mahalanobis distance of two degrees of freedom
    double max_gap_m = 1.0;
};

struct TentativeLine {
    LineObservation latest;  ///< in the map frame, by the pose of its scan
    Extent extent;
    Eigen::Matrix3d drift = Eigen::Matrix3d::Zero();  ///< of the pose's error (t_x, t_y, theta) since then
    int track = -1;
    int scans = 0;
    int last_scan = 0;
};

class TentativeLines {
 public:
    explicit TentativeLines(const TentativeParameters& parameters) : parameters_(parameters) {}

    /// The vehicle moved on: its pose is less certain, relative to what was seen before, by
    /// `motion_error_covariance`.
    void move(const Eigen::Matrix3d& motion_error_covariance);

    /// Adds an observation that no map line explains. Returns the tentative line that it belongs to; a new
    /// one takes `next_track` and counts it up.
    TentativeLine& add(const Pose2& T_map_base, const LineObservation& observation, int scan,
                       int& next_track);
    bool is_confirmed(const TentativeLine& line) const { return line.scans >= parameters_.scans; }
    /// Forgets the line of this track (it entered the state).
    void remove(int track);
    void forget_stale(int scan);

 private:
    template <class Archive>
    friend void fields(Archive&, TentativeLines&);
    TentativeParameters parameters_;
    std::vector<TentativeLine> lines_;
};

}  // namespace loopline::line_slam
