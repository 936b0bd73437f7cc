/// Mapping with a planar laser that closes its loops (Wuhan University's patent, steps S1 to S7): forward matching on the
/// map, loops found and verified, the path corrected from both ends of a loop, the map rebuilt.
#pragma once

#include <optional>
#include <vector>

#include "api/planar_scan.h"
#include "grid_slam/active_map.h"
#include "grid_slam/forward_match.h"
#include "grid_slam/links.h"
#include "grid_slam/loop_search.h"
#include "grid_slam/map_frames.h"
#include "grid_slam/pose_graph.h"

namespace loopline::grid_slam {

struct GridSlamSettings {
    double cell_m = 0.05;
    grid_map::FrameSettings frame;
    ForwardSettings forward;
    ActiveMapSettings active;
    LinkSettings links;
    LoopSettings loops;
    GraphSettings graph;
    double frame_way_m = 0.15;                 ///< a scan so far from all frames of the map becomes one
    double frame_turn_rad = 5 * M_PI / 180;    ///< or one so turned
    double new_fit = 0.8;                      ///< or one that fits worse than this
    double choose_every_m = 1;                 ///< way after which the active map is chosen anew
    double relink_m = 4;                       ///< way before a loop whose frames are linked to the old map
    double worth_m = 0.03;                     ///< constraints that disagree with the poses by less wait for the next correction
    double worth_rad = 0.5 * M_PI / 180;
    GraphSettings online_graph{4, 2e-3, 3};    ///< of corrections on the way
};

/// What one scan gave.
struct ScanPose {
    Pose2 T_map_base;              ///< as known now
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, phi) given the first pose, map axes
    double fit = 0;
    bool matched = false;
    bool corrected = false;        ///< a correction of the path took effect with this scan
};

class GridSlam {
 public:
    explicit GridSlam(const GridSlamSettings& settings);

    /// The next scan, and how the vehicle moved since the one before, along the axes of its pose then.
    ScanPose add(const PlanarScan& scan, const Motion& motion);
    /// End of the log: what is under way is finished, and all poses are fitted once more.
    void finish();

    std::size_t scans() const { return places_.size(); }
    /// Latest poses of all scans and their covariances.
    void path(std::vector<Pose2>& poses, std::vector<Eigen::Matrix3d>& covariances) const;

    const MapFrames& map() const { return map_; }
    const ActiveMap& active_map() const { return active_; }
    const std::vector<Constraint>& constraints() const { return constraints_; }
    const std::vector<LoopRecord>& loops() const { return loops_.records(); }
    int corrections() const { return corrections_; }
    std::uint64_t unmatched() const { return unmatched_; }
    std::uint64_t degenerate() const { return degenerate_; }
    const Linker& linker() const { return linker_; }

 private:
    template <class Archive>
    friend void fields(Archive&, GridSlam&);
    /// A scan rides on a frame of the map.
    struct Place {
        std::uint32_t frame = 0;
        Pose2 T_frame_base;
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of it, along the axes of the frame
    };

    void settle_on_frame(const ForwardMatch& match);
    std::optional<std::uint32_t> near_frame(const Pose2& T_map_base) const;
    void add_frame(const ForwardMatch& match);
    void add_constraint(const Constraint& constraint);
    bool is_worth_correcting(const Constraint& constraint) const;
    void begin_correction();
    bool advance_correction();
    void apply_correction();
    void relink(std::uint32_t from_frame);
    void rebuild_neighbourhood();

    GridSlamSettings settings_;
    grid_map::Frame frame_;  ///< of the scan at hand
    MapFrames map_;
    ActiveMap active_;
    Linker linker_;
    LoopSearch loops_;
    std::vector<Constraint> constraints_;
    Neighbourhood neighbourhood_;
    std::vector<Place> places_;  ///< of all scans
    Motion since_frame_;         ///< from the frame that the vehicle rides on, without matching
    double way_m_ = 0, chosen_at_m_ = 0;
    std::optional<GraphOptimiser> correction_;
    std::size_t correction_frames_ = 0;
    bool relink_after_ = false;
    std::uint32_t loop_frame_ = 0;
    int corrections_ = 0;
    std::uint64_t unmatched_ = 0, degenerate_ = 0;
    std::vector<Eigen::Matrix3d> frame_covariances_;  ///< after finish()
};

}  // namespace loopline::grid_slam
