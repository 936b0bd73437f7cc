#include "landmark_odometry/landmark_map_builder.h"

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationBearingRange.h>

#include <algorithm>

#include "api/observation_class.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(LandmarkMapBuilder, MapBuilder, loopline)

using namespace landmark_odometry;

ModuleInfo LandmarkMapBuilder::info() const {
    return {"landmarks",
            "Collects trunks, poles or reflectors, seen by range and bearing, at their places by the final "
            "poses.",
            {"CObservationBearingRange"},
            {},
            {}};
}

ParameterTable LandmarkMapBuilder::parameters() {
    return ParameterTable("landmarks", info().sentence)
        .list("sensors", sensors_, "Labels of the sensors whose landmarks are used; empty for all.")
        .real("max_range_m", sightings_.max_range_m, {1, 1000}, "What is seen farther away is left out.")
        .real("join_m", join_m_, {0.01, 100}, "What is seen nearer than this to a landmark is that one.")
        .integer("least_sightings", least_sightings_, {1, 1e6}, "What was seen less often is no landmark.");
}

void LandmarkMapBuilder::start(const RunContext&, const Trajectory& trajectory) {
    trajectory_ = &trajectory;
    map_.emplace(join_m_);
    ground_m_ = 0;
    scans_ = 0;
}

void LandmarkMapBuilder::insert(const StreamItem& item) {
    const auto* seen = as<mrpt::obs::CObservationBearingRange>(item.observation.get());
    if (seen == nullptr || (!sensors_.empty() &&
                            std::find(sensors_.begin(), sensors_.end(), seen->sensorLabel) == sensors_.end()))
        return;
    const auto T_map_base = trajectory_->pose_at(item.stamp_ns, item.sequence);
    if (!T_map_base) return;
    ++scans_;
    ground_m_ += (T_map_base->translation_m.z() - ground_m_) / static_cast<double>(scans_);
    const Eigen::Matrix3d R = T_map_base->rotation.toRotationMatrix();
    for (const Sighting& sighting : sightings_of(*seen, sightings_)) {
        const Eigen::Vector2d p_map_m =
            (R.leftCols<2>() * sighting.p_base_m + T_map_base->translation_m).head<2>();
        map_->add(p_map_m,
                  R.topLeftCorner<2, 2>() * sighting.covariance_m2 * R.topLeftCorner<2, 2>().transpose());
    }
}

void LandmarkMapBuilder::finish(Results& results) {
    const auto points = mrpt::maps::CSimplePointsMap::Create();
    const auto landmarks = map_->landmarks(least_sightings_);
    for (const MappedLandmark& landmark : landmarks)
        points->insertPoint(static_cast<float>(landmark.p_map_m.x()),
                            static_cast<float>(landmark.p_map_m.y()), static_cast<float>(ground_m_));
    results.metrics["landmarks_mapped"] = static_cast<std::int64_t>(landmarks.size());
    results.maps.push_back({info().name, points});
    map_.reset();
}

}  // namespace loopline
