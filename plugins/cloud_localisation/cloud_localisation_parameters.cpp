/// The .ini section of module "cloud_localisation".
#include "cloud_localisation/cloud_localisation_module.h"
#include "lidar_mapping/matching_parameters.h"

namespace loopline {

using namespace cloud_localisation;
using namespace lidar_mapping;

ParameterTable CloudLocalisationModule::parameters() {
    auto& s = settings_;
    auto& m = s.sweeps;
    ParameterTable table("cloud_localisation", info().sentence);
    table
        .path("map", map_path_,
              "The finished cloud: a run directory, or a PLY, PCD or LAS file; georeference.txt beside it "
              "places it on the Earth.",
              FileNeed::must_exist)
        .choice("start", start_, {{"gnss", Start::gnss}, {"given", Start::given}},
                "Whether a receiver's fix tells where to look for the place at first, with any heading, or "
                "the pose "
                "at the first sweep is given.")
        .real("start_x_m", start_x_m_, {-1e6, 1e6}, "Given pose at the first sweep, in the frame of the map.")
        .real("start_y_m", start_y_m_, {-1e6, 1e6}, "As above.")
        .real("start_z_m", start_z_m_, {-1e5, 1e5}, "As above.")
        .angle("start_yaw_deg", start_yaw_rad_, {-360, 360}, "As above, counter-clockwise.")
        .real("sigma_start_m", s.sigma_start_m, {1e-3, 100},
              "Standard deviation of the given place, along each axis.")
        .angle("sigma_start_deg", s.sigma_start_rad, {0.01, 180}, "Standard deviation of the given heading.");
    led_settings_.declare_sensors(table);
    table.text("receiver", receiver_, "Label of the GNSS receiver; empty: any.")
        .real("latency_s", latency_s_, {-10, 10}, "The log stamps fixes so much later than they are of.")
        .real(
            "sigma_map_m", s.sigma_map_m, {0, 10},
            "Standard deviation of where the map's surfaces are, along each axis, which sweeps at one place "
            "share, beside what covariance.csv of the run that placed the map on the Earth says.")
        .angle("sigma_map_deg", s.sigma_map_rad, {0, 10}, "The same of how they are turned.");
    declare_range(table, m.sampling);
    table.real("match_voxel_m", m.match_voxel_m, {0.01, 10},
               "One return of a sweep from each cube of this edge is matched with the map.");
    declare_surfaces(table, m.map);
    declare_registration(table, m);
    led_settings_.declare_odometry(table);
    table
        .real("good_fit", s.good_fit, {0, 1},
              "Part of a sweep's returns from above the ground that are where the map has some, from which "
              "on it "
              "counts as fitting.")
        .real("lost_after_s", s.lost_after_s, {0.1, 1000},
              "After so long without a sweep that fits, the place is searched for anew.")
        .real("max_sigma_m", s.max_sigma_m, {0.01, 100}, "And if it is so uncertain in any direction.")
        .real("min_matched", min_matched_, {0, 1},
              "A log of which less than this part of the sweeps fits the map is refused in the end.");
    table.real("search_every_s", s.search_every_s, {0, 100}, "Time between two searches.")
        .real("search_range_m", s.start.range_m, {5, 200},
              "They look at what stands upright within this range.")
        .real("search_max_window_m", s.start.max_window_m, {1, 100},
              "They look no farther around than this; where less is known of the place, none is tried.")
        .real("search_min_fit", s.start.min_fit, {0, 1},
              "Part of the returns from upright things that must be where the map has some.")
        .real("search_rival", s.start.rival, {0, 1},
              "Another place that fits so well, as a part of the best one, makes it ambiguous: the search "
              "waits.");
    led_settings_.declare_cloud_sweep(table);
    return table;
}

}  // namespace loopline
