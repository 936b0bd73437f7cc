/// What a break between two observations must keep.
#include "api/state_archive.h"
#include "fusion/fusion_module.h"

namespace loopline {

template <class Archive>
void fields(Archive& archive, PoseWithCovariance& pose) {
    archive(pose.T_map_base, pose.covariance);
}

namespace gnss {

template <class Archive>
void fields(Archive& archive, Geodetic& place) {
    archive(place.latitude_deg, place.longitude_deg, place.height_m);
}

template <class Archive>
void fields(Archive& archive, GnssFix& fix) {
    archive(fix.stamp_ns, fix.received_ns, fix.utc_ns, fix.quality, fix.antenna, fix.has_position,
            fix.has_height, fix.geoid_separation_m, fix.satellites, fix.hdop, fix.vdop, fix.sigma_enu_m,
            fix.speed_mps, fix.course_rad, fix.heading_rad, fix.p_base_antenna_m);
}

}  // namespace gnss

namespace fusion {

template <class Archive>
void fields(Archive& archive, SigmaOfFix& sigma) {
    archive(sigma.white_m, sigma.correlated_m, sigma.correlation_s);
}

template <class Archive>
void fields(Archive& archive, SeenFix& fix) {
    archive(fix.time_s, fix.p_local_m, fix.p_enu_m, fix.sigma);
}

template <class Archive>
void fields(Archive& archive, EarthState& state) {
    archive(state.T_enu_base, state.fix_error_m, state.covariance);
}

template <class Archive>
void fields(Archive& archive, EarthPath& path) {
    std::optional<gnss::Geodetic> origin;
    if (path.earth_) origin = path.earth_->origin();
    archive(origin);
    if (Archive::reading && origin) path.earth_.emplace(*origin);
    archive(path.dropped_, path.first_ns_);
    archive.each(path.poses_, [](Archive& a, EarthPath::PoseNode& node) {
        a(node.stamp_ns, node.T_odom_base, node.covariance, node.way_m);
    });
    archive(path.waiting_, path.early_, path.seen_);
    std::optional<std::uint64_t> committed = path.committed_;
    archive(committed);
    if (Archive::reading && committed) path.committed_ = *committed;
    archive(path.state_, path.ahead_, path.fix_sigma_, path.process_);
    archive.each(path.misfits_,
                 [](Archive& a, EarthPath::Misfit& misfit) { a(misfit.stamp_ns, misfit.off_m); });
    archive(path.used_ns_, path.steps_);
    for (auto& count : path.count_) archive(count);
    archive(path.sum_of_squares_, path.squares_, path.re_entries_, path.heading_way_m_,
            path.heading_found_sigma_rad_);
}

}  // namespace fusion

template <class Archive>
void fields(Archive& archive, FusionModule& m) {
    archive(*m.path_, m.last_, m.last_ns_, m.online_, m.backwards_, m.fixes_, m.geoid_separation_m_);
}

void FusionModule::save_state(mrpt::serialization::CArchive& out) const {
    write_state(out, info().name, 2, *this);
}

void FusionModule::load_state(mrpt::serialization::CArchive& in) {
    read_state(in, info().name, 2, *this);
}

}  // namespace loopline
