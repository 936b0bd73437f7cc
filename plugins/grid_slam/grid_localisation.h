/// Localisation in a finished map. Where the place is known, each scan is matched with the map, as forward
/// matching does it. Where it is not, at a start that nobody gave or after the scans have not fitted for a
/// while, scans are put together by mapping on their own, without loops, and what they make is searched for
/// in the finished map until the place is certain; poses since then are laid out backwards.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "api/planar_scan.h"
#include "grid_slam/forward_match.h"
#include "grid_slam/frozen_map.h"
#include "grid_slam/fusion_of_passes.h"
#include "grid_slam/grid_slam.h"
#include "grid_slam/navigation.h"
#include "grid_slam/start_search.h"

namespace loopline::grid_slam {

struct LocalisationSettings {
    bool start_given = true;
    Pose2 T_map_start;
    double sigma_start_m = 0.2, sigma_start_rad = 5 * M_PI / 180;
    grid_map::FrameSettings frame;
    ForwardSettings forward;
    StartSettings start;
    double good_fit =
        0.35;  ///< part of the returns on surfaces of the map, from which a scan counts as fitting
    double lost_after_m = 5;  ///< way without a scan that fits, after which the place is searched for
};

/// What one scan gave.
struct LocalisedScan {
    ForwardMatch match;              ///< for navigation, after it was moved
    std::optional<Pose2> T_new_old;  ///< how navigation has to be moved first
    bool known = false;              ///< else the place in the map is not known yet
    Pose2 T_map_base;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// A stretch of the log on which the place was not known.
struct LostStretch {
    std::size_t first_scan = 0, end_scan = 0;  ///< without the last one
    double way_m = 0;
    bool found = false;  ///< at its end
};

/// What refinement has to allow for on a map of such cells.
grid_map::RefinementSettings refinement_on(double map_cell_m, grid_map::RefinementSettings settings);

class GridLocalisation {
 public:
    /// `map` outlives it.
    GridLocalisation(const LocalisationSettings& settings, const FrozenMap& map);

    /// The pose that navigation has to begin at.
    Pose2 start() const { return is_searching() ? Pose2{} : settings_.T_map_start; }
    /// The next scan, and where the vehicle should be by navigation.
    LocalisedScan add(const PlanarScan& scan, const Prediction& prediction,
                      const grid_map::SweepMotion& sweep);

    /// Latest poses of all scans, and their covariances; none if no place was ever known.
    const std::vector<Pose2>& poses() const { return poses_; }
    const std::vector<Eigen::Matrix3d>& covariances() const { return covariances_; }
    bool ever_known() const { return known_from_.has_value(); }
    /// The first scan whose place was known at its time.
    std::size_t known_from() const { return known_from_.value_or(0); }
    bool is_searching() const { return local_ != nullptr; }
    std::size_t scans() const { return scans_; }
    std::size_t matched() const { return matched_; }
    std::size_t unmatched() const { return unmatched_; }
    std::size_t degenerate() const { return degenerate_; }
    double way_m() const { return way_m_; }
    double known_after_m() const { return known_after_m_; }
    /// The one under way included.
    const std::vector<LostStretch>& lost() const { return lost_; }
    const StartSearch& search() const { return search_; }
    std::int64_t searches() const { return earlier_looks_ + search_.looks(); }

 private:
    template <class Archive>
    friend void fields(Archive&, GridLocalisation&);
    LocalisedScan follow(const Prediction& prediction);
    LocalisedScan search(const PlanarScan& scan, const Prediction& prediction,
                         const grid_map::SweepMotion& sweep);
    Eigen::Matrix3d grown_since_search_began() const;
    void begin_search(bool whole_map, const Motion& guess);
    void become_lost(const PlanarScan& scan, const Prediction& prediction, const grid_map::SweepMotion& sweep,
                     LocalisedScan& result);
    void lay_out_backwards(const StartFound& found);
    void keep(const Pose2& T_map_base, const Eigen::Matrix3d& covariance);

    GridSlamSettings local_settings() const;

    LocalisationSettings settings_;
    ForwardSettings on_map_;  ///< as the cells of the map want it
    const FrozenMap& map_;
    grid_map::Frame frame_;  ///< of the scan at hand

    std::vector<Pose2> poses_;
    std::vector<Eigen::Matrix3d> covariances_;
    std::optional<std::size_t> known_from_;
    std::size_t scans_ = 0, matched_ = 0, unmatched_ = 0, degenerate_ = 0;
    double way_m_ = 0, known_after_m_ = 0;
    Motion fitting_;  ///< pose of the latest scan that fitted, and its covariance along the axes of the map
    Motion since_fitting_;           ///< the same, moved on since
    double fitting_at_m_ = 0;        ///< way then
    std::vector<Motion> unfitting_;  ///< motions of the scans since then
    std::vector<LostStretch> lost_;

    // While the place is not known.
    std::unique_ptr<GridSlam> local_;  ///< maps in a frame of its own, from the first scan of the search on
    StartRegion region_;               ///< where the place may be
    double local_way_m_ = 0;
    Pose2 T_map_local_;                                              ///< as guessed
    Eigen::Matrix3d covariance_at_first_ = Eigen::Matrix3d::Zero();  ///< of that guess
    StartSearch search_;
    std::int64_t earlier_looks_ = 0;  ///< of searches before this one
};

}  // namespace loopline::grid_slam
