#include "cloud_map/final_cloud_map.h"

#include <algorithm>

#include "api/sweep_classes.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(FinalCloudMapBuilder, MapBuilder, loopline)

using namespace cloud_map;

ModuleInfo FinalCloudMapBuilder::info() const {
    return {"final_cloud_map",
            "The same cloud as module cloud_map's, in a second pass over the log, by the final poses: for "
            "trajectories that are revised after their time.",
            {},
            sweep_classes(),
            {}};
}

ParameterTable FinalCloudMapBuilder::parameters() {
    ParameterTable table("final_cloud_map", info().sentence);
    options_.declare(table);
    return table;
}

void FinalCloudMapBuilder::start(const RunContext& context, const Trajectory& trajectory) {
    if (!wanted_) return;
    trajectory_ = &trajectory;
    reader_ = std::make_unique<lidar::SpinningScanReader>(options_.cloud_sweep);
    mapper_ = std::make_unique<CloudMapper>(options_.settings, context.threads);
    mapper_->keep_in(context.scratch_folder, "final_cloud_map");
    counts_ = {};
}

/// All poses from the one before the sweep to the one after it, and the next on each side, as the motion
/// there may have to go on.
PoseWindow FinalCloudMapBuilder::path_about(const TimedSweep& sweep, std::uint64_t sequence) const {
    PoseWindow path(options_.max_gap_s);
    const auto nearest =
        trajectory_->enclosing(std::clamp(sweep.scan.stamp_ns, trajectory_->entries().front().stamp_ns,
                                          trajectory_->entries().back().stamp_ns),
                               sequence);
    if (!nearest) return path;
    std::size_t first = *nearest, last = *nearest;
    while (first > 0 && (*trajectory_)[first].stamp_ns > sweep.begin_ns()) --first;
    while (last + 1 < trajectory_->size() && (*trajectory_)[last].stamp_ns < sweep.end_ns()) ++last;
    first -= first > 0 ? 1 : 0;
    last += last + 1 < trajectory_->size() ? 1 : 0;
    for (std::size_t i = first; i <= last; ++i) {
        const TrajectoryEntry entry = (*trajectory_)[i];
        path.add({entry.stamp_ns, entry.T_map_base});
    }
    return path;
}

void FinalCloudMapBuilder::insert(const StreamItem& item) {
    if (!wanted_ || trajectory_->empty() || !options_.wants(*item.observation)) return;
    if (!reader_->read(*item.observation, sweep_.scan, &sweep_.intensity)) return;
    const PoseWindow path = path_about(sweep_, item.sequence);
    const bool mapped = mapper_->add(sweep_.scan, sweep_.intensity, [&](StampNs t) { return path.at(t); });
    ++(mapped ? counts_.mapped : counts_.without_pose);
}

void FinalCloudMapBuilder::finish(Results& results) {
    if (!wanted_) return;
    mapper_->finish();
    tell(*mapper_, counts_, options_.settings.removal.remove_moving, results);
}

}  // namespace loopline
