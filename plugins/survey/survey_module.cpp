#include "survey/survey_module.h"

#include <mrpt/obs/CObservation2DRangeScan.h>

#include <algorithm>

#include "api/mrpt_pose.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(SurveyMapBuilder, MapBuilder, loopline)

ModuleInfo SurveyMapBuilder::info() const {
    return {"survey",
            "Fuses the sweeps of a survey laser into a cloud, every beam at the pose of its own time; once "
            "by dead "
            "reckoning, once by the final trajectory.",
            {"CObservation2DRangeScan"},
            {},
            {}};
}

ParameterTable SurveyMapBuilder::parameters() {
    return ParameterTable("survey", info().sentence)
        .list("sensors", sensors_, "Labels of the lasers whose scans are used; empty for all.")
        .real("scan_duration_s", scan_duration_s_, {0, 10},
              "From a scan's first beam, which has its stamp, to its last; 0: all beams at once.")
        .real("min_range_m", gate_.min_m, {0, 1000}, "Nearer returns are not used.")
        .real("max_range_m", gate_.max_m, {0.1, 10000}, "Farther returns are not used.")
        .real("max_gap_s", max_gap_s_, {0.001, 3600},
              "Neither poses nor positions of the mount are interpolated across longer gaps; beams in a gap "
              "are "
              "left out.")
        .real("spacing_m", spacing_m_, {0, 100},
              "One point, the first, is kept in every cube with this edge; 0 keeps all.")
        .integer("max_points", max_points_, {1, 1e9},
                 "Points beyond this number are left out; one takes 12 bytes of memory, thinned about 60.");
}

std::string SurveyMapBuilder::check() const {
    if (gate_.min_m >= gate_.max_m) return "min_range_m is not below max_range_m";
    return {};
}

void SurveyMapBuilder::start(const RunContext&, const Trajectory& trajectory) {
    T_map_base_ = std::make_unique<PathSampler>(trajectory, max_gap_s_);
    by_label_.clear();
    cloud_ = mrpt::maps::CSimplePointsMap::Create();
    taken_ = spacing_m_ > 0 ? std::make_unique<maps::VoxelSet>(spacing_m_) : nullptr;
    counts_ = {};
    scans_ = thinned_ = over_limit_ = 0;
}

void SurveyMapBuilder::insert(const StreamItem& item) {
    const auto* observation = dynamic_cast<const mrpt::obs::CObservation2DRangeScan*>(item.observation.get());
    if (observation == nullptr) return;
    const std::string& label = observation->sensorLabel;
    if (!sensors_.empty() && std::find(sensors_.begin(), sensors_.end(), label) == sensors_.end()) return;
    survey::TimedScan scan;
    if (!to_planar_scan(*observation, scan.beams)) return;
    scan.counter_clockwise = observation->rightToLeft;
    scan.first_beam_ns = item.stamp_ns;
    scan.duration_s = scan_duration_s_;
    scan.T_base_sensor = pose3_from_mrpt(observation->sensorPose);
    scan.sequence = item.sequence;
    Sensor& sensor = by_label_[label];
    fuse_waiting(sensor, &scan);
    sensor.previous = std::move(sensor.waiting);
    sensor.waiting = std::move(scan);
}

void SurveyMapBuilder::fuse_waiting(Sensor& sensor, const survey::TimedScan* next) {
    if (!sensor.waiting) return;
    ++scans_;
    const auto mount = survey::mount_motion(sensor.previous ? &*sensor.previous : nullptr, *sensor.waiting,
                                            next, max_gap_s_);
    fused_.clear();
    survey::fuse(*sensor.waiting, mount, *T_map_base_, gate_, fused_, counts_);
    for (const Eigen::Vector3f& p : fused_) {
        if (taken_ && !taken_->take(p.cast<double>()))
            ++thinned_;
        else if (static_cast<std::int64_t>(cloud_->size()) >= max_points_)
            ++over_limit_;
        else
            cloud_->insertPointFast(p.x(), p.y(), p.z());
    }
}

void SurveyMapBuilder::finish(Results& results) {
    for (auto& [label, sensor] : by_label_) fuse_waiting(sensor, nullptr);
    cloud_->mark_as_modified();  // insertPointFast() leaves MRPT's caches as they were
    const auto set = [&results](const char* key, std::int64_t value) { results.metrics[key] = value; };
    set("survey_scans", scans_);
    set("survey_points", static_cast<std::int64_t>(cloud_->size()));
    set("survey_beams", counts_.beams);
    set("survey_beams_without_return", counts_.without_return);
    set("survey_beams_out_of_range", counts_.out_of_range);
    set("survey_beams_without_pose", counts_.without_pose);
    if (thinned_ > 0) set("survey_points_thinned", thinned_);
    if (over_limit_ > 0) set("survey_points_over_limit", over_limit_);
    NamedMap cloud{info().name, cloud_};
    cloud.survey = true;
    results.maps.push_back(cloud);
    cloud_.reset();
    taken_.reset();
    by_label_.clear();
}

}  // namespace loopline
