#include "odometry/odometry_at_scans.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace loopline {
namespace {

constexpr double shortest_for_velocity_s = 1e-3;  // below, the noise of the stamps rules

double distance_s(StampNs a_ns, StampNs b_ns) {
    return std::abs(seconds_between(a_ns, b_ns));
}

bool encloses(const OdometrySample& a, const OdometrySample& b, StampNs stamp_ns) {
    return std::min(a.stamp_ns, b.stamp_ns) <= stamp_ns && stamp_ns <= std::max(a.stamp_ns, b.stamp_ns);
}

std::int64_t between(std::int64_t a, std::int64_t b, double u) {
    return a + std::llround(u * static_cast<double>(b - a));
}

}  // namespace

void OdometryAtScans::add_odometry(const OdometrySample& sample) {
    samples_.push_back(sample);
    forget_old_samples();
}

void OdometryAtScans::add_scan(std::uint64_t scan, StampNs stamp_ns) {
    scans_.push_back({scan, stamp_ns, end() - 1});
}

std::optional<PlacedScan> OdometryAtScans::next_at_end() {
    if (scans_.empty() || samples_.empty()) return std::nullopt;
    if (auto placed = next()) return placed;
    const WaitingScan scan = scans_.front();
    scans_.pop_front();

    const std::ptrdiff_t last = end() - 1;
    const double beyond_s = seconds_between(sample(last).stamp_ns, scan.stamp_ns);
    PlacedScan placed = at_sample(scan, last);
    placed.by = PlacedScan::By::extrapolation;
    if (placed.velocity)
        placed.T_odom_base =
            placed.T_odom_base *
            exp_se2(*placed.velocity * std::clamp(beyond_s, 0.0, settings_.max_extrapolation_s));
    return placed;
}

std::optional<PlacedScan> OdometryAtScans::place(const WaitingScan& scan) {
    if (samples_.empty()) return std::nullopt;
    // In logs of action/frame format the sample just before the scan has the scan's own stamp: nothing to
    // wait for.
    if (scan.before >= begin() && sample(scan.before).stamp_ns == scan.stamp_ns)
        return at_sample(scan, scan.before);
    if (scan.before == end() - 1 && scan.stamp_ns > sample(scan.before).stamp_ns) return std::nullopt;
    const std::ptrdiff_t reach = std::max(end() - scan.before, scan.before + 1 - begin());
    for (std::ptrdiff_t distance = 0; distance <= reach; ++distance)
        for (const std::ptrdiff_t first : {scan.before - distance, scan.before + distance}) {
            if (first < begin() || first + 1 >= end()) continue;
            const auto &a = sample(first), &b = sample(first + 1);
            // Where the clock went back, only a scan from just there can lie between the two.
            const bool clock_went_back = b.stamp_ns < a.stamp_ns;
            if (!encloses(a, b, scan.stamp_ns) || (clock_went_back && first != scan.before)) continue;
            return on_segment(scan, first,
                              a.stamp_ns == b.stamp_ns ? 1.0
                                                       : seconds_between(a.stamp_ns, scan.stamp_ns) /
                                                             seconds_between(a.stamp_ns, b.stamp_ns));
        }
    if (may_still_be_enclosed(scan)) return std::nullopt;
    return at_file_neighbour(scan);
}

bool OdometryAtScans::may_still_be_enclosed(const WaitingScan& scan) const {
    const std::ptrdiff_t last = end() - 1, before = std::max(scan.before, begin());
    if (scan.stamp_ns <= sample(last).stamp_ns) return false;
    return last <= before + 1 ||
           distance_s(sample(before).stamp_ns, sample(last).stamp_ns) <= settings_.max_delay_s;
}

/// At the part `u` of the way from sample `first` to the next one, which may not exist if u = 0.
PlacedScan OdometryAtScans::on_segment(const WaitingScan& scan, std::ptrdiff_t first, double u) {
    const OdometrySample& a = sample(first);
    PlacedScan placed;
    placed.scan = scan.scan;
    placed.T_odom_base = a.T_odom_base;
    placed.ticks = a.ticks;
    if (first + 1 >= end()) return placed;

    const OdometrySample& b = sample(first + 1);
    const Segment& segment = segment_from(first);
    placed.velocity = segment.velocity;
    placed.T_odom_base = u == 1 ? b.T_odom_base : segment.T_odom_base * exp_se2(segment.motion * u);
    placed.ticks.reset();
    if (a.ticks && b.ticks)
        placed.ticks =
            WheelTicks{between(a.ticks->left, b.ticks->left, u), between(a.ticks->right, b.ticks->right, u)};
    return placed;
}

const OdometryAtScans::Segment& OdometryAtScans::segment_from(std::ptrdiff_t first) {
    if (segment_.first == first) return segment_;
    const auto &a = sample(first), &b = sample(first + 1);
    segment_.first = first;
    segment_.T_odom_base = PreparedPose2(a.T_odom_base);
    segment_.motion = log_se2(a.T_odom_base.inverse() * b.T_odom_base);
    segment_.velocity.reset();
    const double duration_s = seconds_between(a.stamp_ns, b.stamp_ns);
    if (duration_s >= shortest_for_velocity_s) segment_.velocity = segment_.motion * (1 / duration_s);
    return segment_;
}

/// With the velocity at which the sample was reached.
PlacedScan OdometryAtScans::at_sample(const WaitingScan& scan, std::ptrdiff_t index) {
    return index > begin() ? on_segment(scan, index - 1, 1) : on_segment(scan, index, 0);
}

/// At whichever of the samples just before and just after it in the log has the nearer stamp.
PlacedScan OdometryAtScans::at_file_neighbour(const WaitingScan& scan) {
    const std::ptrdiff_t before = std::clamp(scan.before, begin(), end() - 1);
    const std::ptrdiff_t after = std::clamp(scan.before + 1, begin(), end() - 1);
    const double to_before_s = distance_s(sample(before).stamp_ns, scan.stamp_ns);
    const double to_after_s = distance_s(sample(after).stamp_ns, scan.stamp_ns);
    PlacedScan placed = at_sample(scan, to_before_s <= to_after_s ? before : after);
    if (std::min(to_before_s, to_after_s) > 0) placed.by = PlacedScan::By::file_order;
    return placed;
}

/// Samples that no scan to come, and none that waits, may refer to: those farther than max_delay_s from the
/// latest one. Two always stay, for a velocity.
void OdometryAtScans::forget_old_samples() {
    while (samples_.size() > 2 &&
           distance_s(samples_.front().stamp_ns, samples_.back().stamp_ns) > settings_.max_delay_s &&
           (scans_.empty() || begin() + 1 < scans_.front().before)) {
        samples_.pop_front();
        ++forgotten_;
    }
}

}  // namespace loopline
