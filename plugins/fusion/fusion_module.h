/// Module "fusion": poses of an odometry and fixes of a GNSS receiver in, the path on the Earth out.
#pragma once

#include <memory>

#include "api/module.h"
#include "api/pose3_record.h"
#include "api/pose_observation.h"
#include "api/set_aside.h"
#include "fusion/earth_path.h"

namespace loopline {

/// For every pose of the odometry, from when the heading is known, it publishes the pose in the local frame
/// of the first fix (x east, y north, z up) as CObservationRobotPose.
class FusionModule : public Module {
    DEFINE_MRPT_OBJECT(FusionModule, loopline)
 public:
    static constexpr const char* published_label = "fusion";

    ModuleInfo info() const override;
    ParameterTable parameters() override;
    void start(const RunContext&) override;
    void process(const StreamItem& item, Publisher& publisher) override;
    void finish(Results& results) override;
    const Trajectory* trajectory() const override { return &trajectory_; }
    bool can_resume() const override { return true; }
    void save_state(mrpt::serialization::CArchive& out) const override;
    void load_state(mrpt::serialization::CArchive& in) override;

 private:
    template <class Archive>
    friend void fields(Archive&, FusionModule&);
    /// A pose as it was known at its time.
    struct Online {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        Pose3Record T_enu_base, T_odom_base;
        bool known = false;
    };
    void take_pose(const StreamItem& item, const PoseWithCovariance& pose, Publisher& publisher);
    void keep_fix(const gnss::GnssFix& fix, fusion::FixUse use);
    void report(Results& results) const;
    void hand_over_inputs(const Pose3& T_enu_base_first, Results& results) const;

    fusion::EarthPathSettings settings_;
    std::string motion_label_ = "lidar_mapping", receiver_label_;

    std::unique_ptr<fusion::EarthPath> path_;
    std::optional<PoseWithCovariance> last_;
    StampNs last_ns_ = 0;
    SetAside<Online> online_;
    SetAside<PlacedFix> fixes_;                 ///< all with a place, as their fate was known
    std::optional<double> geoid_separation_m_;  ///< of the first of them
    std::filesystem::path scratch_folder_;
    std::int64_t backwards_ = 0;

    Trajectory trajectory_;  ///< laid out at the end
};

}  // namespace loopline
