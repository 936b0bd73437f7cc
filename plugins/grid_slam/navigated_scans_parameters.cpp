/// The rows that the sections of the modules on grids have in common.
#include "grid_slam/navigated_scans.h"

namespace loopline::grid_slam {

void NavigatedScans::declare(ParameterTable& table) {
    table.list("sensors", sensors_, "Labels of the lasers whose scans are used; empty for all.")
        .choice("navigation", source_,
                {{"wheel", Source::wheel}, {"imu", Source::imu}, {"imu+wheel", Source::imu_wheel}},
                "What tells where the vehicle goes between two scans.")
        .real("sigma_rest_m", wheels_.sigma_rest_m, {1e-4, 10},
              "Standard deviation of the wheels' way after 1 s, without any motion.")
        .real("sigma_way_m", wheels_.sigma_way_m, {0, 10},
              "What is added to it for each metre between two scans.")
        .angle("sigma_rest_deg", wheels_.sigma_rest_rad, {1e-3, 90},
               "Standard deviation of the wheels' turn after 1 s, without any motion.")
        .real("sigma_turn", wheels_.sigma_turn, {0, 10},
              "What is added to it, as a part of the turn between two scans.")
        .angle("sigma_way_deg", wheels_.sigma_way_rad, {0, 90},
               "What is added to it for each metre between two scans.")
        .real("scan_duration_s", scan_duration_s_, {-10, 10},
              "Time from a scan's first beam, the rightmost, to its last; negative if the laser turns "
              "clockwise. What the vehicle moves meanwhile is taken out; 0 takes a scan as one instant.");
}

void declare_matching(ParameterTable& table, grid_map::FrameSettings& frame, ForwardSettings& forward) {
    auto& refinement = forward.refinement;
    table.real("min_range_m", frame.min_range_m, {0, 100}, "Nearer returns are of the vehicle itself.")
        .real("max_range_m", frame.max_range_m, {0.1, 1000}, "Farther returns are left out.")
        .real("sigma_return_m", refinement.sigma_m, {1e-3, 1},
              "Standard deviation of a return about the surface that it is of; surfaces are fitted to a way "
              "of ten times as much.")
        .angle("sigma_beam_deg", refinement.sigma_angle_rad, {0, 10},
               "Standard deviation of a beam's direction, its width included.")
        .real("spacing_m", frame.spacing_m, {0, 1},
              "Returns of one scan closer together along a surface are one.")
        .real("correlation_m", refinement.correlation_m, {0, 10},
              "Returns so close together along a wall err together: they count as one.")
        .real("reach_m", refinement.reach_m, {0.01, 5},
              "A return and a surface of the map farther apart have nothing to do with one another.")
        .real("window_sigmas", forward.window_sigmas, {0.5, 10},
              "Half of the window that a scan is searched for in, in standard deviations of the motion.")
        .real("max_window_m", forward.max_window_m, {0.05, 20}, "But half of it is no more than this.")
        .angle("heading_step_deg", forward.heading_step_rad, {0.05, 10},
               "Step of the headings that are tried.")
        .integer("search_points", forward.search_points, {10, 2000},
                 "Returns of a scan that are searched with.");
}

void NavigatedScans::declare_imu(ParameterTable& table) {
    auto& gyro = settings_.noise.gyro;
    auto& accelerometer = settings_.noise.accelerometer;
    table.text("imu", imu_label_, "Label of the IMU; empty: of any.")
        .angle("gyro_noise_deg", gyro.density_radps_sqrt_hz, {1e-6, 10},
               "Angular random walk: standard deviation of a turn after 1 s.")
        .angle("gyro_bias_walk_dps", gyro.bias_walk_radps_sqrt_s, {0, 1},
               "What the gyro's bias walks in 1 s.")
        .real("accelerometer_noise_mps", accelerometer.density_mps2_sqrt_hz, {1e-6, 10},
              "Velocity random walk: standard deviation of the speed after 1 s.")
        .real("accelerometer_bias_walk_mps2", accelerometer.bias_walk_mps2_sqrt_s, {0, 1},
              "What the accelerometer's bias walks in 1 s.")
        .real("standstill_s", settings_.alignment.duration_s, {0.1, 60},
              "Standstill that the IMU is aligned by.")
        .real("gravity_mps2", settings_.gravity_mps2, {9.7, 9.9}, "At the place of the survey.")
        .real("sigma_map_m", settings_.map.sigma_m, {0, 1},
              "What scans say about the place errs by so much together with the map.")
        .angle("sigma_map_deg", settings_.map.sigma_rad, {0, 10}, "And about the heading.")
        .real("sigma_speed_mps", settings_.sigma_speed_mps, {0, 10},
              "Of inertial navigation's speed from scan to scan, beside what its filter states.")
        .real("sigma_gyro_scale", settings_.sigma_turn, {0, 1}, "Of the gyro's scale.")
        .real("sigma_wheel_mps", settings_.sigma_wheel_mps, {1e-3, 10},
              "Of the wheels' speed, for imu+wheel.")
        .real("sigma_side_mps", settings_.sigma_side_mps, {1e-3, 10},
              "Of the speed sideways, which wheels don't have.");
}

}  // namespace loopline::grid_slam
