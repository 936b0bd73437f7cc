#include "cloud_map/cloud_map_options.h"

#include <algorithm>
#include <cmath>

namespace loopline::cloud_map {

void CloudMapOptions::declare(ParameterTable& table) {
    auto& s = settings;
    auto& r = settings.removal;
    table.list("sensors", sensors, "Labels of the lidars whose sweeps are used; empty for all.")
        .real("voxel_m", s.voxel_m, {0.03, 10},
              "No two points are nearer to each other than this, nor in the same cube with this edge; the "
              "first is kept.")
        .real("min_range_m", s.min_range_m, {0, 100}, "Nearer returns are of the vehicle itself.")
        .real("max_range_m", s.max_range_m, {1, 1000}, "Farther returns are left out.")
        .real("max_gap_s", max_gap_s, {0.001, 3600},
              "Between poses farther apart than this no sweep is mapped.")
        .boolean("remove_moving", r.remove_moving,
                 "Leaves out what other sweeps, before or after, looked through: what moves leaves no trail.")
        .real("view_spacing_m", r.view_spacing_m, {0.1, 1000},
              "After so much way a sweep is asked which places it looked through,")
        .real("view_spacing_s", r.view_spacing_s, {0.01, 1000}, "or after so much time.")
        .integer("views", r.views, {1, 1000},
                 "Sweeps that are asked about each place from before it was first seen, and from after.")
        .real("view_reach_m", r.view.reach_m, {1, 1000}, "They know nothing of what is farther away.")
        .real("view_margin_m", r.view.margin_m, {0.01, 10},
              "All beams about a place must have gone on beyond it by this much, and 1 % of the range, to "
              "have looked through it.")
        .integer("least_through", r.least_through, {1, 255},
                 "So many of them must have looked through a place for its point to be left out,")
        .real("through_per_seen", r.through_per_seen, {0, 255},
              "and more than so many for each that saw something there.")
        .integer("surely_there", r.surely_there, {1, 255},
                 "A place at which so many saw something, and through which none looked, is kept, until so "
                 "many more "
                 "look through than still see it.")
        .real("cloud_sweep_s", cloud_sweep.sweep_s, {0, 10},
              "Duration of a sweep whose points come without times.");
}

std::string CloudMapOptions::check() const {
    if (settings.min_range_m >= settings.max_range_m) return "min_range_m is not below max_range_m";
    return {};
}

bool CloudMapOptions::wants(const mrpt::obs::CObservation& observation) const {
    return sensors.empty() ||
           std::find(sensors.begin(), sensors.end(), observation.sensorLabel) != sensors.end();
}

StampNs TimedSweep::begin_ns() const {
    return scan.stamp_ns + std::llround(1e9 * scan.begin_s);
}

StampNs TimedSweep::end_ns() const {
    return scan.stamp_ns + std::llround(1e9 * scan.end_s);
}

void tell(const CloudMapper& mapper, const SweepCounts& sweeps, bool removes_moving, Results& results) {
    const CloudMapCounts& counts = mapper.counts();
    const auto set = [&results](const char* key, std::uint64_t value) {
        results.metrics[key] = static_cast<std::int64_t>(value);
    };
    set("cloud_points", mapper.cloud().points().size());
    set("cloud_sweeps", static_cast<std::uint64_t>(sweeps.mapped));
    set("cloud_returns", counts.returns);
    set("cloud_blocks_held", counts.most_blocks);
    set("cloud_candidates_held", counts.most_candidates);
    if (removes_moving) set("cloud_points_moving", counts.moving);
    if (sweeps.without_pose > 0)
        set("cloud_sweeps_without_pose", static_cast<std::uint64_t>(sweeps.without_pose));
}

}  // namespace loopline::cloud_map
