#include "maps/scan_in_map.h"

#include <mrpt/poses/CPose3D.h>

#include <algorithm>

#include "api/mrpt_pose.h"

namespace loopline::maps {

bool ScanInMap::take(const StreamItem& item, const Trajectory& trajectory,
                     const std::vector<std::string>& sensors) {
    observation_ = dynamic_cast<const mrpt::obs::CObservation2DRangeScan*>(item.observation.get());
    if (!observation_) return false;
    if (!sensors.empty() &&
        std::find(sensors.begin(), sensors.end(), observation_->sensorLabel) == sensors.end())
        return false;
    entry_ = trajectory.find(item.sequence);
    if (!entry_ || !to_planar_scan(*observation_, beams_)) return false;
    T_map_sensor_ = entry_->T_map_base * pose3_from_mrpt(observation_->sensorPose);
    return T_map_sensor_.translation_m.allFinite() && T_map_sensor_.rotation.coeffs().allFinite();
}

mrpt::poses::CPose3D to_mrpt(const Pose3& pose) {
    mrpt::math::CMatrixDouble33 rotation;
    rotation.asEigen() = pose.rotation.toRotationMatrix();
    mrpt::poses::CPose3D result;
    result.setRotationMatrix(rotation);
    result.x(pose.translation_m.x());
    result.y(pose.translation_m.y());
    result.z(pose.translation_m.z());
    return result;
}

}  // namespace loopline::maps
