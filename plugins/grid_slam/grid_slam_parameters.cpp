/// The .ini section of module "grid_slam".
#include "grid_slam/grid_slam_module.h"

namespace loopline {

using namespace grid_slam;

ParameterTable GridSlamModule::parameters() {
    auto& s = settings_;
    ParameterTable table("grid_slam", info().sentence);
    scans_.declare(table);
    table.real("cell_m", s.cell_m, {0.01, 1}, "Edge of a cell of the map that scans are matched with.");
    declare_matching(table, s.frame, s.forward);
    table
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
    scans_.declare_imu(table);
    return table;
}

}  // namespace loopline
