/// The path on the Earth by an odometry and a GNSS receiver: heading found from motion, fixes used at their
/// own time whenever they come, all of it smoothed at the end.
#pragma once

#include <array>
#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "api/set_aside.h"
#include "fusion/earth_filter.h"
#include "fusion/heading_search.h"
#include "fusion/smoother.h"
#include "gnss/local_frame.h"

namespace loopline::fusion {

struct EarthPathSettings {
    FixNoiseSettings noise;
    /// Of the odometry's way after 1 m, beside what it says itself: errors that neighbouring motions share.
    double drift_m = 0.0015, drift_rad = 0.001 * M_PI / 180;
    /// Of the first pose against the horizon: roads lean less to the side than they climb.
    double sigma_roll_rad = 1.5 * M_PI / 180, sigma_pitch_rad = 4 * M_PI / 180;
    double heading_sigma_rad = 3 * M_PI / 180;  ///< with which the heading is taken to be known
    double gate = 0.999;                        ///< part of good fixes that are to pass
    /// If none was used for so long, fixes that agree with one another for some seconds are right, whatever
    /// the filter says.
    double re_entry_s = 30;
    double late_s = 5;  ///< one that comes later than this is of no use
};

/// What became of a fix.
enum class FixUse {
    used,
    no_position,   ///< the receiver had none, or it is dead reckoning
    before_path,   ///< from before the odometry's first pose
    after_path,    ///< from after its last one
    late,          ///< what came after it is settled
    off_the_path,  ///< farther off than all uncertainty explains
    heading_never_found
};
/// As part of a key: "off_the_path".
const char* name_of(FixUse use);
constexpr std::size_t fix_uses = static_cast<std::size_t>(FixUse::heading_never_found) + 1;

class EarthPath {
 public:
    explicit EarthPath(const EarthPathSettings& settings) : settings_(settings) {}
    /// What only the end needs goes there from now on; before the first pose.
    void keep_in(const std::filesystem::path& folder) { steps_.keep_in(folder, "fusion_steps"); }

    /// The odometry's next pose, later than the one before. `covariance`: what the motion since then adds, of
    /// (shift, turn) along the vehicle's axes there.
    void take_pose(StampNs stamp_ns, const Pose3& T_odom_base, const Matrix6d& covariance);
    void take_fix(const gnss::GnssFix& fix);
    /// Told of every fix when it is known what became of it.
    using Tell = std::function<void(const gnss::GnssFix&, FixUse)>;
    void tell_fates_to(Tell tell) { tell_ = std::move(tell); }

    std::size_t poses() const { return dropped_ + poses_.size(); }
    /// At the latest pose; none before the heading is known.
    std::optional<EarthState> latest() const;
    bool heading_known() const { return committed_.has_value(); }
    /// Local frame of the path on the Earth; none before the first fix.
    const std::optional<gnss::LocalFrame>& earth() const { return earth_; }

    /// End of the log: all poses, by all fixes. If the heading was never found, they are the odometry's, with
    /// the covariance of its way.
    std::vector<SmoothedPose> smoothed();

    std::size_t count(FixUse use) const { return count_[static_cast<std::size_t>(use)]; }
    /// Mean of the fixes' normalised squares by 3: 1 if the noise is as thought.
    double mean_square() const { return squares_ > 0 ? sum_of_squares_ / static_cast<double>(squares_) : 0; }
    std::size_t re_entries() const { return re_entries_; }
    /// When the heading was known: way of the odometry since the first pose, and its standard deviation.
    double heading_way_m() const { return heading_way_m_; }
    double heading_sigma_rad() const { return heading_found_sigma_rad_; }

 private:
    template <class Archive>
    friend void fields(Archive&, EarthPath&);
    struct PoseNode {
        StampNs stamp_ns = 0;
        Pose3 T_odom_base;
        Matrix6d covariance = Matrix6d::Zero();  ///< of the motion from the one before
        double way_m = 0;                        ///< since the first
    };
    struct Misfit {
        StampNs stamp_ns = 0;
        Eigen::Vector3d off_m;
    };
    /// The vehicle at a moment between the pose at `committed_` and the next one.
    struct Moment {
        Pose3 T_base_then;  ///< seen from that pose
        Twist3 velocity;    ///< a second, along the vehicle's axes
    };

    const PoseNode& pose(std::size_t number) const { return poses_[number - dropped_]; }
    Motion motion_to(std::size_t number) const;
    std::size_t pose_before(StampNs stamp_ns) const;
    void use_waiting();
    void settle_before(StampNs stamp_ns);
    void commit_next();
    void use(const gnss::GnssFix& fix);
    FixUse apply(const gnss::GnssFix& fix);
    void follow_fix_error(gnss::FixQuality quality, const SigmaOfFix& sigma);
    Moment moment(StampNs stamp_ns) const;
    bool update_place(const gnss::GnssFix& fix, const Pose3& T_base_then, const Eigen::Vector3d& white_m);
    void doubt_the_path(const Eigen::Vector3d& off_m);
    void update_velocity(const gnss::GnssFix& fix, const Moment& then);
    std::vector<SmoothedPose> path_of_odometry() const;
    void look_for_heading(const gnss::GnssFix& fix);
    void begin(const Pose3& T_enu_odom);
    bool is_re_entry(StampNs stamp_ns, const Eigen::Vector3d& off_m);
    void look_ahead();
    void tally(const gnss::GnssFix& fix, FixUse use);

    EarthPathSettings settings_;
    Tell tell_;
    std::optional<gnss::LocalFrame> earth_;
    std::deque<PoseNode> poses_;            ///< from the one at `committed_` on
    std::size_t dropped_ = 0;               ///< before them
    StampNs first_ns_ = 0;                  ///< stamp of the very first
    std::deque<gnss::GnssFix> waiting_;     ///< for a pose that is not earlier
    std::vector<gnss::GnssFix> early_;      ///< from before the heading was known
    std::vector<SeenFix> seen_;             ///< of them, those that the heading is sought by
    std::optional<std::size_t> committed_;  ///< the pose that state_ is at; fixes are used up to there
    EarthState state_, ahead_;              ///< there, and at the latest pose
    SigmaOfFix fix_sigma_;                  ///< of the slow error that is being followed
    ErrorProcess process_ = ErrorProcess::none;
    std::vector<Misfit> misfits_;  ///< since the last fix that was used
    StampNs used_ns_ = 0;          ///< stamp of that
    SetAside<SmootherStep> steps_;
    std::array<std::size_t, fix_uses> count_{};
    double sum_of_squares_ = 0;
    std::size_t squares_ = 0, re_entries_ = 0;
    double heading_way_m_ = 0, heading_found_sigma_rad_ = 0;
};

}  // namespace loopline::fusion
