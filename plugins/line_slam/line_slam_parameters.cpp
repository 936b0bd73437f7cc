/// What can be set of the module, section [line_slam].
#include "line_slam/line_slam_module.h"

namespace loopline {
namespace {

using namespace line_slam;

constexpr const char* regime_words[regime_count] = {"driving straight", "turning left", "turning right"};

}  // namespace

ParameterTable LineSlam::parameters() {
    using Kind = IntervalParameters::Kind;
    using Control = IntervalParameters::Control;
    auto& drive = slam_parameters_.drive;
    auto& interval = interval_parameters_;
    ParameterTable table("line_slam", info().sentence);
    table
        .integer(
            "interval_scans", interval.scans, {1, 1000},
            "Scans from one step of the filter to the next, N of Hu 2012; with interval = adaptive: at most.")
        .choice("interval", interval.kind, {{"fixed", Kind::fixed}, {"adaptive", Kind::adaptive}},
                "Every N-th scan, or as soon as the way, the turn or the uncertainty since the last step "
                "asks for it.")
        .real("adaptive_way_m", interval.max_way_m, {0, 100},
              "Way since the last step that asks for the next.")
        .angle("adaptive_turn_deg", interval.max_turn_rad, {0, 180},
               "Turn since the last step that asks for the next.")
        .real("adaptive_sigma_m", interval.max_sigma_m, {0, 100},
              "Standard deviation of the difference of both wheels' travel that asks for the next step.")
        .choice("control", interval.control,
                {{"measured", Control::measured}, {"commanded", Control::commanded}},
                "What the motion is predicted from: the odometry, or the speeds that belong to each regime.")
        .boolean("re_prediction", interval.re_prediction,
                 "Predict in pieces where the wheel speeds change within an interval; without it, the speeds "
                 "at its "
                 "beginning hold for all of it.")
        .choice("feature", slam_parameters_.feature,
                {{"line", Feature::line}, {"foot_point", Feature::foot_point}},
                "How a wall is measured: distance and direction of the line, or the paper's foot point seen "
                "from the "
                "map's origin.")
        .choice("update", slam_parameters_.update,
                {{"joint", Update::joint}, {"paper_sum", Update::paper_sum}},
                "All lines of a scan at once, or the paper's sum of gains that do not know of one another.")
        .choice("association", slam_parameters_.association.method,
                {{"sequential", AssociationMethod::sequential},
                 {"nearest", AssociationMethod::nearest},
                 {"jcbb", AssociationMethod::jcbb}},
                "Lines of a scan are paired with the map each given the longer ones, each by itself (the "
                "paper), or "
                "by joint compatibility branch and bound.")
        .real("track_width_m", drive.track_width_m, Range::positive(), "Distance of the driven wheels.")
        .real(
            "odometry_track_width_m", drive.odometry_track_width_m, {0, 100},
            "Distance of the wheels that the log's odometry was reckoned with, which tells their travel from "
            "its poses; 0: track_width_m.")
        .real("sigma_wheel_m", drive.sigma_wheel_m, {0, 10},
              "Standard deviation of one wheel's travel after 1 m; variances grow in proportion to the way.")
        .real("sigma_side_m", drive.sigma_side_m, {0, 10},
              "Standard deviation of sideways motion after 1 m of travel.")
        .real("sigma_rest_m", drive.sigma_rest_m, {1e-6, 1},
              "Standard deviation of each of these between two steps without any motion.")
        .real(
            "sigma_scale", drive.sigma_scale, {1e-6, 1},
            "How well wheel diameters and track width are known, as a fraction; their errors are estimated.")
        .real("sigma_wall_m", slam_parameters_.sigma_wall_m, {0, 1},
              "How far the ends of a wall lie off a straight line.")
        .real("gate_probability", gate_probability_, {0.5, 0.999999},
              "Share of true pairings that the association gate lets pass.")
        .real("scan_duration_s", scan_duration_s_, {-10, 10},
              "Time from a scan's first beam to its last, the first being the rightmost; negative if the "
              "laser turns "
              "clockwise. What the vehicle moves meanwhile is taken out of the lines; 0 takes a scan as one "
              "instant.")
        .real("max_gap_m", slam_parameters_.association.max_gap_m, {0, 100},
              "Gap between the seen part of a map line and an observation, up to which it can be the same "
              "wall.")
        .integer("support_scans", slam_parameters_.tentative.scans, {1, 1000},
                 "Steps that must have seen a line before it enters the state.")
        .boolean("smoothing", smoothing_, "Smooth the whole path at the end of the log.");
    for (const Regime regime : all_regimes) {
        RegimeParameters& p = interval.regimes[static_cast<std::size_t>(regime)];
        const std::string name = regime_key(regime), way = regime_words[static_cast<int>(regime)];
        table
            .real(name + "_left_mps", p.commanded.left_mps, {-100, 100},
                  "Left wheel's speed " + way + ", for control = commanded.")
            .real(name + "_right_mps", p.commanded.right_mps, {-100, 100},
                  "Right wheel's speed " + way + ", for control = commanded.")
            .real(name + "_slip_left", p.slip_left, {-1, 1},
                  "Part of the left wheel's travel that is lost " + way + ".")
            .real(name + "_slip_right", p.slip_right, {-1, 1},
                  "Part of the right wheel's travel that is lost " + way + ".")
            .real(
                name + "_sigma_left_m", p.sigma_left_m, {0, 10},
                "Standard deviation of the left wheel's travel after 1 m " + way + "; 0 takes sigma_wheel_m.")
            .real(name + "_sigma_right_m", p.sigma_right_m, {0, 10},
                  "Standard deviation of the right wheel's travel after 1 m " + way +
                      "; 0 takes sigma_wheel_m.");
    }
    return table;
}

std::string LineSlam::check() const {
    if (interval_parameters_.control != IntervalParameters::Control::commanded) return {};
    for (const RegimeParameters& r : interval_parameters_.regimes)
        if (r.commanded.left_mps == 0 && r.commanded.right_mps == 0)
            return "control = commanded needs the wheel speeds of all three regimes (straight_left_mps, "
                   "straight_right_mps, turn_left_left_mps, ...)";
    return {};
}

}  // namespace loopline
