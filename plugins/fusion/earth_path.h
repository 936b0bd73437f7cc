/// The path on the Earth by an odometry, wheels and a GNSS receiver: heading found from motion, lasting
/// errors of the wheels found on the way, fixes used at their own time whenever they come, all of it smoothed
/// at the end.
#pragma once

#include <deque>
#include <filesystem>
#include <optional>
#include <vector>

#include "api/set_aside.h"
#include "fusion/earth_filter.h"
#include "fusion/fused_path.h"
#include "fusion/heading_start.h"
#include "fusion/re_entry.h"
#include "fusion/smoother.h"

namespace loopline::fusion {

struct EarthPathSettings {
    gnss::FixNoiseSettings noise;
    WheelNoise wheels;
    /// Of the odometry's way after 1 m, beside what it says itself: errors that neighbouring motions share.
    double drift_m = 0.001, drift_rad = 0.001 * M_PI / 180;
    /// Of the first pose against the horizon: roads lean less to the side than they climb.
    double sigma_roll_rad = 1.5 * M_PI / 180, sigma_pitch_rad = 4 * M_PI / 180;
    /// Of what walls together lean, beside what the odometry says of their upright; 0: that counts for
    /// nothing.
    double sigma_upright_rad = 0.3 * M_PI / 180;
    /// Of the antenna's place on the vehicle, forward and to the left each, about what the log says.
    double sigma_antenna_m = 0;
    double heading_sigma_rad = 3 * M_PI / 180;  ///< with which the heading is taken to be known
    double gate = 0.999;                        ///< part of good fixes that are to pass
    double slip_gate = 0.9999;                  ///< part of good wheel readings that are to pass
    /// Where the odometry is less certain of a motion than this it may have it from the wheels, which lead it
    /// along a tunnel: there they count alone.
    double held_m = 0.01, held_rad = 0.3 * M_PI / 180;
    /// If none was used for so long, fixes that agree with one another for some seconds are right, whatever
    /// the filter says.
    double re_entry_s = 30;
    double late_s = 5;  ///< one that comes later than this is of no use
    /// Of the fixes' times, new in each: they count less along the way.
    double sigma_latency_s = 0;
};

/// The time from the last fix that was used to the last of those that were withheld after it, and how far the
/// path was by then from where all fixes have it, those after the gap included: a single fix may be wrong.
struct Gap {
    StampNs from_ns = 0, to_ns = 0;
    std::size_t end_pose = 0;
    double way_m = 0;                                               ///< within it
    Eigen::Vector3d end_m = Eigen::Vector3d::Zero();                ///< where the path was at its end, ENU
    Eigen::Vector3d dead_reckoned_end_m = Eigen::Vector3d::Zero();  ///< by the motion as it came
    Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();              ///< that the path claimed
    /// Of the two ends; when the path is finished.
    Eigen::Vector3d off_m = Eigen::Vector3d::Zero(), dead_reckoning_off_m = Eigen::Vector3d::Zero();
};

/// What an odometry knows of the upright, by its own map.
struct Upright {
    Eigen::Quaterniond R_level_odom = Eigen::Quaterniond::Identity();
    /// Of the turn about the axes x and y, levelled, that this errs by.
    Eigen::Matrix2d covariance_rad2 = Eigen::Matrix2d::Zero();
};

class EarthPath : public FusedPath {
 public:
    explicit EarthPath(const EarthPathSettings& settings);
    /// What only the end needs goes there from now on; before the first pose.
    void keep_in(const std::filesystem::path& folder) { steps_.keep_in(folder, "fusion_steps"); }

    void take_pose(StampNs stamp_ns, const Pose3& T_odom_base, const Matrix6d& covariance,
                   const std::optional<Twist2>& wheels = std::nullopt) override;
    /// Told just before the pose at which it is so.
    void take_upright(const Upright& upright) { upright_ = upright; }
    /// The next pose by wheels alone: their motion since the one before.
    void take_wheels(StampNs stamp_ns, const Twist2& told);
    void take_fix(const gnss::GnssFix& fix, bool withheld = false) override;

    std::size_t poses() const override { return dropped_ + poses_.size(); }
    std::optional<PoseOnEarth> known() const override;
    /// At the latest pose; none before the heading is known.
    std::optional<EarthState> latest() const;
    bool heading_known() const { return committed_.has_value(); }
    /// Smoothed; with the covariance of the odometry's way if the heading was never found.
    std::vector<PoseOnEarth> finished() override;
    /// The latest motion, as all who told of it have it.
    const Motion& latest_motion() const { return latest_motion_; }
    /// Lasting errors of the wheels, as known at the latest pose; known before the heading is.
    const WheelErrors& wheel_errors() const { return ahead_.wheel_errors; }
    WheelErrors wheel_error_sigmas() const;
    const Eigen::Vector3d& antenna_off_m() const { return state_.antenna_off_m; }
    const std::vector<Gap>& gaps() const { return gaps_; }
    /// Mean of the fixes' normalised squares by 3: 1 if the noise is as thought.
    double mean_square() const { return squares_ > 0 ? sum_of_squares_ / static_cast<double>(squares_) : 0; }
    std::size_t re_entries() const { return re_entries_; }

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
        std::optional<Upright> upright;
    };
    struct WaitingFix {
        gnss::GnssFix fix;
        bool withheld = false;
    };
    /// Where the vehicle was at the last fix that was used.
    struct Used {
        Pose3 T_enu_base, T_odom_base;
        double way_m = 0;
    };
    /// The path as it was before what it has rested on since, which may have been reflected.
    struct Foothold {
        std::size_t committed = 0, steps = 0, fixes = 0;  ///< of recent_steps_, of since_
        EarthState state;
        EarthState without;  ///< at `committed_` by the motion alone, without what came since
        /// By how much the fixes before and those after contradict one another; 0: it may be drift.
        double contradicted_m = 0;
        double rested_s = 0;         ///< for which the path rested on those before
        bool heading_holds = false;  ///< of the foothold before: from there motion led close to those after
        StampNs agrees_ns = 0;
        std::size_t agreeing = 0;  ///< fixes, from then on, that agree with that and not with the path
        ReEntry re_entry;
        FixErrorProcess fix_process;
        gnss::ErrorProcess process = gnss::ErrorProcess::none;
        StampNs used_ns = 0;
        Used used;
        std::vector<Gap> gaps;
        double sum_of_squares = 0;
        std::size_t squares = 0;
    };
    /// A fix that came since, and what became of it so far.
    struct JudgedFix {
        WaitingFix waiting;
        FixUse use = FixUse::used;
        bool barred = false;      ///< the path has rested on it, and was wrong
        bool outweighed = false;  ///< others that contradict it came for longer
    };
    /// What a fix's place has led to.
    enum class Placed { by_fix, fix_is_off, path_was_wrong };
    /// The vehicle at a moment between the pose at `committed_` and the next one.
    struct Moment {
        Pose3 T_base_then;  ///< seen from that pose
        Twist3 velocity;    ///< a second, along the vehicle's axes
        bool by_wheels = false;

        Eigen::Vector3d of_antenna_mps(const Eigen::Vector3d& p_base_antenna_m) const {
            return velocity.shift_m + velocity.turn_rad.cross(p_base_antenna_m);
        }
    };
    /// A fix of which no more than the pose at `committed_` is earlier.
    struct PresentFix {
        gnss::GnssFix fix;
        gnss::SigmaOfFix sigma;
        Moment then;
    };

    const PoseNode& pose(std::size_t number) const { return poses_[number - dropped_]; }
    void take(PoseNode node);
    double duration_s(std::size_t number) const;
    double speed_mps(std::size_t number) const;
    void forget_what_goes_with_free_ways(Matrix6d& covariance) const;
    Motion odometry_to(std::size_t number) const;
    Motion without_what_wheels_told(Motion motion) const;
    StateAndMotion motion_to(std::size_t number, const EarthState& from, WheelUse* use = nullptr) const;
    EarthState predict(std::size_t number, const EarthState& from) const;
    EarthState upright(std::size_t number, const EarthState& state) const;
    std::size_t pose_before(StampNs stamp_ns) const;
    Pose3 T_odom_at(std::size_t before, StampNs stamp_ns) const;
    void use_waiting();
    void settle_before(StampNs stamp_ns);
    void commit_next();
    void add_step(const SmootherStep& step);
    void judge(const WaitingFix& waiting, FixUse use);
    void gain_foothold(const ReEntry& re_entry);
    void remember_contradiction(const PresentFix& seen, double off_m);
    Innovation<3> innovation_without(const Foothold& foothold, const PresentFix& seen) const;
    bool others_agree_without(const PresentFix& seen, double off_m);
    void go_back(const PresentFix& seen, double off_m);
    void weigh_latest_re_entry();
    void mark_used(std::size_t from, std::size_t to, double off_m, bool JudgedFix::*as);
    void use_again(bool heading_holds);
    void leave_footholds();
    void use(const WaitingFix& waiting);
    FixUse apply(const gnss::GnssFix& fix);
    void follow_fix_error(gnss::FixQuality quality, const gnss::SigmaOfFix& sigma);
    Moment moment(StampNs stamp_ns) const;
    Innovation<3> innovation_of(const PresentFix& seen, const EarthState& state) const;
    bool passes(const Innovation<3>& place) const;
    /// `off_m`: how far the fix is from the path.
    Placed update_place(const PresentFix& seen, double& off_m);
    void doubt_the_path(const Eigen::Vector3d& off_m, double way_m);
    void update_velocity(const gnss::GnssFix& fix, const Moment& then);
    void look_at_withheld(const gnss::GnssFix& fix);
    void judge_gaps(const std::vector<PoseOnEarth>& path);
    std::vector<PoseOnEarth> path_of_odometry() const;
    void look_for_heading(const gnss::GnssFix& fix);
    std::optional<FoundHeading> see_for_heading(const gnss::GnssFix& fix);
    void doubt_origin();
    void begin(const Pose3& T_enu_odom);
    void look_ahead();

    EarthPathSettings settings_;
    std::deque<PoseNode> poses_;            ///< from the one at `committed_` on
    std::size_t dropped_ = 0;               ///< before them
    StampNs first_ns_ = 0;                  ///< stamp of the very first
    std::deque<WaitingFix> waiting_;        ///< for a pose that is not earlier
    std::vector<gnss::GnssFix> early_;      ///< from before the heading was known
    HeadingStart start_;                    ///< by them
    std::optional<std::size_t> committed_;  ///< the pose that state_ is at; fixes are used up to there
    EarthState state_;                      ///< there
    EarthState ahead_;  ///< at the latest pose; in the odometry's frame until the heading is known
    Motion latest_motion_;
    std::optional<Upright> upright_;  ///< at the next pose
    FixErrorProcess fix_process_;     ///< of the slow error that is being followed
    gnss::ErrorProcess process_ = gnss::ErrorProcess::none;
    ReEntry re_entry_;
    StampNs used_ns_ = 0;  ///< stamp of the last fix that was used
    SetAside<SmootherStep> steps_;
    std::vector<Foothold> footholds_;      ///< until the path rests on enough
    std::vector<JudgedFix> since_;         ///< the first of them
    SetAside<SmootherStep> recent_steps_;  ///< since then
    bool goes_back_ = false;               ///< fixes since a foothold are being used again
    std::vector<Gap> gaps_;
    Used used_;
    double sum_of_squares_ = 0;
    std::size_t squares_ = 0, re_entries_ = 0;
};

}  // namespace loopline::fusion
