/// Module "fusion": poses of an odometry, of wheels or of both, and fixes of a GNSS receiver in, the path on
/// the Earth out.
#pragma once

#include <mrpt/obs/CObservationOdometry.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "api/module.h"
#include "api/observation_pool.h"
#include "api/planar_path.h"
#include "api/pose3_record.h"
#include "api/pose_observation.h"
#include "api/set_aside.h"
#include "fusion/earth_path.h"
#include "fusion/paper_path.h"
#include "fusion/wheel_readings.h"

namespace mrpt::obs {
class CObservationGPS;
}

namespace loopline {

/// For every pose of the odometry (of the wheels, if there is no other) it publishes
/// - "fusion", from when the heading is known: the pose in the local frame of the first fix (x east, y north,
///   z up), CObservationRobotPose;
/// - "fused_odometry", by the error-state filter: the way so far by all who tell of motion, in a frame that
/// no
///   fix ever moves, CObservationRobotPose;
/// and for every pose of the wheels
/// - "calibrated_wheels": their way without the errors that last, CObservationOdometry, at once, so that a
///   module that matches scans can begin there; what that finds may come back as the odometry.
class FusionModule : public Module {
    DEFINE_MRPT_OBJECT(FusionModule, loopline)
 public:
    static constexpr const char *published_label = "fusion", *odometry_label = "fused_odometry",
                                *wheels_label = "calibrated_wheels";
    /// Behind the label of the motion: that of what its module knows of the upright.
    static constexpr const char* upright_suffix = "_upright";

    ModuleInfo info() const override;
    ParameterTable parameters() override;
    std::string check() const override;
    void start(const RunContext&) override;
    void process(const StreamItem& item, Publisher& publisher) override;
    void drain(Publisher& publisher) override;
    void finish(Results& results) override;
    const Trajectory* trajectory() const override { return &trajectory_; }
    bool can_resume() const override { return true; }
    void save_state(mrpt::serialization::CArchive& out) const override;
    void load_state(mrpt::serialization::CArchive& in) override;

 private:
    template <class Archive>
    friend void fields(Archive&, FusionModule&);
    /// Of an observation.
    struct Moment {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        mrpt::Clock::time_point timestamp;
    };
    /// A pose as it was known at its time.
    struct Online {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        Pose3Record T_enu_base, T_odom_base;
        bool known = false;
    };
    void take_fix(const mrpt::obs::CObservationGPS& gps, StampNs stamp_ns);
    bool is_withheld(StampNs stamp_ns) const;
    void take_pose(const Moment& now, const PoseWithCovariance& pose, Publisher& publisher);
    void take_upright(const Moment& now, const PoseWithCovariance& levelling);
    void follow(const Moment& now, const PoseWithCovariance& pose, Publisher& publisher);
    void take_wheels(const Moment& now, const Pose2& T_told_base, Publisher& publisher);
    void publish(const Moment& now, const Pose3& T_odom_base, Publisher& publisher);
    void publish_calibrated(const Moment& now, const Twist2& told, Publisher& publisher);
    void keep_fix(const gnss::GnssFix& fix, fusion::FixUse use);
    void report(Results& results) const;
    void hand_over_inputs(const Pose3& T_enu_base_first, Results& results) const;
    void report_wheels(Results& results) const;
    void report_fixes(Results& results) const;
    void report_what_never_came(Results& results) const;
    void report_gaps(Results& results) const;
    void report_lag(Results& results) const;

    enum class Filter { error_state, paper };
    Filter filter_ = Filter::error_state;
    fusion::Sync sync_ = fusion::Sync::interpolate;
    fusion::EarthPathSettings settings_;
    fusion::PaperSettings paper_settings_;
    std::string motion_label_ = "lidar_mapping", told_wheels_label_, receiver_label_;
    double latency_s_ = 0, withhold_s_ = 0, withhold_every_s_ = 300;

    std::unique_ptr<fusion::FusedPath> path_;
    fusion::EarthPath* error_state_ = nullptr;  ///< which is path_, or null
    fusion::PaperPath* paper_ = nullptr;        ///< the same
    std::optional<PoseWithCovariance> last_;
    StampNs last_ns_ = 0, first_ns_ = 0;
    std::optional<std::pair<Moment, PoseWithCovariance>> waiting_;  ///< for wheels of its time
    std::optional<std::pair<StampNs, fusion::Upright>> upright_;    ///< the latest
    PlanarPath wheel_path_;
    fusion::WheelReadings wheel_readings_;
    Pose2 T_odom_calibrated_;  ///< wheels without the errors that last
    PoseWithCovariance fused_odometry_;
    ObservationPool<mrpt::obs::CObservationOdometry> calibrated_pool_;
    SetAside<Online> online_;
    SetAside<PlacedFix> fixes_;                 ///< all with a place, as their fate was known
    std::optional<double> geoid_separation_m_;  ///< of the first of them
    std::optional<Eigen::Vector3d> p_base_antenna_m_;
    std::filesystem::path scratch_folder_;
    std::int64_t backwards_ = 0, not_finite_ = 0;        ///< poses
    std::int64_t fixes_of_others_ = 0, fixes_came_ = 0;  ///< of receivers that are not wanted, and that are

    Trajectory trajectory_;  ///< laid out at the end
};

}  // namespace loopline
