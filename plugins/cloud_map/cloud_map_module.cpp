#include "cloud_map/cloud_map_module.h"

#include <mrpt/obs/CObservationRobotPose.h>

#include "api/mrpt_pose.h"
#include "api/observation_class.h"
#include "api/sweep_classes.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(CloudMapModule, Module, loopline)

using namespace cloud_map;

namespace {
constexpr std::size_t most_waiting = 20;  ///< sweeps: longer, no pose comes
}

ModuleInfo CloudMapModule::info() const {
    return {
        "cloud_map",
        "Puts the sweeps of a spinning lidar together to a cloud of points that keep a distance from each "
        "other, each at the pose of its own time, without what moved; nothing of it is computed with "
        "[outputs] maps = false.",
        {"CObservationRobotPose"},
        sweep_classes(),
        {}};
}

ParameterTable CloudMapModule::parameters() {
    ParameterTable table("cloud_map", info().sentence);
    options_.declare(table);
    table.text("poses", poses_,
               "Label under which a module before it publishes the poses that carry the sweeps.");
    return table;
}

std::string CloudMapModule::check() const {
    return options_.check();
}

void CloudMapModule::start(const RunContext& context) {
    if (!wanted_) return;
    reader_ = std::make_unique<lidar::SpinningScanReader>(options_.cloud_sweep);
    mapper_ = std::make_unique<CloudMapper>(options_.settings, context.threads);
    mapper_->keep_in(context.scratch_folder, "cloud_map");
    path_ = PoseWindow(options_.max_gap_s);
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
    if (item.observation->sensorLabel != poses_) return;
    const auto* pose = as<mrpt::obs::CObservationRobotPose>(item.observation.get());
    path_.add({item.stamp_ns, pose3_from_mrpt(pose->pose.mean)});
}

void CloudMapModule::take_sweep(const StreamItem& item) {
    if (!options_.wants(*item.observation)) return;
    TimedSweep sweep;
    if (!reader_->read(*item.observation, sweep.scan, &sweep.intensity)) return;
    waiting_.push_back(std::move(sweep));
    if (path_.empty() && waiting_.size() > most_waiting) {
        ++counts_.without_pose;
        waiting_.pop_front();
    }
}

void CloudMapModule::map_first_waiting() {
    const TimedSweep& sweep = waiting_.front();
    const bool mapped = mapper_->add(sweep.scan, sweep.intensity, [this](StampNs t) { return path_.at(t); });
    ++(mapped ? counts_.mapped : counts_.without_pose);
    path_.forget_before(sweep.begin_ns());
    waiting_.pop_front();
}

void CloudMapModule::finish(Results& results) {
    if (!wanted_) return;
    while (!waiting_.empty()) map_first_waiting();
    mapper_->finish();
    if (counts_.mapped == 0 && counts_.without_pose > 0)
        results.warnings.push_back("no sweep is in the cloud, since no pose came under the label \"" +
                                   poses_ + "\" that [cloud_map] poses names");
    tell(*mapper_, counts_, options_.settings.removal.remove_moving, results);
}

}  // namespace loopline
