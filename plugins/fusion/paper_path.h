/// The path on the Earth by the paper's filter, on the lidar's clock: frames of which every sensor tells
/// something in time are fused, others go on by the lidar alone (row C9).
#pragma once

#include <deque>
#include <filesystem>

#include "api/pose3_record.h"
#include "api/set_aside.h"
#include "fusion/fused_path.h"
#include "fusion/heading_start.h"
#include "fusion/paper_filter.h"
#include "gnss/fix_noise.h"

namespace loopline::fusion {

enum class Sync {
    threshold,   ///< the paper's: a fix counts as of the frame's own time if it is not farther from it
    interpolate  ///< any fix, moved to the frame's time by the odometry
};

struct PaperSettings {
    Sync sync = Sync::threshold;
    double sync_s = 0.05;
    bool wheels_are_there = false;  ///< then frames without them are not fused
    /// Standard deviations of a frame: of the prediction, of the lidar's and of the wheels' motion.
    double process_m = 0.2, process_rad = 2 * M_PI / 180;
    double lidar_m = 0.03, lidar_rad = 0.1 * M_PI / 180;
    double wheels_m = 0.05, wheels_rad = 0.5 * M_PI / 180;
    gnss::FixNoiseSettings noise;
    double heading_sigma_rad = 3 * M_PI / 180;  ///< with which the heading is taken to be known
    double late_s = 5;                          ///< a fix that comes later than this is of no use
};

class PaperPath : public FusedPath {
 public:
    explicit PaperPath(const PaperSettings& settings) : settings_(settings) {}
    void keep_in(const std::filesystem::path& folder) { done_.keep_in(folder, "fusion_paper_poses"); }

    void take_pose(StampNs stamp_ns, const Pose3& T_odom_base, const Matrix6d& covariance,
                   const std::optional<Twist2>& wheels) override;
    void take_fix(const gnss::GnssFix& fix, bool withheld) override;

    std::size_t poses() const override { return done_.size() + frames_.size() - (begun_ ? 1 : 0); }
    std::optional<PoseOnEarth> known() const override;
    std::vector<PoseOnEarth> finished() override;
    /// Frames of which all sensors told something in time.
    std::uint64_t fused() const { return fused_; }

 private:
    template <class Archive>
    friend void fields(Archive&, PaperPath&);
    struct Frame {
        StampNs stamp_ns = 0;
        Pose3 T_odom_base;
        std::optional<Twist2> wheels;
    };
    struct Done {
        Pose3Record T_enu_base;
        std::array<double, 36> covariance{};
    };
    /// The filter, and how the vehicle moved in the step before.
    struct Step {
        PaperFilter filter;
        double way_m = 0, turn_rad = 0;
    };

    void use(const gnss::GnssFix& fix);
    void look_for_heading(const gnss::GnssFix& fix);
    void settle_before(StampNs stamp_ns);
    void settle_next(const gnss::GnssFix* fix);
    Step next(const Step& before, const Frame& from, const Frame& to, const gnss::GnssFix* fix) const;
    Pose3 T_odom_at(StampNs stamp_ns) const;
    void look_ahead();
    void set_aside(const PoseOnEarth& pose);
    PoseOnEarth pose_of(const Step& step) const { return {step.filter.pose(), step.filter.covariance()}; }

    PaperSettings settings_;
    std::deque<Frame> frames_;  ///< from the one that step_ is at on; all before the heading is known
    StampNs first_ns_ = 0;
    double way_m_ = 0;
    std::deque<gnss::GnssFix> waiting_;
    HeadingStart start_;
    std::vector<gnss::GnssFix> early_;  ///< from before the heading was known
    bool begun_ = false;
    Step step_, ahead_;
    std::uint64_t fused_ = 0;
    SetAside<Done> done_;
};

}  // namespace loopline::fusion
