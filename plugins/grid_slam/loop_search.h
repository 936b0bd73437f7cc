/// Is the vehicle where it was before? (Rows B5, B6 and B12 of the method.) Candidates are places of the map
/// that are near by, as far as that is known, and not part of the active map; the latest scans are searched
/// for in the old map around them, from which those of the loop are left out. A loop that is wrong is worse
/// than none: it counts only if it is certain, has no rival, holds the pose in all directions, and another
/// one agrees.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "grid_map/refinement.h"
#include "grid_map/search.h"
#include "grid_slam/active_map.h"
#include "grid_slam/map_frames.h"
#include "grid_slam/pose_graph.h"
#include "grid_slam/relative_uncertainty.h"

namespace loopline::grid_slam {

struct LoopSettings {
    double every_m = 1;    ///< way between two attempts
    double reach_m = 4;    ///< from the vehicle to a frame of the old map, beyond what is uncertain
    double old_map_m = 4;  ///< way of the vehicle before and after that frame, whose frames make the old map
    double latest_m = 2;   ///< way of the vehicle up to now, whose frames are searched for
    double window_sigmas = 3;  ///< half of the search window in standard deviations
    double max_window_m = 10;  ///< but not more
    double max_window_rad = 30 * M_PI / 180;
    double named_window_m = 10;  ///< half of the window of a loop that a person named
    double named_window_rad = 45 * M_PI / 180;
    double least_window_m = 0, least_window_rad = 0;  ///< half of the window is no less
    int search_points = 150;
    double min_likelihood = 0.55;  ///< mean over the returns, 0 .. 1
    double min_fit = 0.7;          ///< part of the returns on a surface of the old map
    double rival =
        0.9;  ///< a second place, elsewhere, as likely as this part of the best one makes it ambiguous
    double rival_m = 0.5;                              ///< elsewhere: farther than this
    double max_sigma_m = 0.05;                         ///< how well the match must hold each direction
    double agree_m = 0.2, agree_rad = 2 * M_PI / 180;  ///< two matches are one loop if they differ by less
    double agree_after_m = 0.9, agree_within_m = 6;    ///< way between them
    double information_share = 0.2;  ///< how much of the information of its returns a loop counts with
    double cell_m = 0.05;
    grid_map::RefinementSettings refinement;
};

/// What came of an attempt, for people.
struct LoopRecord {
    enum class Decision { accepted, waits, refused };
    std::uint32_t frame = 0, old_frame = 0;
    double way_m = 0;  ///< of the vehicle between the two
    double likelihood = 0, fit = 0, rival = 0;
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< what it moves: x, y, phi, in the old frame's axes
    double sigma_m = 0, sigma_rad = 0;                ///< what was uncertain before
    Decision decision = Decision::refused;
    std::string reason;
};

class LoopSearch {
 public:
    explicit LoopSearch(const LoopSettings& settings) : settings_(settings) {}

    /// The constraints of a loop, at least two, if there is one at the latest frame; else none.
    std::vector<Constraint> look(const MapFrames& map, const ActiveMap& active,
                                 const Neighbourhood& neighbourhood);
    /// The constraint of a loop that a person named, at the latest frame: verified as any other, but that it
    /// needs no second match. Leaves a record in any case.
    std::vector<Constraint> look_at(std::uint32_t old_frame, const MapFrames& map, const ActiveMap& active,
                                    const Neighbourhood& neighbourhood);
    /// Whether the latest look found what waits for a second match.
    bool latest_waits() const {
        return !records_.empty() && records_.back().decision == LoopRecord::Decision::waits;
    }
    /// What the latest look found, accepted or waiting, is not to be.
    void refuse_latest(const std::string& reason);
    /// Poses were corrected: what is not accepted by now is forgotten.
    void forget_pending() { pending_.clear(); }

    const std::vector<LoopRecord>& records() const { return records_; }

 private:
    template <class Archive>
    friend void fields(Archive&, LoopSearch&);
    struct Candidate {
        std::uint32_t old_frame;
        double away;
    };
    std::optional<std::uint32_t> candidate(const MapFrames& map, const ActiveMap& active,
                                           const Neighbourhood& neighbourhood);
    std::optional<Constraint> match(const MapFrames& map, const ActiveMap& active, std::uint32_t old_frame);
    grid_map::Frame latest_frames(const MapFrames& map) const;
    grid_map::SearchWindow window(const MapFrames& map, std::uint32_t old_frame) const;
    std::string objection(const grid_map::ScanGrid& old_map, const std::vector<Eigen::Vector2f>& points,
                          grid_map::SearchWindow window, const grid_map::SearchResult& found,
                          const grid_map::ScanFit& fit, LoopRecord& record) const;

    LoopSettings settings_;
    RelativeUncertainty uncertainty_;
    double looked_at_m_ = -1e9;       ///< way of the latest attempt
    double known_at_m_ = -1e9;        ///< way at which uncertainty_ was computed
    double largest_sigma_m_ = 1e9;    ///< of all frames, then
    std::deque<Constraint> pending_;  ///< matches that wait for another one
    std::vector<LoopRecord> records_;
};

}  // namespace loopline::grid_slam
