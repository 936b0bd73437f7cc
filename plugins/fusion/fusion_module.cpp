#include "fusion/fusion_module.h"

#include <mrpt/obs/CObservationGPS.h>

#include <algorithm>
#include <cmath>

#include "api/observation_class.h"
#include "gnss/gps_observation.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(FusionModule, Module, loopline)

using namespace fusion;

ModuleInfo FusionModule::info() const {
    return {
        "fusion",
        "The path on the Earth, by an odometry and a GNSS receiver: finds its heading from motion, bridges "
        "outages, refuses fixes that can't be.",
        {"CObservationGPS"},
        {"CObservationRobotPose"},
        {"CObservationRobotPose"}};
}

ParameterTable FusionModule::parameters() {
    auto& s = settings_;
    ParameterTable table("fusion", info().sentence);
    const auto noise = [&table](const std::string& kind, FixNoise& n, const std::string& which) {
        table
            .real(kind + "_white_m", n.white_m, {1e-4, 1000},
                  "Standard deviation of east and of north of a " + which + ", of what is new in each.")
            .real(kind + "_correlated_m", n.correlated_m, {0, 1000}, "The same of its slow error.")
            .real(kind + "_correlation_s", n.correlation_s, {0.1, 1e6}, "How long that lasts.");
    };
    table
        .text("motion", motion_label_,
              "Label of the poses that tell the motion, CObservationRobotPose, such as lidar_mapping or "
              "lidar_odometry.")
        .text("receiver", receiver_label_, "Label of the GNSS receiver; empty: any.")
        .real("drift_m", s.drift_m, {0, 10},
              "What the motion errs by after 1 m, beside what its covariance says; it grows with the root of "
              "the way.")
        .angle("drift_deg", s.drift_rad, {0, 10}, "The same of its turn.");
    noise("fixed", s.noise.fixed, "fix with whole ambiguities");
    noise("float", s.noise.floating, "float fix");
    noise("differential", s.noise.differential, "differential fix");
    noise("single", s.noise.single, "single fix");
    table
        .real("vertical_factor", s.noise.vertical_factor, {0.1, 100},
              "Errors of the height are so many times those.")
        .real("sigma_velocity_mps", s.noise.sigma_velocity_mps, {1e-3, 100},
              "Standard deviation of the receiver's velocity, east and north each.")
        .angle(
            "sigma_roll_deg", s.sigma_roll_rad, {0.01, 90},
            "Standard deviation of how far the vehicle leans to the side at its first pose; roads lean less "
            "than they climb.")
        .angle("sigma_pitch_deg", s.sigma_pitch_rad, {0.01, 90}, "And of how steeply it stands there.")
        .angle("heading_sigma_deg", s.heading_sigma_rad, {0.01, 20},
               "The heading is taken to be known with this standard deviation.")
        .real("gate", s.gate, {0.5, 0.999999},
              "Part of good fixes that are to pass: what is farther off than they are is refused.")
        .real("re_entry_s", s.re_entry_s, {1, 3600},
              "If no fix was used for so long, those that agree with one another for some seconds are right, "
              "whatever the path so far says.")
        .real("late_s", s.late_s, {0, 60}, "A fix that comes later than this is of no use.");
    return table;
}

void FusionModule::start(const RunContext& context) {
    path_ = std::make_unique<EarthPath>(settings_);
    path_->keep_in(context.scratch_folder);
    path_->tell_fates_to([this](const gnss::GnssFix& fix, FixUse use) { keep_fix(fix, use); });
    online_.keep_in(context.scratch_folder, "fusion_online");
    fixes_.keep_in(context.scratch_folder, "fusion_fixes");
    scratch_folder_ = context.scratch_folder;
}

void FusionModule::keep_fix(const gnss::GnssFix& fix, FixUse use) {
    if (use == FixUse::no_position) return;
    gnss::Geodetic antenna = fix.antenna;
    if (!fix.has_height) antenna.height_m = path_->earth()->origin().height_m;
    const Eigen::Vector3d p_enu_m = path_->earth()->p_enu_m(antenna);
    fixes_.push_back({fix.stamp_ns,
                      {p_enu_m.x(), p_enu_m.y(), fix.has_height ? p_enu_m.z() : NAN},
                      static_cast<std::uint64_t>(use)});
    if (!geoid_separation_m_ && fix.geoid_separation_m != 0) geoid_separation_m_ = fix.geoid_separation_m;
}

void FusionModule::process(const StreamItem& item, Publisher& publisher) {
    if (const auto* gps = as<mrpt::obs::CObservationGPS>(item.observation.get())) {
        if (!receiver_label_.empty() && gps->sensorLabel != receiver_label_) return;
        path_->take_fix(gnss::fix_from_mrpt(*gps, item.stamp_ns).value_or(gnss::GnssFix{}));
        return;
    }
    const auto* pose = as<mrpt::obs::CObservationRobotPose>(item.observation.get());
    if (pose == nullptr || pose->sensorLabel != motion_label_) return;
    take_pose(item, pose_of(*pose), publisher);
}

void FusionModule::take_pose(const StreamItem& item, const PoseWithCovariance& pose, Publisher& publisher) {
    if (last_ && item.stamp_ns <= last_ns_) {
        ++backwards_;
        return;
    }
    path_->take_pose(item.stamp_ns, pose.T_map_base,
                     last_ ? added_covariance(*last_, pose) : Matrix6d::Zero());
    last_ = pose;
    last_ns_ = item.stamp_ns;
    Online online;
    online.sequence = item.sequence;
    online.stamp_ns = item.stamp_ns;
    online.T_odom_base = Pose3Record(pose.T_map_base);
    if (const auto state = path_->latest()) {
        online.known = true;
        online.T_enu_base = Pose3Record(state->T_enu_base);
        publisher.publish(pose_observation(published_label, item.observation->timestamp, state->T_enu_base,
                                           state->covariance.topLeftCorner<6, 6>()));
    }
    online_.push_back(online);
}

void FusionModule::finish(Results& results) {
    if (online_.empty()) {
        results.refused =
            "no pose with the label " + motion_label_ +
            " came, which module fusion is for; put the module that publishes it before fusion in [run] "
            "modules, or name another in [fusion] motion";
        return;
    }
    const std::vector<SmoothedPose> smoothed = path_->smoothed();
    std::size_t known_from = online_.size();
    for (std::size_t i = 0; i < smoothed.size(); ++i) {
        const Online online = online_[i];
        if (online.known) known_from = std::min(known_from, i);
        const Pose3& T_enu_base = smoothed[i].T_enu_base;
        trajectory_.append_revised(online.sequence, online.stamp_ns,
                                   online.known ? online.T_enu_base.pose() : T_enu_base, T_enu_base,
                                   smoothed[i].covariance);
    }
    trajectory_.set_known_from(known_from);
    trajectory_.finish_revision();
    report(results);
    if (results.earth) hand_over_inputs(smoothed.front().T_enu_base, results);
}

/// What the path was made from, for who wants to compare: the motion alone, from the first pose on, and the
/// fixes.
void FusionModule::hand_over_inputs(const Pose3& T_enu_base_first, Results& results) const {
    const Pose3 T_enu_odom = T_enu_base_first * online_.front().T_odom_base.pose().inverse();
    auto motion = std::make_shared<Trajectory>();
    motion->keep_in(scratch_folder_);
    for (const Online& online : online_)
        motion->append(online.sequence, online.stamp_ns, T_enu_odom * online.T_odom_base.pose(), {});
    results.uncorrected = NamedPath{"without fixes", motion};
    results.fixes.list = &fixes_;
    for (std::size_t use = 0; use < fix_uses; ++use)
        results.fixes.fates.push_back(name_of(static_cast<FixUse>(use)));
}

void FusionModule::report(Results& results) const {
    auto& metrics = results.metrics;
    const auto count = [&](FixUse use) { return static_cast<std::int64_t>(path_->count(use)); };
    std::int64_t refused = 0;
    for (std::size_t i = 1; i < fix_uses; ++i) {
        const auto use = static_cast<FixUse>(i);
        refused += count(use);
        if (count(use) > 0) metrics[std::string("gnss_refused_") + name_of(use)] = count(use);
    }
    if (backwards_ > 0) metrics["poses_backward"] = backwards_;
    metrics["gnss_used"] = count(FixUse::used);
    metrics["gnss_refused"] = refused;
    if (!path_->heading_known()) {
        results.warnings.push_back(
            "the fixes of the receiver never told the heading of the path, so it is not placed on the Earth; "
            "its frame is that of " +
            motion_label_);
        return;
    }
    const gnss::Geodetic& origin = path_->earth()->origin();
    results.earth =
        EarthFrame{origin.latitude_deg, origin.longitude_deg, origin.height_m, 0, geoid_separation_m_};
    metrics["gnss_re_entries"] = static_cast<std::int64_t>(path_->re_entries());
    metrics["gnss_mean_square"] = path_->mean_square();
    metrics["heading_found_way_m"] = path_->heading_way_m();
    metrics["heading_found_sigma_deg"] = path_->heading_sigma_rad() * 180 / M_PI;
}

}  // namespace loopline
