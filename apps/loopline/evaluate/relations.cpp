#include "evaluate/relations.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "evaluate/text_rows.h"

namespace loopline {
namespace {

constexpr StampNs same_time_ns = 2000;  // stamps of relation files have six decimals

void sort_by_stamp(std::vector<StampedPose>& poses) {
    std::stable_sort(poses.begin(), poses.end(),
                     [](const auto& a, const auto& b) { return a.stamp_ns < b.stamp_ns; });
}

struct Interpolated {
    Pose2 pose;
    std::size_t index;  ///< of the pose at that time, else of the one before it
};

std::optional<Interpolated> interpolate(const std::vector<StampedPose>& poses, StampNs stamp_ns,
                                        double max_gap_s) {
    const auto after = std::upper_bound(poses.begin(), poses.end(), stamp_ns,
                                        [](StampNs stamp, const auto& p) { return stamp < p.stamp_ns; });
    const auto next = static_cast<std::size_t>(after - poses.begin());
    if (next > 0 && stamp_ns - poses[next - 1].stamp_ns < same_time_ns)
        return Interpolated{poses[next - 1].T_map_base.planar(), next - 1};
    if (next < poses.size() && poses[next].stamp_ns - stamp_ns < same_time_ns)
        return Interpolated{poses[next].T_map_base.planar(), next};
    if (next == 0 || next == poses.size()) return std::nullopt;

    const double since_s = seconds_between(poses[next - 1].stamp_ns, stamp_ns);
    const double until_s = seconds_between(stamp_ns, poses[next].stamp_ns);
    if (std::min(since_s, until_s) > max_gap_s) return std::nullopt;
    const double u = since_s / (since_s + until_s);
    const Pose2 a = poses[next - 1].T_map_base.planar(), b = poses[next].T_map_base.planar();
    return Interpolated{{a.x_m + u * (b.x_m - a.x_m), a.y_m + u * (b.y_m - a.y_m),
                         wrap_to_pi(a.phi_rad + u * wrap_to_pi(b.phi_rad - a.phi_rad))},
                        next - 1};
}

/// The pose nearest in time to `stamp_ns`, moved on by the odometry's motion between the two times.
std::optional<Pose2> carry(const std::vector<StampedPose>& poses, std::size_t before,
                           const std::vector<StampedPose>& odometry, StampNs stamp_ns) {
    const bool first_is_nearer = stamp_ns - poses[before].stamp_ns <= poses[before + 1].stamp_ns - stamp_ns;
    const StampedPose& nearest = poses[first_is_nearer ? before : before + 1];
    const double any_gap_s = std::numeric_limits<double>::infinity();
    const auto from = interpolate(odometry, nearest.stamp_ns, any_gap_s);
    const auto to = interpolate(odometry, stamp_ns, any_gap_s);
    if (!from || !to) return std::nullopt;
    return nearest.T_map_base.planar() * (from->pose.inverse() * to->pose);
}

}  // namespace

std::vector<Relation> read_relations(const std::filesystem::path& file) {
    std::vector<Relation> relations;
    for_each_row(file, "the relations", [&](const TextRow& row) {
        if (row.size() != 8)
            row.fail("a relation has the 8 columns \"t1 t2 x y z roll pitch yaw\", this line has " +
                     std::to_string(row.size()));
        for (std::size_t unused = 4; unused < 7; ++unused) row.number(unused);
        relations.push_back({row.stamp(0), row.stamp(1), {row.number(2), row.number(3), row.number(7)}});
    });
    return relations;
}

RelationsError relations_error(const std::vector<Relation>& relations, std::vector<StampedPose> trajectory,
                               std::vector<StampedPose> odometry, const RelationsSettings& settings) {
    sort_by_stamp(trajectory);
    sort_by_stamp(odometry);
    const auto pose_at = [&](StampNs stamp_ns) -> std::optional<Pose2> {
        const auto found = interpolate(trajectory, stamp_ns, settings.max_gap_s);
        if (!found) return std::nullopt;
        const bool at_a_pose = std::abs(trajectory[found->index].stamp_ns - stamp_ns) <= same_time_ns;
        if (!odometry.empty() && !at_a_pose)
            if (const auto carried = carry(trajectory, found->index, odometry, stamp_ns)) return carried;
        return found->pose;
    };

    RelationsError error;
    error.relations = relations.size();
    for (const auto& relation : relations) {
        const auto first = pose_at(relation.first_ns), second = pose_at(relation.second_ns);
        if (!first || !second) continue;
        const Pose2 difference = relation.T_first_second.inverse() * (first->inverse() * *second);
        error.translations_m.push_back(difference.translation().norm());
        error.rotations_deg.push_back(std::abs(difference.phi_rad) * 180 / M_PI);
    }
    error.translation_m = statistics_of(error.translations_m);
    error.rotation_deg = statistics_of(error.rotations_deg);
    return error;
}

}  // namespace loopline
