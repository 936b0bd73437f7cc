#include "config/host_sections.h"

namespace loopline {

ParameterTable run_table(RunSettings& settings) {
    ParameterTable table("run", "What to run, and on which log.");
    table
        .paths("rawlog", settings.rawlogs,
               "Rawlog files, separated by \";\"; several are merged by stamp. --rawlog replaces them.")
        .list("modules", settings.modules, "The chain of modules, in order; see `loopline describe`.")
        .list("maps", settings.maps, "Map builders, drawn from the final trajectory; empty: none.")
        .text("trajectory", settings.trajectory,
              "The module whose path is the result; empty: the last of the chain that estimates one.")
        .seed("seed", settings.seed, "For whatever draws random numbers: the same seed gives the same bytes.")
        .real("checkpoint_s", settings.checkpoint_s, {0, 1e6},
              "Seconds of CPU time from one checkpoint to the next, more if writing them took over a "
              "hundredth of "
              "it; 0: only when the run is interrupted.")
        .integer("checkpoint_items", settings.checkpoint_items, Range::at_least(0),
                 "A checkpoint after every so many observations of the log, whatever it takes; 0: as "
                 "checkpoint_s says.");
    return table;
}

ParameterTable mount_table(MountSettings& settings) {
    ParameterTable table(
        "mount",
        "Where sensors sit on the vehicle and what their scans lack, in place of what the log says.");
    table.list("sensors", settings.sensors, "Labels of the sensors that this is about; empty: none.")
        .real("x_m", settings.x_m, Range::any(), "Forward of the vehicle's origin.")
        .real("y_m", settings.y_m, Range::any(), "To the left of it.")
        .real("z_m", settings.z_m, Range::any(), "Above it.")
        .angle("yaw_deg", settings.yaw_rad, {-180, 180}, "Turned to the left.")
        .angle("pitch_deg", settings.pitch_rad, {-180, 180}, "Turned nose down, after yaw.")
        .angle("roll_deg", settings.roll_rad, {-180, 180}, "Turned right side down, after yaw and pitch.")
        .real("range_scale", settings.range_scale, {0.1, 10},
              "Of a laser: true range = range_scale x range + range_offset_m.")
        .real("range_offset_m", settings.range_offset_m, {-10, 10},
              "What its ranges are short of, beside their scale.")
        .angle("aperture_deg", settings.aperture_rad, {0, 360},
               "Angle from its first beam to its last; 0: as the log says. 180 beams at 1 degree cover 179.");
    return table;
}

ParameterTable outputs_table(OutputSettings& settings) {
    ParameterTable table(
        "outputs", "What a run leaves in its directory beside metrics.json, config.ini and manifest.json.");
    table
        .boolean("trajectory", settings.trajectory,
                 "Trajectories and covariances: trajectory.tum and its companions.")
        .boolean("maps", settings.maps, "Map files, one set for each kind of map.")
        .boolean("snapshots", settings.snapshots, "Pictures of trajectory and map.")
        .boolean("report", settings.report, "report.html, one page to look at.")
        .real(
            "states_mb", settings.states_mb, {0, 1e6},
            "States before each loop is closed, for --reject-loop, take no more than this; 0: none is kept.")
        .list("record", settings.record,
              "Classes or sensor labels of published observations to keep in recorded.rawlog; empty: none.");
    return table;
}

ParameterTable evaluation_table(EvaluationSettings& settings) {
    ParameterTable table("evaluation", "What to compare the result with.");
    table
        .path("truth", settings.truth, "True trajectory: a TUM file, or lines of \"t x y phi\" or \"t x y\"; empty: none.",
              FileNeed::must_exist)
        .real("truth_point_x_m", settings.truth_point_x_m, {-100, 100},
              "The point of the vehicle whose way the truth is, such as a tracked mark or an antenna: ahead of base.")
        .real("truth_point_y_m", settings.truth_point_y_m, {-100, 100}, "The same, left of base.")
        .boolean("truth_beside_log", settings.truth_beside_log,
                 "If truth is empty: FILE.truth.tum beside the first rawlog FILE.rawlog, where it is there.")
        .path("surveyed", settings.surveyed,
              "True feature points and walls, as `loopline simulate` writes them; empty: FILE.truth.csv "
              "beside a "
              "truth FILE.truth.tum, where it is there.",
              FileNeed::must_exist)
        .path("published_points", settings.published_points,
              "Figures of another work for the same points, shown beside: rows of number, odometry x y, "
              "estimate x "
              "y in m; empty: none.",
              FileNeed::must_exist)
        .real("scan_duration_s", settings.scan_duration_s, {0, 10},
              "From the first beam of a scan that sees a feature point, which has its stamp, to its last; 0: "
              "all "
              "at once.")
        .path("relations", settings.relations, "Relations file of the Kuemmerle metric; empty: none.",
              FileNeed::must_exist);
    return table;
}

const std::vector<std::string>& host_section_names() {
    static const std::vector<std::string> names{"run", "mount", "outputs", "evaluation"};
    return names;
}

}  // namespace loopline
