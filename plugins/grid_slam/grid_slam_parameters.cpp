/// The .ini section of module "grid_slam".
#include "grid_slam/grid_slam_module.h"

namespace loopline {

using namespace grid_slam;

ParameterTable GridSlamModule::parameters() {
    auto& s = settings_;
    auto& refinement = s.forward.refinement;
    auto& gyro = inertial_.noise.gyro;
    auto& accelerometer = inertial_.noise.accelerometer;
    ParameterTable table("grid_slam", info().sentence);
    table.list("sensors", sensors_, "Labels of the lasers whose scans are used; empty for all.")
        .choice("navigation", source_,
                {{"wheel", Source::wheel}, {"imu", Source::imu}, {"imu+wheel", Source::imu_wheel}},
                "What tells where the vehicle goes between two scans.")
        .real("cell_m", s.cell_m, {0.01, 1}, "Edge of a cell of the map that scans are matched with.")
        .real("min_range_m", s.frame.min_range_m, {0, 100}, "Nearer returns are of the vehicle itself.")
        .real("max_range_m", s.frame.max_range_m, {0.1, 1000}, "Farther returns are left out.")
        .real("sigma_rest_m", wheels_.sigma_rest_m, {1e-4, 10},
              "Standard deviation of the wheels' way from scan to scan, without any motion.")
        .real("sigma_way_m", wheels_.sigma_way_m, {0, 10},
              "What is added to it for each metre between two scans.")
        .angle("sigma_rest_deg", wheels_.sigma_rest_rad, {1e-3, 90},
               "Standard deviation of the wheels' turn from scan to scan, without any motion.")
        .real("sigma_turn", wheels_.sigma_turn, {0, 10},
              "What is added to it, as a part of the turn between two scans.")
        .angle("sigma_way_deg", wheels_.sigma_way_rad, {0, 90},
               "What is added to it for each metre between two scans.")
        .real("scan_duration_s", scan_duration_s_, {-10, 10},
              "Time from a scan's first beam, the rightmost, to its last; negative if the laser turns "
              "clockwise. What the vehicle moves meanwhile is taken out; 0 takes a scan as one instant.")
        .real("sigma_return_m", refinement.sigma_m, {1e-3, 1},
              "Standard deviation of a return about the surface that it is of.")
        .angle("sigma_beam_deg", refinement.sigma_angle_rad, {0, 10},
               "Standard deviation of a beam's direction, its width included.")
        .real("spacing_m", s.frame.spacing_m, {0, 1},
              "Returns of one scan closer together along a surface are one.")
        .real("correlation_m", refinement.correlation_m, {0, 10},
              "Returns so close together along a wall err together: they count as one.")
        .real("reach_m", refinement.reach_m, {0.01, 5},
              "A return and a surface of the map farther apart have nothing to do with one another.")
        .real("window_sigmas", s.forward.window_sigmas, {0.5, 10},
              "Half of the window that a scan is searched for in, in standard deviations of the motion.")
        .real("max_window_m", s.forward.max_window_m, {0.05, 20}, "But half of it is no more than this.")
        .angle("heading_step_deg", s.forward.heading_step_rad, {0.05, 10},
               "Step of the headings that are tried.")
        .integer("search_points", s.forward.search_points, {10, 2000},
                 "Returns of a scan that are searched with.")
        .real("frame_way_m", s.frame_way_m, {0.01, 10},
              "A scan becomes part of the map if it is so far from all that are.")
        .angle("frame_turn_deg", s.frame_turn_rad, {0.1, 90}, "Or so turned.")
        .real("new_fit", s.new_fit, {0, 1}, "Or if less than this part of its returns fits the map.")
        .real("active_sigma_m", s.active.sigma_m, {0.01, 10},
              "Scans are matched with what is known to this standard deviation from where the vehicle is; "
              "what is older takes a loop.")
        .integer("link_visits", s.links.visits, {0, 20},
                 "Earlier visits of a place that a scan of the map is tied to.")
        .choice("weights", s.weights,
                {{"linear", Weights::linear}, {"covariance", Weights::covariance}, {"joint", Weights::joint}},
                "How a loop is corrected: by going back through it, both ways weighted by the way (the "
                "patent) or by what they are worth; or all loops at once.")
        .boolean("loops", loops_, "Look for loops of the path.")
        .text("loops_off", without_search_,
              "But not in these parts of the log: \"from .. to, from .. to\", UTC seconds as in "
              "trajectory.tum; loops that are named are tried all the same.")
        .text("named_loops", named_loops_,
              "Loops to try in any case: \"later - earlier, ...\", UTC seconds, the scan at the later time "
              "being "
              "where that at the earlier was; as `loop` of an entry of metrics.json.")
        .real("named_window_m", s.loops.named_window_m, {0.1, 100}, "They are searched for so far around.")
        .angle("named_window_deg", s.loops.named_window_rad, {1, 180}, "And so much turned.")
        .text(
            "refuse_loops", refused_loops_,
            "Loops that are none: \"later - earlier\", \"later\" alone (whatever place it was taken for) or "
            "\"from .. to\" (all whose later scan is in there), separated by commas.")
        .real("refuse_way_m", s.decisions.refuse_way_m, {0, 1000},
              "One that is refused stays so for this way of the vehicle from its later scan on, and about as "
              "far around its earlier one.")
        .real("loop_every_m", s.loops.every_m, {0.05, 100}, "Way between two looks.")
        .real("loop_reach_m", s.loops.reach_m, {0.1, 100},
              "Distance of an old scan that the vehicle may see the same from.")
        .real("loop_max_window_m", s.loops.max_window_m, {0.1, 100},
              "A loop is searched for as far as is uncertain, but no farther than this.")
        .angle("loop_max_window_deg", s.loops.max_window_rad, {1, 180}, "And no more turned than this.")
        .real("loop_min_likelihood", s.loops.min_likelihood, {0, 1},
              "How well the latest scans must fit the old map on its cells.")
        .real("loop_min_fit", s.loops.min_fit, {0, 1},
              "Part of the latest returns that must lie on surfaces of the old map.")
        .real("loop_rival", s.loops.rival, {0, 1},
              "A second place as likely as this part of the best one makes a loop ambiguous.")
        .real("loop_max_sigma_m", s.loops.max_sigma_m, {1e-3, 10},
              "How well the scans must hold the pose in each direction.");
    table.text("imu", imu_label_, "Label of the IMU; empty: of any.")
        .angle("gyro_noise_deg", gyro.density_radps_sqrt_hz, {1e-6, 10},
               "Angular random walk: standard deviation of a turn after 1 s.")
        .angle("gyro_bias_walk_dps", gyro.bias_walk_radps_sqrt_s, {0, 1},
               "What the gyro's bias walks in 1 s.")
        .real("accelerometer_noise_mps", accelerometer.density_mps2_sqrt_hz, {1e-6, 10},
              "Velocity random walk: standard deviation of the speed after 1 s.")
        .real("accelerometer_bias_walk_mps2", accelerometer.bias_walk_mps2_sqrt_s, {0, 1},
              "What the accelerometer's bias walks in 1 s.")
        .real("standstill_s", inertial_.alignment.duration_s, {0.1, 60},
              "Standstill that the IMU is aligned by.")
        .real("gravity_mps2", inertial_.gravity_mps2, {9.7, 9.9}, "At the place of the survey.")
        .real("sigma_map_m", inertial_.map.sigma_m, {0, 1},
              "What scans say about the place errs by so much together with the map.")
        .angle("sigma_map_deg", inertial_.map.sigma_rad, {0, 10}, "And about the heading.")
        .real("sigma_speed_mps", inertial_.sigma_speed_mps, {0, 10},
              "Of inertial navigation's speed from scan to scan, beside what its filter states.")
        .real("sigma_gyro_scale", inertial_.sigma_turn, {0, 1}, "Of the gyro's scale.")
        .real("sigma_wheel_mps", inertial_.sigma_wheel_mps, {1e-3, 10},
              "Of the wheels' speed, for imu+wheel.")
        .real("sigma_side_mps", inertial_.sigma_side_mps, {1e-3, 10},
              "Of the speed sideways, which wheels don't have.");
    return table;
}

}  // namespace loopline
