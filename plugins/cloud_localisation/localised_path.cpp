#include "cloud_localisation/localised_path.h"

#include <algorithm>

#include "api/dense_algebra.h"
#include "inertial/pose_error.h"
#include "inertial/rotation_vector.h"

namespace loopline::cloud_localisation {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

Vector6d difference(const Pose3& to, const Pose3& from) {
    Vector6d d;
    d << to.translation_m - from.translation_m, inertial::log_so3(to.rotation * from.rotation.conjugate());
    return d;
}

/// Squared distance of two poses of one moment, of which 6 are expected.
bool agree(const PoseWithCovariance& a, const PoseWithCovariance& b) {
    constexpr double contradiction = 50;
    const Vector6d d = difference(a.T_map_base, b.T_map_base);
    return squared_in_sigmas(d, a.covariance + b.covariance) < contradiction;
}

PoseWithCovariance weighted_mean(const PoseWithCovariance& a, const PoseWithCovariance& b) {
    const Matrix6d K = solved(a.covariance + b.covariance, a.covariance).transpose();
    const Vector6d step = K * difference(b.T_map_base, a.T_map_base);
    const Matrix6d covariance = a.covariance - K * a.covariance;
    return {{a.T_map_base.translation_m + step.head<3>(),
             (inertial::exp_so3(step.tail<3>()) * a.T_map_base.rotation).normalized()},
            (covariance + covariance.transpose()) / 2};
}

}  // namespace

void LocalisedPath::add(std::uint64_t sequence, StampNs stamp_ns, const LocalisedSweep& sweep) {
    const std::size_t index = sweeps_.size();
    if (sweep.begins_search) lost_.push_back({index, index, stamp_ns, stamp_ns, false, sweep.lost_at});
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

/// By the motion since then.
std::optional<PoseWithCovariance> LocalisedPath::from_where_it_was_lost(const Sweep& record) const {
    const auto& lost_at = lost_.back().lost_at;
    if (!lost_at) return std::nullopt;
    const Pose3 T_map_base = lost_at->T_map_base * record.T_map_base.pose();
    return PoseWithCovariance{T_map_base,
                              inertial::grown(lost_at->covariance, lost_at->T_map_base, T_map_base,
                                              Eigen::Map<const Matrix6d>(record.covariance.data()))};
}

/// Sweeps since the search began. A chain that is known from its beginning is known from its end by what is
/// left of it. Where both ends are known, both have their weight (two filters that meet: Fraser, Potter
/// 1969), unless they contradict each other.
void LocalisedPath::lay_out_backwards(const LocalisedSweep& found) {
    const std::size_t first = lost_.back().first_sweep, end = sweeps_.size();
    const Matrix6d R = inertial::turned_both(found.T_map_local->rotation);
    bool ends_agree = true;
    for (std::size_t k = first; k < end; ++k) {
        Sweep record = sweeps_[k];
        PoseWithCovariance pose{*found.T_map_local * record.T_map_base.pose(), {}};
        const Matrix6d F =
            inertial::carried_along(pose.T_map_base.translation_m - found.T_map_base.translation_m);
        const double left = 1 - static_cast<double>(k - first) / static_cast<double>(end - first);
        pose.covariance = propagated(F, found.covariance) + left * propagated(R, found.local_covariance);
        if (const auto other = from_where_it_was_lost(record); other && ends_agree) {
            ends_agree = k > first || agree(pose, *other);
            if (ends_agree) pose = weighted_mean(pose, *other);
        }
        record.T_map_base = Pose3Record(pose.T_map_base);
        Eigen::Map<Matrix6d>(record.covariance.data()) = pose.covariance;
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
