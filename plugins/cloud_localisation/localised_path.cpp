#include "cloud_localisation/localised_path.h"

#include <algorithm>

#include "inertial/pose_error.h"

namespace loopline::cloud_localisation {
void LocalisedPath::add(std::uint64_t sequence, StampNs stamp_ns, const LocalisedSweep& sweep) {
    const std::size_t index = sweeps_.size();
    if (sweep.begins_search) lost_.push_back({index, index, stamp_ns, stamp_ns, false});
    if (sweep.T_map_local) lay_out_backwards(sweep);
    Sweep record;
    record.sequence = sequence;
    record.stamp_ns = stamp_ns;
    record.T_map_base_online = Pose3Record(sweep.T_map_base);
    record.T_map_base = sweep.known ? record.T_map_base_online : Pose3Record(sweep.T_local_base);
    Eigen::Map<Matrix6d>(record.covariance.data()) = sweep.known ? sweep.covariance : sweep.local_covariance;
    record.has_place = sweep.known ? 1 : 0;
    sweeps_.push_back(record);
    if (sweep.known && !known_from_) known_from_ = index;
    if (lost_.empty() || lost_.back().found) return;
    lost_.back().end_ns = stamp_ns;
    lost_.back().found = sweep.known;
    if (!sweep.known) lost_.back().end_sweep = index + 1;
}

/// Sweeps since the search began. A chain that is known from its beginning is known from its end by what is
/// left of it.
void LocalisedPath::lay_out_backwards(const LocalisedSweep& found) {
    const std::size_t first = lost_.back().first_sweep, end = sweeps_.size();
    const Matrix6d R = inertial::turned_both(found.T_map_local->rotation);
    for (std::size_t k = first; k < end; ++k) {
        Sweep record = sweeps_[k];
        const Pose3 T_map_base = *found.T_map_local * record.T_map_base.pose();
        const Matrix6d F = inertial::carried_along(T_map_base.translation_m - found.T_map_base.translation_m);
        const double left = 1 - static_cast<double>(k - first) / static_cast<double>(end - first);
        record.T_map_base = Pose3Record(T_map_base);
        Eigen::Map<Matrix6d>(record.covariance.data()) =
            F * found.covariance * F.transpose() + left * (R * found.local_covariance * R.transpose());
        record.has_place = 1;
        sweeps_.set(k, record);
    }
}

std::size_t LocalisedPath::without_place() const {
    return lost_.empty() || lost_.back().found ? 0 : lost_.back().end_sweep - lost_.back().first_sweep;
}

void LocalisedPath::lay_out(Trajectory& trajectory) const {
    std::size_t index = 0, known_from = 0;
    for (std::size_t k = 0; k < sweeps_.size(); ++k) {
        const Sweep record = sweeps_[k];
        if (record.has_place == 0) continue;
        if (k == known_from_) known_from = index;
        trajectory.append_revised(record.sequence, record.stamp_ns, record.T_map_base_online.pose(),
                                  record.T_map_base.pose(),
                                  Matrix6d(Eigen::Map<const Matrix6d>(record.covariance.data())));
        ++index;
    }
    trajectory.finish_revision();
    trajectory.set_known_from(known_from);
}

}  // namespace loopline::cloud_localisation
