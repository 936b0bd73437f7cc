/// Mapping with a planar laser that closes its loops (Wuhan University's patent, steps S1 to S7): forward
/// matching on the map, loops found and verified, the path corrected from both ends of a loop, the map
/// rebuilt.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "api/planar_scan.h"
#include "api/set_aside.h"
#include "grid_slam/active_map.h"
#include "grid_slam/forward_match.h"
#include "grid_slam/fusion_of_passes.h"
#include "grid_slam/links.h"
#include "grid_slam/loop_decisions.h"
#include "grid_slam/loop_search.h"
#include "grid_slam/map_frames.h"
#include "grid_slam/navigation.h"
#include "grid_slam/pose_graph.h"

namespace loopline::grid_slam {

struct GridSlamSettings {
    double cell_m = 0.05;
    grid_map::FrameSettings frame;
    ForwardSettings forward;
    ActiveMapSettings active;
    LinkSettings links;
    LoopSettings loops;
    DecisionSettings decisions;
    GraphSettings graph;
    double frame_way_m = 0.1;                ///< a scan so far from all frames of the map becomes one
    double frame_turn_rad = 3 * M_PI / 180;  ///< or one so turned
    double new_fit = 0.8;                    ///< or one that fits worse than this
    double blind_way_m = 0.5;  ///< one that sees nothing becomes one if so far from where it saw something
    std::size_t known_frames = 3;  ///< where earlier visits have left so many, no others are made
    double choose_every_m = 1;     ///< way after which the active map is chosen anew
    double relink_m = 4;           ///< way before a loop whose frames are linked to the old map
    double worth_m = 0.03;  ///< constraints that disagree with the poses by less wait for the next correction
    double worth_rad = 0.5 * M_PI / 180;
    GraphSettings online_graph{4, 2e-3, 3};  ///< of corrections on the way
    Weights weights = Weights::joint;        ///< how a loop is corrected
};

/// What one scan gave.
struct ScanPose {
    ForwardMatch match;  ///< as the scan was matched
    Pose2 T_map_base;    ///< as known after it
};

/// A part of a list of poses that lie on disk.
struct PosesAside {
    std::uint64_t first = 0, count = 0;
};

/// What a correction did, to show it.
struct Correction {
    StampNs stamp_ns = 0;                    ///< of the scan at which it took effect
    std::uint32_t old_frame = 0, frame = 0;  ///< that the loop joins
    PosesAside before, after;  ///< poses of all frames; none where others moved the vehicle more
    std::uint32_t reverse_first = 0;
    PosesAside reverse;    ///< of the frames from reverse_first on; none where no reverse pass was made
    Pose2 T_before_after;  ///< of the later frame
};

class GridSlam {
 public:
    explicit GridSlam(const GridSlamSettings& settings);
    /// What is known of each scan, and the frames of the map, go there from now on; they stay in memory if
    /// the folder has no name. Before the first scan.
    void keep_in(const std::filesystem::path& folder) {
        places_.keep_in(folder, "grid_slam_places");
        map_.frames.keep_in(folder);
        correction_poses_.keep_in(folder, "grid_slam_corrections");
    }

    /// Before each scan: closes the loop that was found with the one before, or goes on with a correction
    /// that is under way. If it took effect: how it moved the vehicle.
    std::optional<Pose2> advance();
    /// The next scan, and where the vehicle should be. `sweep`: its motion from the first beam of this scan
    /// to the last.
    ScanPose add(const PlanarScan& scan, const Prediction& prediction,
                 const grid_map::SweepMotion& sweep = {});
    /// End of the log: what is under way is finished, and all poses are fitted once more.
    void finish();

    std::size_t scans() const { return places_.size(); }
    /// Latest pose of a scan, and its covariance.
    struct KnownPose {
        Pose2 T_map_base;
        Eigen::Matrix3d covariance;
    };
    KnownPose latest(std::size_t scan) const;
    /// Of all scans.
    void path(std::vector<Pose2>& poses, std::vector<Eigen::Matrix3d>& covariances) const;

    const MapFrames& map() const { return map_; }
    const ActiveMap& active_map() const { return active_; }
    const std::vector<Constraint>& constraints() const { return constraints_; }
    const std::vector<LoopRecord>& loops() const { return loops_.records(); }
    /// Whether the latest of them is to be closed before the next scan, unless it is refused.
    bool loop_at_hand() const { return !found_.empty(); }
    bool loop_at_hand_is_refused() const;
    const LoopDecisions& decisions() const { return decisions_; }
    const std::vector<Correction>& corrections() const { return corrections_; }
    std::vector<Pose2> poses_of(const PosesAside& part) const;
    /// For weights other than `joint`: what leads from frame to frame on the way back. Outlives this object,
    /// or is replaced.
    void set_reverse_navigation(ReverseNavigation* navigation) { reverse_navigation_ = navigation; }
    std::uint64_t unmatched() const { return unmatched_; }
    /// Motions that scans, found farther off than their noise explains, have shown to be wrong.
    std::uint64_t motions_refused() const { return motions_refused_; }
    std::uint64_t degenerate() const { return degenerate_; }
    const Linker& linker() const { return linker_; }

 private:
    template <class Archive>
    friend void fields(Archive&, GridSlam&);
    /// A scan rides on a frame of the map.
    struct Place {
        std::uint64_t frame = 0;
        Pose2 T_frame_base;
        double covariance[9] = {};  ///< of it, 3x3, along the axes of the frame
    };

    /// The frame of the latest scan.
    std::uint32_t rides_on() const { return static_cast<std::uint32_t>(latest_.frame); }
    void ride(std::uint32_t frame, const Pose2& T_frame_base, const Eigen::Matrix3d& covariance);
    void trust_motion_less(const Pose2& T_map_predicted, const Pose2& T_map_base);
    void settle_on_frame(const ForwardMatch& match);
    std::optional<std::uint32_t> near_frame(const Pose2& T_map_base) const;
    void add_frame(const ForwardMatch& match);
    void add_constraint(const Constraint& constraint);
    void look_for_loop();
    std::optional<Pose2> close_loop();
    Pose2 correct_by_going_back(const Constraint& loop);
    void record_correction(const std::vector<Pose2>& before, const Constraint& loop,
                           const PassResult& reverse = {});
    PosesAside set_aside(const std::vector<Pose2>& poses);
    bool is_worth_correcting(const Constraint& constraint) const;
    void begin_correction();
    Pose2 apply_correction();
    Pose2 take_poses(std::vector<Pose2> corrected);
    void relink(std::uint32_t from_frame);
    void rebuild_neighbourhood();

    GridSlamSettings settings_;
    grid_map::Frame frame_;  ///< of the scan at hand
    MapFrames map_;
    ActiveMap active_;
    Linker linker_;
    LoopSearch loops_;
    LoopDecisions decisions_;
    std::vector<Constraint> found_;  ///< the loop at hand
    std::vector<Constraint> constraints_;
    Neighbourhood neighbourhood_;
    SetAside<Place> places_;  ///< of all scans
    Place latest_;            ///< of them
    Motion since_frame_;      ///< from the frame that the vehicle rides on, without matching
    double way_m_ = 0, chosen_at_m_ = 0;
    std::optional<GraphOptimiser> correction_;
    std::size_t correction_frames_ = 0;
    bool relink_after_ = false;
    Constraint loop_;          ///< that the correction under way is for
    StampNs stamp_ns_ = 0;     ///< of the scan at hand
    Motion since_last_frame_;  ///< since the latest frame was made
    std::vector<Correction> corrections_;
    SetAside<Pose2> correction_poses_;  ///< of all of them
    ReverseNavigation* reverse_navigation_ = nullptr;
    std::uint64_t unmatched_ = 0, degenerate_ = 0, motions_refused_ = 0;
    std::vector<Eigen::Matrix3d> frame_covariances_;  ///< after finish()
};

}  // namespace loopline::grid_slam
