#include "api/trajectory.h"

#include <algorithm>
#include <cassert>

#include "api/pose3_motion.h"

namespace loopline {
namespace {

bool encloses(StampNs a_ns, StampNs b_ns, StampNs stamp_ns) {
    return (a_ns <= stamp_ns && stamp_ns <= b_ns) || (b_ns <= stamp_ns && stamp_ns <= a_ns);
}

}  // namespace

void Trajectory::append(std::uint64_t sequence, StampNs stamp_ns, const Pose3& T_map_base,
                        const PoseCovariance& covariance) {
    append_revised(sequence, stamp_ns, T_map_base, T_map_base, covariance);
}

void Trajectory::append_revised(std::uint64_t sequence, StampNs stamp_ns, const Pose3& T_map_base_online,
                                const Pose3& T_map_base, const PoseCovariance& covariance) {
    assert(empty() || sequence > records_.back().sequence);
    Record record;
    record.sequence = sequence;
    record.stamp_ns = stamp_ns;
    record.T_map_base = Pose3Record(T_map_base);
    record.T_map_base_online = Pose3Record(T_map_base_online);
    set_covariance(size(), covariance, record);
    records_.push_back(record);
}

void Trajectory::replace_last(const Pose3& T_map_base, const PoseCovariance& covariance) {
    assert(!empty());
    Record record = records_.back();
    record.T_map_base = Pose3Record(T_map_base);
    record.T_map_base_online = Pose3Record(T_map_base);
    set_covariance(size() - 1, covariance, record);
    records_.set(size() - 1, record);
}

void Trajectory::revise(std::size_t index, const Pose3& T_map_base, const PoseCovariance& covariance) {
    Record record = records_[index];
    record.T_map_base = Pose3Record(T_map_base);
    set_covariance(index, covariance, record);
    records_.set(index, record);
}

void Trajectory::set_covariance(std::size_t index, const PoseCovariance& covariance, Record& record) {
    Eigen::Map<Eigen::Matrix3d>{record.covariance} = covariance.planar();
    if (covariance.is_planar())
        spatial_.erase(index);
    else
        spatial_[index] = covariance;
}

TrajectoryEntry Trajectory::operator[](std::size_t index) const {
    const Record record = records_[index];
    TrajectoryEntry entry{record.sequence, record.stamp_ns, record.T_map_base.pose(), {}};
    const auto spatial = spatial_.find(index);
    entry.covariance = spatial != spatial_.end()
                           ? spatial->second
                           : PoseCovariance::planar(Eigen::Map<const Eigen::Matrix3d>(record.covariance));
    return entry;
}

Pose3 Trajectory::T_map_base_online(std::size_t index) const {
    return records_[index].T_map_base_online.pose();
}

std::size_t Trajectory::not_before(std::uint64_t sequence) const {
    const auto found = std::lower_bound(records_.begin(), records_.end(), sequence,
                                        [](const Record& r, std::uint64_t s) { return r.sequence < s; });
    return static_cast<std::size_t>(found - records_.begin());
}

std::optional<TrajectoryEntry> Trajectory::find(std::uint64_t sequence) const {
    const std::size_t index = not_before(sequence);
    if (index == size() || records_[index].sequence != sequence) return std::nullopt;
    return (*this)[index];
}

std::optional<std::size_t> Trajectory::enclosing(StampNs stamp_ns, std::uint64_t hint_sequence) const {
    if (empty()) return std::nullopt;
    const auto start = static_cast<std::ptrdiff_t>(not_before(hint_sequence));
    const auto last = static_cast<std::ptrdiff_t>(size()) - 1;
    for (std::ptrdiff_t distance = 0; distance <= last + 1; ++distance)
        for (const std::ptrdiff_t left : {start - 1 - distance, start - 1 + distance}) {
            if (left < 0 || left > last) continue;
            const Record a = records_[static_cast<std::size_t>(left)];
            const Record b = records_[static_cast<std::size_t>(std::min(left + 1, last))];
            if (encloses(a.stamp_ns, b.stamp_ns, stamp_ns)) return static_cast<std::size_t>(left);
        }
    return std::nullopt;
}

std::optional<Pose3> Trajectory::pose_at(StampNs stamp_ns, std::uint64_t hint_sequence) const {
    const auto left = enclosing(stamp_ns, hint_sequence);
    if (!left) return std::nullopt;
    const TrajectoryEntry a = (*this)[*left], b = (*this)[std::min(*left + 1, size() - 1)];
    return ScrewSegment(a.stamp_ns, a.T_map_base, b.stamp_ns, b.T_map_base).at(stamp_ns);
}

double Trajectory::length_m() const {
    double length_m = 0;
    Eigen::Vector3d before_m = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < size(); ++i) {
        const Eigen::Vector3d here_m = records_[i].T_map_base.pose().translation_m;
        if (i > 0) length_m += (here_m - before_m).norm();
        before_m = here_m;
    }
    return length_m;
}

}  // namespace loopline
