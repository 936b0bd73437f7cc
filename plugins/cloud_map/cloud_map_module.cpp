#include "cloud_map/cloud_map_module.h"

#include <mrpt/obs/CObservationRobotPose.h>

#include <algorithm>
#include <cmath>

#include "api/mrpt_pose.h"
#include "api/observation_class.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(CloudMapModule, Module, loopline)

using namespace cloud_map;

namespace {
constexpr std::size_t most_waiting = 20;  ///< sweeps: longer, no pose comes
}

ModuleInfo CloudMapModule::info() const {
    return {"cloud_map",
            "Puts the sweeps of a spinning lidar together to a cloud, one point a voxel, each at the pose of "
            "its own "
            "time, without what moved; nothing of it is computed with [outputs] maps = false.",
            {"CObservationRobotPose"},
            {"CObservationRotatingScan", "CObservationVelodyneScan", "CObservationPointCloud"},
            {}};
}

ParameterTable CloudMapModule::parameters() {
    auto& s = settings_;
    auto& r = settings_.removal;
    ParameterTable table("cloud_map", info().sentence);
    table.list("sensors", sensors_, "Labels of the lidars whose sweeps are used; empty for all.")
        .text("poses", poses_,
              "Label under which the module publishes whose poses carry the sweeps; empty: the first to "
              "publish any.")
        .real("voxel_m", s.voxel_m, {0.03, 10}, "One point, the first, is kept in every cube with this edge.")
        .real("min_range_m", s.min_range_m, {0, 100}, "Nearer returns are of the vehicle itself.")
        .real("max_range_m", s.max_range_m, {1, 1000}, "Farther returns are left out.")
        .real("max_gap_s", max_gap_s_, {0.001, 3600},
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
                 "A place at which so many saw something, and through which none looked, is kept.")
        .real("cloud_sweep_s", cloud_sweep_.sweep_s, {0, 10},
              "Duration of a sweep whose points come without times.");
    return table;
}

std::string CloudMapModule::check() const {
    if (settings_.min_range_m >= settings_.max_range_m) return "min_range_m is not below max_range_m";
    return {};
}

StampNs CloudMapModule::Sweep::begin_ns() const {
    return scan.stamp_ns + std::llround(1e9 * scan.begin_s);
}

StampNs CloudMapModule::Sweep::end_ns() const {
    return scan.stamp_ns + std::llround(1e9 * scan.end_s);
}

void CloudMapModule::start(const RunContext& context) {
    if (!wanted_) return;
    reader_ = std::make_unique<lidar::SpinningScanReader>(cloud_sweep_);
    mapper_ = std::make_unique<CloudMapper>(settings_, context.threads);
    mapper_->keep_in(context.scratch_folder);
    label_ = poses_;
    path_ = PoseWindow(max_gap_s_);
}

void CloudMapModule::process(const StreamItem& item, Publisher&) {
    if (!wanted_) return;
    if (as<mrpt::obs::CObservationRobotPose>(item.observation.get()) != nullptr)
        take_pose(item);
    else
        take_sweep(item);
    while (!waiting_.empty() && !path_.empty() &&
           (waiting_.front().end_ns() <= path_.last_ns() || waiting_.size() > most_waiting))
        map_first_waiting();
}

void CloudMapModule::take_pose(const StreamItem& item) {
    const std::string& label = item.observation->sensorLabel;
    if (label_.empty() && item.published) label_ = label;
    if (label != label_) return;
    const auto* pose = as<mrpt::obs::CObservationRobotPose>(item.observation.get());
    path_.add({item.stamp_ns, pose3_from_mrpt(pose->pose.mean)});
}

void CloudMapModule::take_sweep(const StreamItem& item) {
    const std::string& label = item.observation->sensorLabel;
    if (!sensors_.empty() && std::find(sensors_.begin(), sensors_.end(), label) == sensors_.end()) return;
    Sweep sweep;
    if (!reader_->read(*item.observation, sweep.scan, &sweep.intensity)) return;
    waiting_.push_back(std::move(sweep));
    if (path_.empty() && waiting_.size() > most_waiting) {
        ++without_pose_;
        waiting_.pop_front();
    }
}

void CloudMapModule::map_first_waiting() {
    const Sweep& sweep = waiting_.front();
    const bool mapped = mapper_->add(sweep.scan, sweep.intensity, [this](StampNs t) { return path_.at(t); });
    ++(mapped ? sweeps_ : without_pose_);
    path_.forget_before(sweep.begin_ns());
    waiting_.pop_front();
}

void CloudMapModule::finish(Results& results) {
    if (!wanted_) return;
    while (!waiting_.empty()) map_first_waiting();
    mapper_->finish();
    const CloudMapCounts& counts = mapper_->counts();
    const auto set = [&results](const char* key, std::uint64_t value) {
        results.metrics[key] = static_cast<std::int64_t>(value);
    };
    set("cloud_points", mapper_->cloud().points().size());
    set("cloud_sweeps", static_cast<std::uint64_t>(sweeps_));
    set("cloud_returns", counts.returns);
    set("cloud_blocks_held", counts.most_blocks);
    set("cloud_candidates_held", counts.most_candidates);
    if (settings_.removal.remove_moving) set("cloud_points_moving", counts.moving);
    if (without_pose_ > 0) set("cloud_sweeps_without_pose", static_cast<std::uint64_t>(without_pose_));
}

}  // namespace loopline
