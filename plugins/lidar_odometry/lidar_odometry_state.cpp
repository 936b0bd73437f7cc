/// What a break between two sweeps must keep.
#include "api/state_archive.h"
#include "lidar_odometry/lidar_odometry_module.h"

namespace loopline {

namespace lidar_odometry {

template <class Archive>
void fields(Archive& archive, Feature& f) {
    archive(f.p_base_m, f.along_base, f.beam_base, f.time_s, f.variance_m2, f.roughness_m2, f.ring,
            f.matched);
}

template <class Archive>
void fields(Archive& archive, SweepOdometry& odometry) {
    archive(odometry.before_.edges, odometry.before_.planar, odometry.step_.T_map_base,
            odometry.step_.velocity, odometry.step_.covariance, odometry.T_map_middle_,
            odometry.velocity_covariance_, odometry.way_velocity_, odometry.sweeps_, odometry.middle_ns_,
            odometry.middle_s_);
}

}  // namespace lidar_odometry

template <class Archive>
void fields(Archive& archive, LidarOdometryModule& m) {
    archive(*m.odometry_, m.label_in_use_, m.sweeps_, m.T_map_last_, m.unusable_, m.backwards_,
            m.other_sensors_, m.degenerate_, m.unconverged_, m.lines_, m.planes_, m.weakest_sigma_m_);
    for (auto& count : m.free_) archive(count);
}

void LidarOdometryModule::save_state(mrpt::serialization::CArchive& out) const {
    write_state(out, info().name, 1, *this);
}

void LidarOdometryModule::load_state(mrpt::serialization::CArchive& in) {
    read_state(in, info().name, 1, *this);
}

}  // namespace loopline
