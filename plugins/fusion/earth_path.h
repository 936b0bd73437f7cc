/// The path on the Earth by an odometry, wheels and a GNSS receiver: heading found from motion, lasting
/// errors of the wheels found on the way, fixes used at their own time whenever they come, all of it smoothed
/// at the end.
#pragma once

#include <array>
#include <deque>
#include <filesystem>
#include <optional>
#include <vector>

#include "api/set_aside.h"
#include "fusion/earth_filter.h"
#include "fusion/heading_search.h"
#include "fusion/smoother.h"
#include "gnss/local_frame.h"

namespace loopline::fusion {

struct EarthPathSettings {
    FixNoiseSettings noise;
    WheelNoise wheels;
    /// Of the odometry's way after 1 m, beside what it says itself: errors that neighbouring motions share.
    double drift_m = 0.0015, drift_rad = 0.001 * M_PI / 180;
    /// Of the first pose against the horizon: roads lean less to the side than they climb.
    double sigma_roll_rad = 1.5 * M_PI / 180, sigma_pitch_rad = 4 * M_PI / 180;
    double heading_sigma_rad = 3 * M_PI / 180;  ///< with which the heading is taken to be known
    double gate = 0.999;                        ///< part of good fixes that are to pass
    double slip_gate = 0.9999;                  ///< part of good wheel readings that are to pass
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
    heading_never_found,
    withheld  ///< on purpose, to see how the path does without it
};
/// As part of a key: "off_the_path".
const char* name_of(FixUse use);
constexpr std::size_t fix_uses = static_cast<std::size_t>(FixUse::withheld) + 1;

/// What became of the motions that wheels told beside an odometry.
struct WheelUse {
    std::uint64_t used = 0;
    std::uint64_t slipped = 0;  ///< farther from the odometry's motion than all uncertainty explains
    double sum_of_squares = 0;  ///< normalised, of those that were used
    /// Over their number of directions: 1 if the noise is as thought.
    double mean_square() const { return used > 0 ? sum_of_squares / (3 * static_cast<double>(used)) : 0; }
};

/// A time in which fixes were withheld, and how far the path was from the last of them.
struct Gap {
    StampNs from_ns = 0, to_ns = 0;
    double way_m = 0;                                                ///< within it
    Eigen::Vector3d off_m = Eigen::Vector3d::Zero();                 ///< of the path, ENU
    Eigen::Vector3d dead_reckoning_off_m = Eigen::Vector3d::Zero();  ///< by the motion as it came
    Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();               ///< that the path claims
};

class EarthPath {
 public:
    explicit EarthPath(const EarthPathSettings& settings);
    /// What only the end needs goes there from now on; before the first pose.
    void keep_in(const std::filesystem::path& folder) { steps_.keep_in(folder, "fusion_steps"); }

    /// The odometry's next pose, later than the one before. `covariance`: what the motion since then adds, of
    /// (shift, turn) along the vehicle's axes there. `wheels`: what they tell of the same motion.
    void take_pose(StampNs stamp_ns, const Pose3& T_odom_base, const Matrix6d& covariance,
                   const std::optional<Twist2>& wheels = std::nullopt);
    /// The next pose by wheels alone: their motion since the one before.
    void take_wheels(StampNs stamp_ns, const Twist2& told);
    void take_fix(const gnss::GnssFix& fix, bool withheld = false);

    std::size_t poses() const { return dropped_ + poses_.size(); }
    /// At the latest pose; none before the heading is known.
    std::optional<EarthState> latest() const;
    bool heading_known() const { return committed_.has_value(); }
    /// The latest motion, as all who told of it have it.
    const Motion& latest_motion() const { return latest_motion_; }
    /// Lasting errors of the wheels, as known at the latest pose; known before the heading is.
    const Eigen::Vector3d& wheel_errors() const { return ahead_.wheel_errors; }
    Eigen::Vector3d wheel_error_sigmas() const;
    /// Local frame of the path on the Earth; none before the first fix.
    const std::optional<gnss::LocalFrame>& earth() const { return earth_; }

    /// End of the log: all poses, by all fixes. If the heading was never found, they are the odometry's, with
    /// the covariance of its way.
    std::vector<SmoothedPose> smoothed();

    std::size_t count(FixUse use) const { return count_[static_cast<std::size_t>(use)]; }
    const WheelUse& wheel_use() const { return wheel_use_; }
    const std::vector<Gap>& gaps() const { return gaps_; }
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
        Pose3 T_odom_base;                       ///< by the odometry, or by the wheels as they are
        Matrix6d covariance = Matrix6d::Zero();  ///< of the motion from the one before
        std::optional<Twist2> wheels;            ///< of the same motion
        bool by_wheels = false;                  ///< they alone
        double way_m = 0;                        ///< since the first
    };
    struct WaitingFix {
        gnss::GnssFix fix;
        bool withheld = false;
    };
    struct Misfit {
        StampNs stamp_ns = 0;
        Eigen::Vector3d off_m;
    };
    /// The vehicle at a moment between the pose at `committed_` and the next one.
    struct Moment {
        Pose3 T_base_then;  ///< seen from that pose
        Twist3 velocity;    ///< a second, along the vehicle's axes
        bool by_wheels = false;
    };
    /// Where the vehicle was at the beginning of a gap.
    struct GapStart {
        Pose3 T_enu_base, T_odom_base;
        double way_m = 0;
    };

    const PoseNode& pose(std::size_t number) const { return poses_[number - dropped_]; }
    void take(PoseNode node);
    double duration_s(std::size_t number) const;
    Motion odometry_to(std::size_t number) const;
    StateAndMotion motion_to(std::size_t number, const EarthState& from, WheelUse* use = nullptr) const;
    EarthState predict(std::size_t number, const EarthState& from) const;
    std::size_t pose_before(StampNs stamp_ns) const;
    Pose3 T_odom_at(std::size_t before, StampNs stamp_ns) const;
    void use_waiting();
    void settle_before(StampNs stamp_ns);
    void commit_next();
    void use(const WaitingFix& waiting);
    FixUse apply(const gnss::GnssFix& fix);
    void follow_fix_error(gnss::FixQuality quality, const SigmaOfFix& sigma);
    Moment moment(StampNs stamp_ns) const;
    bool update_place(const gnss::GnssFix& fix, const Pose3& T_base_then, const Eigen::Vector3d& white_m);
    void doubt_the_path(const Eigen::Vector3d& off_m);
    void update_velocity(const gnss::GnssFix& fix, const Moment& then);
    void look_at_withheld(const gnss::GnssFix& fix);
    std::vector<SmoothedPose> path_of_odometry() const;
    void look_for_heading(const gnss::GnssFix& fix);
    bool see(const gnss::GnssFix& fix);
    void begin(const Pose3& T_enu_odom);
    bool is_re_entry(StampNs stamp_ns, const Eigen::Vector3d& off_m);
    void look_ahead();
    void tally(FixUse use) { ++count_[static_cast<std::size_t>(use)]; }

    EarthPathSettings settings_;
    std::optional<gnss::LocalFrame> earth_;
    std::deque<PoseNode> poses_;            ///< from the one at `committed_` on
    std::size_t dropped_ = 0;               ///< before them
    StampNs first_ns_ = 0;                  ///< stamp of the very first
    std::deque<WaitingFix> waiting_;        ///< for a pose that is not earlier
    std::vector<gnss::GnssFix> early_;      ///< from before the heading was known
    std::vector<SeenFix> seen_;             ///< of them, those that the heading is sought by
    std::optional<std::size_t> committed_;  ///< the pose that state_ is at; fixes are used up to there
    EarthState state_;                      ///< there
    EarthState ahead_;  ///< at the latest pose; in the odometry's frame until the heading is known
    Motion latest_motion_;
    FixErrorProcess fix_process_;  ///< of the slow error that is being followed
    ErrorProcess process_ = ErrorProcess::none;
    std::vector<Misfit> misfits_;  ///< since the last fix that was used
    StampNs used_ns_ = 0;          ///< stamp of that
    SetAside<SmootherStep> steps_;
    std::array<std::size_t, fix_uses> count_{};
    WheelUse wheel_use_;
    std::vector<Gap> gaps_;
    GapStart gap_start_;  ///< of the last of them
    double sum_of_squares_ = 0;
    std::size_t squares_ = 0, re_entries_ = 0;
    double heading_way_m_ = 0, heading_found_sigma_rad_ = 0;
};

}  // namespace loopline::fusion
