/// The .ini section of module "grid_localisation".
#include "grid_slam/grid_localisation_module.h"

namespace loopline {

using namespace grid_slam;

ParameterTable GridLocalisationModule::parameters() {
    auto& s = settings_;
    ParameterTable table("grid_localisation", info().sentence);
    table
        .path("map", map_path_,
              "The finished map: a run directory, or a YAML file or its picture as map_server has them.",
              FileNeed::must_exist)
        .choice("start", start_, {{"given", Start::given}, {"global", Start::global}},
                "Whether the pose at the first scan is given, or is searched for in all of the map.")
        .real("start_x_m", s.T_map_start.x_m, {-1e6, 1e6},
              "Given pose at the first scan, in the frame of the map.")
        .real("start_y_m", s.T_map_start.y_m, {-1e6, 1e6}, "As above.")
        .angle("start_yaw_deg", s.T_map_start.phi_rad, {-360, 360}, "As above, counter-clockwise.")
        .real("sigma_start_m", s.sigma_start_m, {1e-3, 100},
              "Standard deviation of the given place, along each axis.")
        .angle("sigma_start_deg", s.sigma_start_rad, {0.01, 180}, "Standard deviation of the given heading.");
    scans_.declare(table);
    table.real(
        "cell_m", cell_m_, {0.01, 0.5},
        "Cells of a finer map are taken together up to this edge; those of a coarser one stay as they are.");
    declare_matching(table, s.frame, s.forward);
    table
        .real("good_fit", s.good_fit, {0, 1},
              "Part of a scan's returns on surfaces of the map from which on it counts as fitting.")
        .real("lost_after_m", s.lost_after_m, {0.1, 1000},
              "After so long a way without a scan that fits, the place is searched for, as far as it is "
              "uncertain.")
        .real("min_matched", min_matched_, {0, 1},
              "A log of which less than this part of the scans fits the map is refused in the end.")
        .real("search_latest_m", s.start.latest_m, {0, 100},
              "Way of the vehicle up to now, whose scans are searched for together.")
        .real("search_long_m", s.start.long_m, {0, 1000},
              "The same where several places fit these, if so much was driven.")
        .real("search_every_m", s.start.every_m, {0.05, 100}, "Way between two searches.")
        .real("search_min_likelihood", s.start.min_likelihood, {0, 1},
              "How well these scans must fit the map on its cells.")
        .real("search_min_fit", s.start.min_fit, {0, 1},
              "Part of their returns that must lie on surfaces of the map.")
        .real("search_rival", s.start.rival, {0, 1},
              "Another place as likely as this part of the best one makes it ambiguous: the search waits.")
        .real("search_rival_m", s.start.rival_m, {0.1, 100}, "Another place: farther away than this.")
        .real("search_max_sigma_m", s.start.max_sigma_m, {1e-3, 10},
              "How well the scans must hold the pose in each direction.")
        .real("search_agree_after_m", s.start.agree_after_m, {0, 100},
              "A place counts when a second search, so long a way later at least, agrees.");
    scans_.declare_imu(table);
    return table;
}

}  // namespace loopline
