#include "survey/sweep_fusion.h"

#include <cmath>

namespace loopline::survey {

StampNs TimedScan::beam_time_ns(std::size_t beam) const {
    if (beams.size() < 2) return first_beam_ns;
    const double along = static_cast<double>(beam) / static_cast<double>(beams.size() - 1);
    const double share = counter_clockwise ? along : 1 - along;
    return first_beam_ns + static_cast<StampNs>(std::llround(1e9 * duration_s * share));
}

ScrewSegment mount_motion(const TimedScan* previous, const TimedScan& scan, const TimedScan* next,
                          double max_gap_s) {
    const auto follows = [max_gap_s](const TimedScan* a, const TimedScan* b) {
        if (a == nullptr || b == nullptr) return false;
        const double gap_s = seconds_between(a->first_beam_ns, b->first_beam_ns);
        return gap_s > 0 && gap_s <= max_gap_s;
    };
    const auto from_to = [](const TimedScan& a, const TimedScan& b) {
        return ScrewSegment(a.first_beam_ns, a.T_base_sensor, b.first_beam_ns, b.T_base_sensor);
    };
    if (follows(&scan, next)) return from_to(scan, *next);
    if (follows(previous, &scan)) return from_to(*previous, scan);
    return from_to(scan, scan);
}

void fuse(const TimedScan& scan, const ScrewSegment& T_base_sensor, PathSampler& T_map_base,
          const RangeGate& gate, std::vector<Eigen::Vector3f>& points_map, FusionCounts& counts) {
    for (std::size_t beam = 0; beam < scan.beams.size(); ++beam) {
        ++counts.beams;
        if (!scan.beams.has_return(beam)) {
            ++counts.without_return;
        } else if (!gate.lets_pass(scan.beams.ranges_m[beam])) {
            ++counts.out_of_range;
        } else {
            const StampNs time_ns = scan.beam_time_ns(beam);
            const auto pose = T_map_base.at(time_ns, scan.sequence);
            if (!pose) {
                ++counts.without_pose;
                continue;
            }
            const Eigen::Vector2d p_plane = scan.beams.point_sensor_m(beam);
            const Eigen::Vector3d p_base =
                T_base_sensor.at(time_ns) * Eigen::Vector3d(p_plane.x(), p_plane.y(), 0);
            points_map.push_back((*pose * p_base).cast<float>());
        }
    }
}

}  // namespace loopline::survey
