#include "api/trajectory.h"

#include <algorithm>
#include <cassert>

#include "api/pose3_motion.h"

namespace loopline {
namespace {

bool encloses(const TrajectoryEntry& a, const TrajectoryEntry& b, StampNs stamp_ns) {
    return (a.stamp_ns <= stamp_ns && stamp_ns <= b.stamp_ns) ||
           (b.stamp_ns <= stamp_ns && stamp_ns <= a.stamp_ns);
}

}  // namespace

void Trajectory::append(std::uint64_t sequence, StampNs stamp_ns, const Pose3& T_map_base,
                        const PoseCovariance& covariance) {
    assert(entries_.empty() || sequence > entries_.back().sequence);
    entries_.push_back({sequence, stamp_ns, T_map_base, covariance});
    if (!online_.empty()) online_.push_back(T_map_base);
}

void Trajectory::replace_last(const Pose3& T_map_base, const PoseCovariance& covariance) {
    assert(!entries_.empty());
    entries_.back().T_map_base = T_map_base;
    entries_.back().covariance = covariance;
    if (!online_.empty()) online_.back() = T_map_base;
}

void Trajectory::revise(std::size_t index, const Pose3& T_map_base, const PoseCovariance& covariance) {
    assert(index < entries_.size());
    if (online_.empty()) {
        online_.reserve(entries_.capacity());
        for (const TrajectoryEntry& entry : entries_) online_.push_back(entry.T_map_base);
    }
    entries_[index].T_map_base = T_map_base;
    entries_[index].covariance = covariance;
}

const TrajectoryEntry* Trajectory::find(std::uint64_t sequence) const {
    const auto found =
        std::lower_bound(entries_.begin(), entries_.end(), sequence,
                         [](const TrajectoryEntry& e, std::uint64_t s) { return e.sequence < s; });
    return found == entries_.end() || found->sequence != sequence ? nullptr : &*found;
}

std::optional<std::size_t> Trajectory::enclosing(StampNs stamp_ns, std::uint64_t hint_sequence) const {
    if (entries_.empty()) return std::nullopt;
    const auto not_before = std::lower_bound(entries_.begin(), entries_.end(), hint_sequence,
                                             [](const auto& e, std::uint64_t s) { return e.sequence < s; });
    const auto start = static_cast<std::ptrdiff_t>(not_before - entries_.begin());
    const auto last = static_cast<std::ptrdiff_t>(entries_.size()) - 1;
    for (std::ptrdiff_t distance = 0; distance <= last + 1; ++distance)
        for (const std::ptrdiff_t left : {start - 1 - distance, start - 1 + distance}) {
            if (left < 0 || left > last) continue;
            const auto& a = entries_[static_cast<std::size_t>(left)];
            const auto& b = entries_[static_cast<std::size_t>(std::min(left + 1, last))];
            if (encloses(a, b, stamp_ns)) return static_cast<std::size_t>(left);
        }
    return std::nullopt;
}

std::optional<Pose3> Trajectory::pose_at(StampNs stamp_ns, std::uint64_t hint_sequence) const {
    const auto left = enclosing(stamp_ns, hint_sequence);
    if (!left) return std::nullopt;
    const auto &a = entries_[*left], &b = entries_[std::min(*left + 1, entries_.size() - 1)];
    return ScrewSegment(a.stamp_ns, a.T_map_base, b.stamp_ns, b.T_map_base).at(stamp_ns);
}

double Trajectory::length_m() const {
    double length_m = 0;
    for (std::size_t i = 1; i < entries_.size(); ++i)
        length_m += (entries_[i].T_map_base.translation_m - entries_[i - 1].T_map_base.translation_m).norm();
    return length_m;
}

}  // namespace loopline
