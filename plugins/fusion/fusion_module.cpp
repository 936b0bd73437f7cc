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

namespace {
constexpr double least_gap_way_m = 20;  // of which a part of the way makes sense
constexpr std::size_t most_told_gaps = 99;
}  // namespace

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
        info.takes_back = {motion_label_};
    }
    if (!told_wheels_label_.empty()) info.uses.emplace_back("CObservationOdometry");
    return info;
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
        .choice("filter", filter_, {{"error_state", Filter::error_state}, {"paper", Filter::paper}},
                "On errors of the pose and of its sensors, smoothed at the end; or the paper's light one.")
        .choice("sync", sync_, {{"interpolate", Sync::interpolate}, {"threshold", Sync::threshold}},
                "Each sensor at its own time; or, with filter = paper, only frames of which all sensors tell "
                "something within sync_s, others going on by the odometry alone.")
        .real("sync_s", paper_settings_.sync_s, {0, 10}, "The threshold of that.")
        .text(
            "motion", motion_label_,
            "Label of the poses that tell the motion, CObservationRobotPose, such as lidar_mapping or "
            "lidar_odometry; the module that publishes them may stand before fusion or behind it. Empty: the "
            "wheels alone.")
        .text("wheels", told_wheels_label_,
              "Label of wheel odometry, CObservationOdometry, such as odometry_at_sweep or that of the log; "
              "empty: none.")
        .text("receiver", receiver_label_, "Label of the GNSS receiver; empty: any.")
        .real("drift_m", s.drift_m, {0, 10},
              "What the motion errs by after 1 m, beside what its covariance says; it grows with the root of "
              "the way.")
        .angle("drift_deg", s.drift_rad, {0, 10}, "The same of its turn.")
        .real("wheel_scale", s.wheels.first[way_scale], {0, 1},
              "Standard deviation of the wheels' scale, 1 being all of the way, before anything tells it.")
        .real("wheel_turn_scale", s.wheels.first[turn_scale], {0, 2}, "The same of the scale of their turn.")
        .angle("wheel_bend_deg", s.wheels.first[bend], {0, 45},
               "The same of what they turn too far in 1 m, as by a steering that is off its middle.")
        .real("wheel_one_sided", s.wheels.first[one_sided], {0, 1},
              "The same of what turns to the left are larger by, and those to the right smaller.")
        .real("wheel_curve_m2", s.wheels.first[curve], {0, 100},
              "The same of what turns are larger by, times their curvature squared: steering is not linear.")
        .real("wheel_along_m", s.wheels.along_m, {0, 10},
              "Noise of the wheels' way after 1 m; it grows with the root of the way.")
        .real("wheel_across_m", s.wheels.across_m, {0, 10}, "The same to the side.")
        .angle("wheel_turn_deg", s.wheels.turn_rad, {0, 45}, "The same of the heading after 1 m.")
        .angle("wheel_turn_per_turn_deg", s.wheels.turn_per_turn_rad, {0, 360},
               "And after one full turn, beside it.")
        .real("wheel_up_m", s.wheels.up_m, {0, 10},
              "What the road rises by after 1 m, which wheels do not tell, beside what its slope does.")
        .angle("wheel_tilt_deg", s.wheels.tilt_rad, {0, 45}, "And what its slope changes by after 1 m.")
        .real(
            "held_m", s.held_m, {1e-6, 10},
            "Where the odometry is less certain of a motion than this it may have it from the wheels, which "
            "lead it along a tunnel: there they count alone.")
        .angle("held_deg", s.held_rad, {1e-6, 180}, "The same of a turn.")
        .real("slip_gate", s.slip_gate, {0.5, 0.9999999},
              "Part of good wheel readings that are to pass: wheels that are farther from the odometry's "
              "motion have slipped.");
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
        .real("sigma_antenna_m", s.sigma_antenna_m, {0, 10},
              "Standard deviation of the antenna's place on the vehicle, forward and to the left each, about "
              "what the log says; it is found where the vehicle turns.")
        .angle("heading_sigma_deg", s.heading_sigma_rad, {0.01, 20},
               "The heading is taken to be known with this standard deviation.")
        .real("gate", s.gate, {0.5, 0.999999},
              "Part of good fixes that are to pass: what is farther off than they are is refused.")
        .real("re_entry_s", s.re_entry_s, {1, 3600},
              "If no fix was used for so long, those that agree with one another for some seconds are right, "
              "whatever the path so far says.")
        .real("late_s", s.late_s, {0, 60}, "A fix that comes later than this is of no use.")
        .real("latency_s", latency_s_, {-10, 10},
              "The log stamps fixes so much later than they are of, as when they are stamped on reception.")
        .real("withhold_s", withhold_s_, {0, 3600},
              "Fixes are withheld for so long, again and again, to see how far the path is from them at the "
              "end of each such gap; 0: never.")
        .real("withhold_every_s", withhold_every_s_, {1, 1e6}, "And so often: at the end of each such time.");
    return table;
}

std::string FusionModule::check() const {
    if (motion_label_.empty() && told_wheels_label_.empty())
        return "motion and wheels are both empty; name the label of poses in one of them, such as motion = "
               "lidar_mapping";
    if (sync_ == Sync::threshold && filter_ != Filter::paper)
        return "sync = threshold is for filter = paper; the other filter takes each fix at its own time";
    if (filter_ == Filter::paper && motion_label_.empty())
        return "filter = paper works on the clock of an odometry in space; name its label in motion, or take "
               "filter = error_state for wheels alone";
    if (withhold_s_ > 0 && withhold_s_ >= withhold_every_s_)
        return "withhold_s = " + std::to_string(withhold_s_) +
               " leaves no fixes at all; make it shorter than "
               "withhold_every_s";
    return {};
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
    } else if (const auto* wheels = as<mrpt::obs::CObservationOdometry>(observation)) {
        const auto& p = wheels->odometry;
        if (label == told_wheels_label_) take_wheels(now, {p.x(), p.y(), p.phi()}, publisher);
    }
}

void FusionModule::take_fix(const mrpt::obs::CObservationGPS& gps, StampNs stamp_ns) {
    if (!receiver_label_.empty() && gps.sensorLabel != receiver_label_) return;
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

void FusionModule::follow(const Moment& now, const PoseWithCovariance& pose, Publisher& publisher) {
    std::optional<Twist2> wheels;
    if (last_) wheels = wheel_path_.motion(last_ns_, now.stamp_ns);
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

void FusionModule::take_wheels(const Moment& now, const Pose2& T_odom_base, Publisher& publisher) {
    const bool finite = std::isfinite(T_odom_base.x_m) && std::isfinite(T_odom_base.y_m) &&
                        std::isfinite(T_odom_base.phi_rad);
    if (!finite || !wheel_path_.take(now.stamp_ns, T_odom_base)) {
        ++backwards_;
        return;
    }
    const Twist2 told = last_wheels_ ? log_se2(last_wheels_->inverse() * T_odom_base) : Twist2{};
    last_wheels_ = T_odom_base;
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
        const Matrix6d F = carried_along(T_fused_base.translation_m - T_fused_before.translation_m),
                       R = turned_both(T_fused_before.rotation);
        covariance = F * covariance * F.transpose() + R * motion.covariance * R.transpose();
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
        results.refused =
            "no pose with the label " + (motion_label_.empty() ? told_wheels_label_ : motion_label_) +
            " came, which module fusion is for; put the module that publishes it in [run] modules, or name "
            "another in [fusion] " +
            (motion_label_.empty() ? "wheels" : "motion");
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
    report_wheels(results);
    report_gaps(results);
    metrics["gnss_used"] = count(FixUse::used);
    metrics["gnss_refused"] = refused;
    if (!path_->known()) {
        results.warnings.push_back(
            "the fixes of the receiver never told the heading of the path, so it is not placed on the Earth; "
            "its frame is that of " +
            (motion_label_.empty() ? told_wheels_label_ : motion_label_));
        return;
    }
    const gnss::Geodetic& origin = path_->earth()->origin();
    results.earth =
        EarthFrame{origin.latitude_deg, origin.longitude_deg, origin.height_m, 0, geoid_separation_m_};
    metrics["heading_found_way_m"] = path_->heading().way_m;
    metrics["heading_found_sigma_deg"] = path_->heading().sigma_rad * 180 / M_PI;
    if (paper_ != nullptr) metrics["frames_fused"] = static_cast<std::int64_t>(paper_->fused());
    if (error_state_ == nullptr) return;
    metrics["gnss_re_entries"] = static_cast<std::int64_t>(error_state_->re_entries());
    metrics["gnss_mean_square"] = error_state_->mean_square();
    if (settings_.sigma_antenna_m > 0) {
        metrics["antenna_forward_off_m"] = error_state_->antenna_off_m().x();
        metrics["antenna_left_off_m"] = error_state_->antenna_off_m().y();
    }
}

void FusionModule::report_wheels(Results& results) const {
    if (told_wheels_label_.empty() || error_state_ == nullptr) return;
    auto& metrics = results.metrics;
    if (!motion_label_.empty()) {
        metrics["wheels_used"] = static_cast<std::int64_t>(path_->wheel_use().used);
        metrics["wheels_mean_square"] = path_->wheel_use().mean_square();
        metrics["wheels_refused_slipped"] = static_cast<std::int64_t>(path_->wheel_use().slipped);
    }
    const auto& errors = error_state_->wheel_errors();
    const auto sigmas = error_state_->wheel_error_sigmas();
    metrics["wheel_scale"] = 1 + errors[way_scale];
    metrics["wheel_scale_sigma"] = sigmas[way_scale];
    metrics["wheel_turn_scale"] = 1 + errors[turn_scale];
    metrics["wheel_turn_scale_sigma"] = sigmas[turn_scale];
    metrics["wheel_bend_deg"] = errors[bend] * 180 / M_PI;
    metrics["wheel_bend_sigma_deg"] = sigmas[bend] * 180 / M_PI;
    metrics["wheel_one_sided"] = errors[one_sided];
    metrics["wheel_curve_m2"] = errors[curve];
}

/// How far the path was from the last fix of each gap, on the plan, and its motion alone from where that
/// began.
void FusionModule::report_gaps(Results& results) const {
    if (withhold_s_ == 0 || error_state_ == nullptr) return;
    const auto& gaps = error_state_->gaps();
    results.metrics["gaps"] = static_cast<std::int64_t>(gaps.size());
    const auto sum_up = [&](const std::string& of, Eigen::Vector3d Gap::*off) {
        double squares = 0, worst_m = 0, parts = 0, worst_part = 0;
        std::size_t moving = 0;
        for (const Gap& gap : gaps) {
            const double off_m = (gap.*off).head<2>().norm();
            squares += off_m * off_m;
            worst_m = std::max(worst_m, off_m);
            if (gap.way_m < least_gap_way_m) continue;
            ++moving;
            parts += off_m / gap.way_m;
            worst_part = std::max(worst_part, off_m / gap.way_m);
        }
        if (gaps.empty()) return;
        results.metrics["gap_end_" + of + "rmse_m"] = std::sqrt(squares / static_cast<double>(gaps.size()));
        results.metrics["gap_end_" + of + "worst_m"] = worst_m;
        if (moving == 0) return;
        results.metrics["gap_end_" + of + "mean_percent"] = 100 * parts / static_cast<double>(moving);
        results.metrics["gap_end_" + of + "worst_percent"] = 100 * worst_part;
    };
    for (std::size_t i = 0; i < gaps.size() && i < most_told_gaps; ++i) {
        const Gap& gap = gaps[i];
        const std::string key = "gap_" + std::string(i < 9 ? "0" : "") + std::to_string(i + 1) + "_";
        results.metrics[key + "from_s"] = seconds_between(first_ns_, gap.from_ns);
        results.metrics[key + "to_s"] = seconds_between(first_ns_, gap.to_ns);
        results.metrics[key + "way_m"] = gap.way_m;
        results.metrics[key + "error_m"] = gap.off_m.head<2>().norm();
        results.metrics[key + "sigma_m"] = gap.sigma_m.head<2>().norm();
        results.metrics[key + "dead_reckoning_m"] = gap.dead_reckoning_off_m.head<2>().norm();
    }
    sum_up("error_", &Gap::off_m);
    sum_up("dead_reckoning_", &Gap::dead_reckoning_off_m);
}

}  // namespace loopline
