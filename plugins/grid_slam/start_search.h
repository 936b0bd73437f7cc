/// Where in a finished map is the vehicle, when that is known badly or not at all? The latest scans, put
/// together by the motion between them, are searched for at all places and headings in question. A wrong
/// start is worse than none: it counts only if the scans fit well, hold the pose, fit no other place nearly
/// as well, and another look after some way agrees.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "grid_map/refinement.h"
#include "grid_map/search.h"
#include "grid_slam/frozen_map.h"
#include "grid_slam/map_frames.h"

namespace loopline::grid_slam {

struct StartSettings {
    double latest_m = 5;   ///< way of the vehicle up to now, whose frames are searched for
    double long_m = 20;    ///< the same where that leaves several places
    double every_m = 0.7;  ///< way between two looks
    int search_points = 200;
    double min_likelihood = 0.5;  ///< mean over the returns, 0 .. 1
    double min_fit = 0.6;         ///< part of the returns on a surface of the map
    double rival = 0.85;          ///< another place as likely as this part of the best one makes it ambiguous
    double rival_m = 0.6, rival_rad = 15 * M_PI / 180;  ///< another place: farther than this, or so turned
    double max_sigma_m = 0.1;                           ///< how well the scans must hold each direction
    double agree_m = 0.3, agree_rad = 3 * M_PI / 180;   ///< two looks are one place if they differ by less
    double agree_after_m = 1.5, agree_within_m = 10;    ///< way between them
    double information_share = 0.2;  ///< how much of the information of its returns a start counts with
    grid_map::RefinementSettings refinement;
};

/// Places in question: all of the map, or those around a pose.
struct StartRegion {
    bool whole_map = true;
    Pose2 T_map_base;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, phi), map axes
};

/// What came of the latest look, for people.
struct StartLook {
    double likelihood = 0, fit = 0, rival = 0;
    Pose2 T_map_base;
    bool ambiguous = false;
    std::string reason = "nothing was searched for yet";  ///< why the start is not known
};

struct StartFound {
    Pose2 T_map_base;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    double fit = 0;
};

class StartSearch {
 public:
    explicit StartSearch(const StartSettings& settings) : settings_(settings) {}

    /// `frames` at their poses from where the motion began, the last of them now; `way_m` of the vehicle
    /// since then.
    std::optional<StartFound> look(const FrozenMap& map, const MapFrames& frames, double way_m,
                                   const StartRegion& region);
    const StartLook& latest() const { return latest_; }
    std::int64_t looks() const { return looks_; }

 private:
    template <class Archive>
    friend void fields(Archive&, StartSearch&);
    /// One look by itself.
    struct Sighting {
        double way_m = 0;
        Pose2 T_local_base, T_map_base;
        Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    };
    struct Place {
        Pose2 T_map_base;
        double likelihood = 0;
    };
    grid_map::SearchWindow window(const FrozenMap& map, const StartRegion& region, double reach_m) const;
    std::optional<Place> sharpened(const FrozenMap& map, const std::vector<Eigen::Vector2f>& points,
                                   const grid_map::SearchResult& coarse) const;
    std::optional<Place> best_place(const FrozenMap& map, const std::vector<Eigen::Vector2f>& points,
                                    grid_map::SearchWindow window);
    std::optional<Sighting> sight(const FrozenMap& map, const MapFrames& frames, double latest_m,
                                  const StartRegion& region);
    bool agrees(const Sighting& sighting) const;

    StartSettings settings_;
    double looked_at_m_ = -1e9;
    std::deque<Sighting> sightings_;  ///< that wait for another one
    StartLook latest_;
    std::int64_t looks_ = 0;
};

}  // namespace loopline::grid_slam
