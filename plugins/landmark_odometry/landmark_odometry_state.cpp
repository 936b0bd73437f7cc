/// What a break between two scans must keep.
#include "api/state_archive.h"
#include "landmark_odometry/landmark_odometry_module.h"

namespace loopline {

namespace landmark_odometry {

template <class Archive>
void fields(Archive& archive, Sighting& sighting) {
    archive(sighting.p_base_m, sighting.covariance_m2);
}

template <class Archive>
void fields(Archive& archive, LandmarkOdometry& o) {
    archive(o.filter_, o.origin_, o.way_m_, o.origin_way_m_, o.scans_);
    archive.each(o.seen_, [](auto& a, auto& seen) { a(seen.way_m); });
    archive.each(o.tentative_,
                 [](auto& a, auto& t) { a(t.p_local_m, t.covariance_m2, t.sightings, t.scan); });
    archive(o.counts_.matched, o.counts_.ambiguous, o.counts_.off, o.counts_.tentative, o.counts_.landmarks,
            o.counts_.sum_of_squares);
}

}  // namespace landmark_odometry

template <class Archive>
void fields(Archive& archive, LandmarkOdometryModule& m) {
    archive(*m.odometry_, m.wheels_, m.wheels_in_use_, m.label_in_use_, m.placed_, m.last_ns_, m.wheel_poses_,
            m.scans_, m.before_wheels_, m.backwards_, m.other_sensors_);
    archive.each(m.waiting_, [](auto& a, auto& scan) {
        a(scan.sequence, scan.stamp_ns, scan.timestamp, scan.sightings);
    });
}

void LandmarkOdometryModule::save_state(mrpt::serialization::CArchive& out) const {
    write_state(out, info().name, 1, *this);
}

void LandmarkOdometryModule::load_state(mrpt::serialization::CArchive& in) {
    read_state(in, info().name, 1, *this);
}

}  // namespace loopline
