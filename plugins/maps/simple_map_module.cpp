#include "maps/simple_map_module.h"

#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <cmath>

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(SimpleMapBuilder, MapBuilder, loopline)

namespace {

mrpt::poses::CPose3DPDFGaussian::Ptr pose_with_covariance(const TrajectoryEntry& entry) {
    const int order[6] = {0, 1, 2, 5, 4, 3};  // MRPT: x y z yaw pitch roll; ours: x y z roll pitch yaw
    auto pdf = mrpt::poses::CPose3DPDFGaussian::Create();
    pdf->mean = maps::to_mrpt(entry.T_map_base);
    for (int row = 0; row < 6; ++row)
        for (int column = 0; column < 6; ++column)
            pdf->cov(row, column) = entry.covariance(order[row], order[column]);
    return pdf;
}

}  // namespace

ModuleInfo SimpleMapBuilder::info() const {
    return {"simplemap",
            "Keeps scans with their final poses as keyframes of an MRPT .simplemap.",
            {"CObservation2DRangeScan"},
            {},
            {}};
}

ParameterTable SimpleMapBuilder::parameters() {
    return ParameterTable("simplemap", info().sentence)
        .list("sensors", sensors_, "Labels of the lasers whose scans are used; empty for all.")
        .real("distance_m", distance_m_, Range::at_least(0),
              "A scan becomes a keyframe this far from the last one of its sensor; 0 for every scan.")
        .angle("angle_deg", angle_rad_, {0, 180}, "Or when the vehicle has turned by this angle since.")
        .integer("max_keyframes", max_keyframes_, {1, 1e8}, "Keyframes beyond this number are left out.");
}

void SimpleMapBuilder::start(const RunContext&, const Trajectory& trajectory) {
    trajectory_ = &trajectory;
    map_ = mrpt::maps::CSimpleMap::Create();
    T_map_last_.clear();
    left_out_ = 0;
}

bool SimpleMapBuilder::is_keyframe(const Pose3& T_map_base, const Pose3& T_map_last) const {
    return (T_map_base.translation_m - T_map_last.translation_m).norm() >= distance_m_ ||
           T_map_base.rotation.angularDistance(T_map_last.rotation) >= angle_rad_;
}

void SimpleMapBuilder::insert(const StreamItem& item) {
    if (!scan_.take(item, *trajectory_, sensors_)) return;
    const Pose3& T_map_base = scan_.entry().T_map_base;
    const auto last = T_map_last_.find(scan_.observation().sensorLabel);
    if (last != T_map_last_.end() && !is_keyframe(T_map_base, last->second)) return;
    T_map_last_[scan_.observation().sensorLabel] = T_map_base;
    if (static_cast<std::int64_t>(map_->size()) >= max_keyframes_ || !scan_.entry().covariance.is_finite()) {
        ++left_out_;
        return;
    }
    // Frames hold observations that may be changed: a copy, the log's own is shared.
    auto frame = mrpt::obs::CSensoryFrame::Create();
    frame->insert(std::make_shared<mrpt::obs::CObservation2DRangeScan>(scan_.observation()));
    map_->insert(pose_with_covariance(scan_.entry()), frame);
}

void SimpleMapBuilder::finish(Results& results) {
    results.metrics["keyframes"] = static_cast<std::int64_t>(map_->size());
    if (left_out_ > 0) results.metrics["keyframes_left_out"] = left_out_;
    results.maps.push_back({info().name, map_});
    map_.reset();
}

}  // namespace loopline
