/// Constraints between single frames: each frame of the map is matched with a few that saw the same surfaces,
/// some shortly before it and some on earlier visits.
#pragma once

#include <array>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "grid_map/refinement.h"
#include "grid_slam/active_map.h"
#include "grid_slam/map_frames.h"
#include "grid_slam/pose_graph.h"

namespace loopline::grid_slam {

struct LinkSettings {
    std::array<std::uint32_t, 2> steps_back{1, 5};  ///< among the frames taken before
    /// And one longer ago, unless it saw too much else: the longer the way of a link, the fewer of them, each
    /// with its error, follow one another along the path.
    std::uint32_t long_step = 20;
    double long_step_m = 2.5;
    std::uint32_t beside = 2;   ///< frames before and after the other one whose surfaces are taken with it
    double beside_m = 0.5;      ///< if no longer a way lies between
    double max_distance_m = 4;  ///< between the places of two frames
    double earlier_m = 5;       ///< way of the vehicle since a frame, from which on it is of an earlier visit
    double visit_m = 2;         ///< way between two frames of different visits
    int visits = 2;             ///< earlier visits that a frame is matched with
    double min_fit = 0.5;       ///< part of the returns on a surface of the other frame
    int min_returns = 25;       ///< and how many there must be
    double sigma_degenerate_m = 0.3;  ///< a direction that the two hold no better than this is not observed
    grid_map::RefinementSettings refinement;
};

class Linker {
 public:
    explicit Linker(const LinkSettings& settings) : settings_(settings), surfaces_(bucket_m) {}

    /// Constraints of a frame that it does not have yet.
    std::vector<Constraint> link(const MapFrames& map, const ActiveMap& active, std::uint32_t frame);
    /// What the scans of two frames say about one another, from where they are now; none if too little.
    std::optional<Constraint> match(const MapFrames& map, std::uint32_t from, std::uint32_t to);

    std::uint64_t tried() const { return tried_; }

 private:
    template <class Archive>
    friend void fields(Archive&, Linker&);
    static constexpr double bucket_m = 0.2;
    void take_surfaces(const MapFrames& map, std::uint32_t from, std::uint32_t to);
    std::vector<std::uint32_t> earlier_visits(const MapFrames& map, const ActiveMap& active,
                                              std::uint32_t frame) const;

    LinkSettings settings_;
    std::set<std::pair<std::uint32_t, std::uint32_t>> known_;  ///< pairs that were tried
    std::uint64_t tried_ = 0;
    grid_map::SurfaceIndex surfaces_;
};

}  // namespace loopline::grid_slam
