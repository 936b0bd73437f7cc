/// The .ini section of module "fusion".
#include "fusion/fusion_module.h"

namespace loopline {

using namespace fusion;

ParameterTable FusionModule::parameters() {
    auto& s = settings_;
    ParameterTable table("fusion", info().sentence);
    const auto noise = [&table](const std::string& kind, gnss::FixNoise& n, const std::string& which) {
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
        .angle(
            "sigma_upright_deg", s.sigma_upright_rad, {0, 90},
            "Standard deviation of what the walls of a place lean together, by which the module that tells "
            "the motion finds the upright; 0: not used.")
        .real("sigma_antenna_m", s.sigma_antenna_m, {0, 10},
              "Standard deviation of the antenna's place on the vehicle, forward and to the left each, about "
              "what the log says; it is found where the vehicle turns.")
        .angle("heading_sigma_deg", s.heading_sigma_rad, {0.01, 20},
               "The heading is taken to be known with this standard deviation.")
        .real("gate", s.gate, {0.5, 0.999999},
              "Part of good fixes that are to pass: what is farther off than they are is refused.")
        .real("re_entry_s", s.re_entry_s, {1, 3600},
              "If no fix was used for so long, those that agree with one another for some seconds are right, "
              "whatever the path so far says; earlier if the path rests on few fixes.")
        .real("late_s", s.late_s, {0, 60}, "A fix that comes later than this is of no use.")
        .real("latency_s", latency_s_, {-10, 10},
              "The log stamps fixes so much later than they are of, as when they are stamped on reception.")
        .real("sigma_latency_s", s.sigma_latency_s, {0, 10},
              "Standard deviation of that from fix to fix: they count less along the way.")
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
    for (const auto& [key, label] :
         {std::pair("motion", motion_label_), std::pair("wheels", told_wheels_label_)})
        if (label == published_label || label == odometry_label || label == wheels_label)
            return std::string(key) + " = " + label +
                   " is what this module publishes itself; name what it is to be made of";
    if (sync_ == Sync::threshold && filter_ != Filter::paper)
        return "sync = threshold is for filter = paper; the other filter takes each fix at its own time";
    if (filter_ == Filter::paper && motion_label_.empty())
        return "filter = paper works on the clock of an odometry in space; name its label in motion, or take "
               "filter = error_state for wheels alone";
    if (withhold_s_ > 0 && withhold_s_ >= withhold_every_s_)
        return "withhold_s leaves no fixes at all; make it shorter than withhold_every_s";
    if (withhold_s_ > 0 && filter_ == Filter::paper)
        return "withhold_s is for filter = error_state, which tells how far its path was at the end of each "
               "gap";
    return {};
}

}  // namespace loopline
