#include "evaluate/feature_points.h"

#include <algorithm>
#include <cmath>

#include "api/mrpt_pose.h"
#include "api/path_sampler.h"

namespace loopline {
namespace {

constexpr double longest_gap_s = 1;
constexpr double pass_m = 5, pass_factor = 1.5;

}  // namespace

TruePath::TruePath(std::shared_ptr<const StampedPath> poses) : poses_(std::move(poses)) {
    StampedPath sorted;
    if (&in_order_of_stamps(*poses_, sorted) == &sorted)
        poses_ = std::make_shared<const StampedPath>(std::move(sorted));
}

const ScrewSegment& TruePath::segment_to(std::size_t right) {
    Segment& segment = right % 2 == 0 ? even_ : odd_;
    if (segment.right != right) {
        const StampedPose a = poses()[right - 1], b = poses()[right];
        segment = {right, ScrewSegment(a.stamp_ns, a.T_map_base, b.stamp_ns, b.T_map_base)};
    }
    return segment.screw;
}

std::optional<Pose3> TruePath::at(StampNs stamp_ns) {
    const auto& poses = *poses_;
    const auto encloses = [&](std::size_t right) {
        return right > 0 && right < poses.size() && poses.stamp_ns(right - 1) <= stamp_ns &&
               stamp_ns <= poses.stamp_ns(right);
    };
    if (!encloses(right_)) {
        if (encloses(right_ + 1)) {
            ++right_;
        } else {
            const auto found =
                std::lower_bound(poses.begin(), poses.end(), stamp_ns,
                                 [](const auto& pose, StampNs s) { return pose.stamp_ns < s; });
            const auto index = std::max<std::ptrdiff_t>(1, found - poses.begin());
            if (!encloses(static_cast<std::size_t>(index))) return std::nullopt;
            right_ = static_cast<std::size_t>(index);
        }
    }
    if (seconds_between(poses.stamp_ns(right_ - 1), poses.stamp_ns(right_)) > longest_gap_s)
        return std::nullopt;
    return segment_to(right_).at(stamp_ns);
}

std::optional<Pose3> map_from_truth(const Trajectory& estimate, TruePath& truth) {
    for (const TrajectoryEntry& entry : estimate.entries())
        if (const auto T_truth_base = truth.at(entry.stamp_ns))
            return entry.T_map_base * T_truth_base->inverse();
    return std::nullopt;
}

FeaturePointHits::FeaturePointHits(std::vector<FeaturePoint> points, TruePath truth, double scan_duration_s)
    : truth_(std::move(truth)), scan_duration_s_(scan_duration_s) {
    for (const FeaturePoint& point : points) {
        watched_.push_back({point, {}, {}});
        find_passes(watched_.back());
    }
}

void FeaturePointHits::find_passes(Watched& watched) const {
    const auto distance_m = [&](const StampedPose& pose) {
        return (pose.T_map_base.translation_m.head<2>() - watched.point.position_m).norm();
    };
    double least_m = INFINITY;
    for (const auto& pose : truth_.poses()) least_m = std::min(least_m, distance_m(pose));
    const double within_m = std::max(pass_m, pass_factor * least_m);
    bool inside = false;
    for (const auto& pose : truth_.poses()) {
        const double d_m = distance_m(pose);
        if (d_m <= within_m) {
            if (!inside) watched.passes.push_back({pose.stamp_ns, pose.stamp_ns, d_m});
            Pass& pass = watched.passes.back();
            pass.last_ns = pose.stamp_ns;
            pass.least_m = std::min(pass.least_m, d_m);
        }
        inside = d_m <= within_m;
    }
}

bool FeaturePointHits::is_level(const mrpt::obs::CObservation2DRangeScan& scan) {
    constexpr double tolerance_rad = 2 * M_PI / 180;
    Level& level = levels_[scan.sensorLabel];
    const auto& rotation = scan.sensorPose.getRotationMatrix();
    if (level.yes && !std::equal(rotation.begin(), rotation.end(), level.rotation.begin())) {
        level.rotation = rotation;
        level.yes = std::abs(scan.sensorPose.pitch()) < tolerance_rad &&
                    std::abs(std::remainder(scan.sensorPose.roll(), M_PI)) < tolerance_rad;
    }
    return level.yes;
}

void FeaturePointHits::take(const mrpt::obs::CObservation2DRangeScan& scan, StampNs stamp_ns,
                            std::uint64_t sequence) {
    if (watched_.empty() || scan.getScanSize() < 2 || !is_level(scan)) return;
    std::optional<Pose3> T_base_sensor;
    for (Watched& watched : watched_)
        for (std::size_t pass = 0; pass < watched.passes.size(); ++pass) {
            if (stamp_ns < watched.passes[pass].first_ns || stamp_ns > watched.passes[pass].last_ns) continue;
            if (!T_base_sensor) T_base_sensor = pose3_from_mrpt(scan.sensorPose);
            look_for(watched, pass, scan, *T_base_sensor, stamp_ns, sequence);
        }
}

void FeaturePointHits::look_for(Watched& watched, std::size_t pass,
                                const mrpt::obs::CObservation2DRangeScan& scan, const Pose3& T_base_sensor,
                                StampNs stamp_ns, std::uint64_t sequence) {
    const auto T_truth_base = truth_.at(stamp_ns);
    if (!T_truth_base) return;
    const Pose3 T_truth_sensor = *T_truth_base * T_base_sensor;
    const Eigen::Vector2d& point_m = watched.point.position_m;
    const Eigen::Vector3d p_sensor =
        T_truth_sensor.inverse() *
        Eigen::Vector3d(point_m.x(), point_m.y(), T_truth_sensor.translation_m.z());
    const double distance_m = p_sensor.head<2>().norm();

    // The beams that can hit it, with room for the vehicle's motion during the sweep.
    const auto duration_ns = static_cast<StampNs>(std::llround(1e9 * scan_duration_s_));
    const Pose3 T_truth_end = truth_.at(stamp_ns + duration_ns).value_or(*T_truth_base) * T_base_sensor;
    const double moved_m = (T_truth_end.translation_m - T_truth_sensor.translation_m).norm();
    const double turned_rad = T_truth_end.rotation.angularDistance(T_truth_sensor.rotation);
    const double room_m = hit_radius_m + 1.1 * moved_m;
    const auto last_beam = static_cast<double>(scan.getScanSize() - 1);
    const double sense = scan.rightToLeft ? 1 : -1, step_rad = scan.aperture / last_beam;
    const double middle = last_beam * (0.5 + sense * std::atan2(p_sensor.y(), p_sensor.x()) / scan.aperture);
    const double reach_rad =
        room_m < distance_m ? std::asin(room_m / distance_m) + 1.1 * turned_rad : 2 * M_PI;
    const double reach = reach_rad / step_rad + 1;
    const auto first = static_cast<std::size_t>(std::clamp(std::ceil(middle - reach), 0.0, last_beam));
    for (std::size_t beam = first; static_cast<double>(beam) <= std::min(middle + reach, last_beam); ++beam) {
        const double range_m = scan.getScanRange(beam);
        if (!scan.getScanRangeValidity(beam) || !(std::abs(range_m - distance_m) <= room_m)) continue;
        const double along = static_cast<double>(beam) / last_beam,
                     angle = sense * scan.aperture * (along - 0.5);
        const StampNs time_ns = stamp_ns + static_cast<StampNs>(std::llround(1e9 * scan_duration_s_ * along));
        const auto T_truth_at_beam = truth_.at(time_ns);
        if (!T_truth_at_beam) continue;
        const Eigen::Vector3d p_base =
            T_base_sensor * Eigen::Vector3d(range_m * std::cos(angle), range_m * std::sin(angle), 0);
        if (((*T_truth_at_beam * p_base).head<2>() - point_m).norm() <= hit_radius_m)
            watched.hits.push_back({sequence, time_ns, p_base, pass, &levels_.find(scan.sensorLabel)->first});
    }
}

std::vector<FeaturePointHits::Hit> FeaturePointHits::hits_of_closest_pass(const Watched& watched) const {
    std::vector<Hit> hits;
    double least_m = INFINITY;
    for (std::size_t pass = 0; pass < watched.passes.size(); ++pass) {
        std::vector<Hit> of_pass;
        std::copy_if(watched.hits.begin(), watched.hits.end(), std::back_inserter(of_pass),
                     [&](const Hit& hit) { return hit.pass == pass && levels_.at(*hit.sensor).yes; });
        if (of_pass.empty() || watched.passes[pass].least_m >= least_m) continue;
        least_m = watched.passes[pass].least_m;
        hits = std::move(of_pass);
    }
    return hits;
}

FeaturePointHits::Outcome FeaturePointHits::estimates(const Trajectory& estimate,
                                                      const Trajectory* odometry) {
    Outcome outcome;
    const auto T_map_truth = map_from_truth(estimate, truth_);
    PathSampler T_map_base(estimate, longest_gap_s);
    std::optional<PathSampler> T_odom_base;
    std::optional<Pose3> T_map_odom;  // both begin at the same true place
    if (odometry != nullptr && T_map_truth) {
        if (const auto T_odom_truth = map_from_truth(*odometry, truth_))
            T_map_odom = *T_map_truth * T_odom_truth->inverse();
        if (T_map_odom) T_odom_base.emplace(*odometry, longest_gap_s);
    }
    for (const Watched& watched : watched_) {
        Eigen::Vector2d sum_m(0, 0), true_sum_m(0, 0), odometry_sum_m(0, 0);
        std::size_t returns = 0, by_odometry = 0;
        if (T_map_truth)
            for (const Hit& hit : hits_of_closest_pass(watched)) {
                const auto pose = T_map_base.at(hit.time_ns, hit.sequence);
                const auto true_pose = truth_.at(hit.time_ns);
                if (!pose || !true_pose) continue;
                sum_m += (*pose * hit.p_base).head<2>();
                true_sum_m += (*T_map_truth * (*true_pose * hit.p_base)).head<2>();
                ++returns;
                const auto odometry_pose =
                    T_odom_base ? T_odom_base->at(hit.time_ns, hit.sequence) : std::nullopt;
                if (!odometry_pose) continue;
                odometry_sum_m += (*T_map_odom * (*odometry_pose * hit.p_base)).head<2>();
                ++by_odometry;
            }
        if (returns == 0) {
            outcome.missed.push_back(watched.point.number);
            continue;
        }
        PointEstimate point;
        point.number = watched.point.number;
        point.returns = returns;
        const Eigen::Vector2d& p = watched.point.position_m;
        point.true_m = (*T_map_truth * Eigen::Vector3d(p.x(), p.y(), 0)).head<2>();
        point.estimate_m = sum_m / static_cast<double>(returns);
        point.by_true_poses_m = true_sum_m / static_cast<double>(returns);
        if (by_odometry > 0) point.odometry_m = odometry_sum_m / static_cast<double>(by_odometry);
        outcome.points.push_back(point);
    }
    return outcome;
}

}  // namespace loopline
