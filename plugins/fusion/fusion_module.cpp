#include "fusion/fusion_module.h"

#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <algorithm>
#include <cmath>

#include "api/observation_class.h"
#include "gnss/gps_observation.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(FusionModule, Module, loopline)

using namespace fusion;

ModuleInfo FusionModule::info() const {
    ModuleInfo info{"fusion",
                    "The path on the Earth, by an odometry, wheels and a GNSS receiver: finds its heading "
                    "from motion and "
                    "the scale of the wheels on the way, bridges outages, refuses fixes that can't be.",
                    {"CObservationGPS"},
                    {},
                    {"CObservationRobotPose", "CObservationOdometry"}};
    if (!motion_label_.empty()) {
        info.uses.emplace_back("CObservationRobotPose");
        info.takes_back = {motion_label_, motion_label_ + upright_suffix};
    }
    if (!told_wheels_label_.empty()) info.uses.emplace_back("CObservationOdometry");
    return info;
}

void FusionModule::start(const RunContext& context) {
    if (filter_ == Filter::paper) {
        paper_settings_.sync = sync_;
        paper_settings_.wheels_are_there = !told_wheels_label_.empty();
        paper_settings_.noise = settings_.noise;
        paper_settings_.heading_sigma_rad = settings_.heading_sigma_rad;
        paper_settings_.late_s = settings_.late_s;
        auto path = std::make_unique<PaperPath>(paper_settings_);
        path->keep_in(context.scratch_folder);
        paper_ = path.get();
        path_ = std::move(path);
    } else {
        auto path = std::make_unique<EarthPath>(settings_);
        path->keep_in(context.scratch_folder);
        error_state_ = path.get();
        path_ = std::move(path);
    }
    path_->tell_fates_to([this](const gnss::GnssFix& fix, FixUse use) { keep_fix(fix, use); });
    online_.keep_in(context.scratch_folder, "fusion_online");
    fixes_.keep_in(context.scratch_folder, "fusion_fixes");
    scratch_folder_ = context.scratch_folder;
}

void FusionModule::keep_fix(const gnss::GnssFix& fix, FixUse use) {
    if (use == FixUse::no_position || !path_->earth()) return;
    gnss::Geodetic antenna = fix.antenna;
    if (!fix.has_height) antenna.height_m = path_->earth()->origin().height_m;
    const Eigen::Vector3d p_enu_m = path_->earth()->p_enu_m(antenna);
    fixes_.push_back({fix.stamp_ns,
                      {p_enu_m.x(), p_enu_m.y(), fix.has_height ? p_enu_m.z() : NAN},
                      static_cast<std::uint64_t>(use)});
    if (!p_base_antenna_m_) p_base_antenna_m_ = fix.p_base_antenna_m;
    if (!geoid_separation_m_ && fix.geoid_separation_m != 0) geoid_separation_m_ = fix.geoid_separation_m;
}

void FusionModule::process(const StreamItem& item, Publisher& publisher) {
    const auto* observation = item.observation.get();
    if (first_ns_ == 0) first_ns_ = item.stamp_ns;
    if (const auto* gps = as<mrpt::obs::CObservationGPS>(observation)) return take_fix(*gps, item.stamp_ns);
    const std::string& label = observation->sensorLabel;
    const Moment now{item.sequence, item.stamp_ns, observation->timestamp};
    if (const auto* pose = as<mrpt::obs::CObservationRobotPose>(observation)) {
        if (label == motion_label_) take_pose(now, pose_of(*pose), publisher);
        if (label == motion_label_ + upright_suffix) take_upright(now, pose_of(*pose));
    } else if (const auto* wheels = as<mrpt::obs::CObservationOdometry>(observation)) {
        const auto& p = wheels->odometry;
        if (label == told_wheels_label_) take_wheels(now, {p.x(), p.y(), p.phi()}, publisher);
    }
}

void FusionModule::take_fix(const mrpt::obs::CObservationGPS& gps, StampNs stamp_ns) {
    if (!receiver_label_.empty() && gps.sensorLabel != receiver_label_) {
        ++fixes_of_others_;
        return;
    }
    ++fixes_came_;
    gnss::GnssFix fix = gnss::fix_from_mrpt(gps, stamp_ns).value_or(gnss::GnssFix{});
    fix.stamp_ns -= std::llround(1e9 * latency_s_);
    path_->take_fix(fix, is_withheld(fix.stamp_ns));
}

bool FusionModule::is_withheld(StampNs stamp_ns) const {
    if (withhold_s_ == 0) return false;
    const double since_s = seconds_between(first_ns_, stamp_ns);
    return since_s > 0 && std::fmod(since_s, withhold_every_s_) > withhold_every_s_ - withhold_s_;
}

/// If wheels tell of the same motion, it waits for them: they may stand behind it in the log.
void FusionModule::take_pose(const Moment& now, const PoseWithCovariance& pose, Publisher& publisher) {
    if (!pose.T_map_base.translation_m.allFinite() || !pose.T_map_base.rotation.coeffs().allFinite() ||
        !pose.covariance.allFinite()) {
        ++not_finite_;
        return;
    }
    if (waiting_) follow(waiting_->first, waiting_->second, publisher);
    waiting_.reset();
    if (last_ && now.stamp_ns <= last_ns_) {
        ++backwards_;
        return;
    }
    if (!told_wheels_label_.empty() && !wheel_path_.reaches(now.stamp_ns))
        waiting_ = {now, pose};
    else
        follow(now, pose, publisher);
}

void FusionModule::take_upright(const Moment& now, const PoseWithCovariance& levelling) {
    const Eigen::Matrix2d covariance_rad2 = levelling.covariance.block<2, 2>(3, 3);
    if (!levelling.T_map_base.rotation.coeffs().allFinite() || !covariance_rad2.allFinite()) {
        ++not_finite_;
        return;
    }
    upright_ = {now.stamp_ns, {levelling.T_map_base.rotation, covariance_rad2}};
}

void FusionModule::follow(const Moment& now, const PoseWithCovariance& pose, Publisher& publisher) {
    std::optional<Twist2> wheels;
    if (last_) wheels = wheel_path_.motion(last_ns_, now.stamp_ns);
    if (upright_ && error_state_ != nullptr && upright_->first == now.stamp_ns)
        error_state_->take_upright(upright_->second);
    path_->take_pose(now.stamp_ns, pose.T_map_base, last_ ? added_covariance(*last_, pose) : Matrix6d::Zero(),
                     wheels);
    last_ = pose;
    last_ns_ = now.stamp_ns;
    wheel_path_.forget_before(last_ns_);
    publish(now, pose.T_map_base, publisher);
}

void FusionModule::drain(Publisher& publisher) {
    if (waiting_) follow(waiting_->first, waiting_->second, publisher);
    waiting_.reset();
}

void FusionModule::take_wheels(const Moment& now, const Pose2& T_told_base, Publisher& publisher) {
    using Verdict = WheelReadings::Verdict;
    const Verdict verdict = wheel_readings_.take(now.stamp_ns, T_told_base);
    if (verdict == Verdict::not_finite || verdict == Verdict::backward) return;
    const Pose2& T_odom_base = wheel_readings_.T_odom_base();
    const Twist2 told = wheel_readings_.motion();
    wheel_path_.take(now.stamp_ns, T_odom_base);
    publish_calibrated(now, told, publisher);
    if (motion_label_.empty()) {
        error_state_->take_wheels(now.stamp_ns, told);
        wheel_path_.forget_before(now.stamp_ns);
        publish(now, Pose3(T_odom_base), publisher);
    } else if (waiting_ && wheel_path_.reaches(waiting_->first.stamp_ns)) {
        follow(waiting_->first, waiting_->second, publisher);
        waiting_.reset();
    }
}

void FusionModule::publish_calibrated(const Moment& now, const Twist2& told, Publisher& publisher) {
    const Twist2 twist = error_state_ != nullptr ? corrected(told, error_state_->wheel_errors()) : told;
    T_odom_calibrated_ = T_odom_calibrated_ * exp_se2(twist);
    const auto observation = calibrated_pool_.take();
    observation->sensorLabel = wheels_label;
    observation->timestamp = now.timestamp;
    observation->odometry = {T_odom_calibrated_.x_m, T_odom_calibrated_.y_m, T_odom_calibrated_.phi_rad};
    publisher.publish(observation, now.sequence);
}

/// What is known at the latest pose.
void FusionModule::publish(const Moment& now, const Pose3& T_odom_base, Publisher& publisher) {
    if (error_state_ != nullptr) {
        const Motion& motion = error_state_->latest_motion();
        auto& [T_fused_base, covariance] = fused_odometry_;
        const Pose3 T_fused_before = T_fused_base;
        T_fused_base = T_fused_base * motion.T_from_to;
        covariance = inertial::grown(covariance, T_fused_before, T_fused_base, motion.covariance);
        publisher.publish(pose_observation(odometry_label, now.timestamp, T_fused_base, covariance),
                          now.sequence);
    }

    Online online;
    online.sequence = now.sequence;
    online.stamp_ns = now.stamp_ns;
    online.T_odom_base = Pose3Record(T_odom_base);
    if (const auto known = path_->known()) {
        online.known = true;
        online.T_enu_base = Pose3Record(known->T_enu_base);
        publisher.publish(
            pose_observation(published_label, now.timestamp, known->T_enu_base, known->covariance),
            now.sequence);
    }
    online_.push_back(online);
}

void FusionModule::finish(Results& results) {
    if (online_.empty()) {
        if (results.refused) return;  // the module that should have published them says why it did not
        results.refused =
            motion_label_.empty()
                ? "no wheel odometry with the label " + told_wheels_label_ +
                      " came, which module fusion is for; see `loopline check` for the labels of the log, "
                      "and "
                      "name one in [fusion] wheels"
                : "no pose with the label " + motion_label_ +
                      " came, which module fusion is for; put the module that publishes it in [run] modules, "
                      "name another in [fusion] motion, or leave that empty for wheels alone";
        return;
    }
    const std::vector<PoseOnEarth> path = path_->finished();
    std::size_t known_from = online_.size();
    for (std::size_t i = 0; i < path.size(); ++i) {
        const Online online = online_[i];
        if (online.known) known_from = std::min(known_from, i);
        const Pose3& T_enu_base = path[i].T_enu_base;
        trajectory_.append_revised(online.sequence, online.stamp_ns,
                                   online.known ? online.T_enu_base.pose() : T_enu_base, T_enu_base,
                                   path[i].covariance);
    }
    trajectory_.set_known_from(known_from);
    trajectory_.finish_revision();
    report(results);
    if (results.earth) hand_over_inputs(path.front().T_enu_base, results);
}

}  // namespace loopline
