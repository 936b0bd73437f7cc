#include "simulation/laser.h"

#include <algorithm>
#include <cmath>

namespace loopline::simulation {

StampNs Laser::beam_time_ns(int beam) const {
    const double sweep_s = settings_.sweep_part / settings_.rate_hz;
    return static_cast<StampNs>(std::llround(1e9 * sweep_s * beam / std::max(settings_.beams - 1, 1)));
}

double Laser::angle_rad(int beam) const {
    return settings_.field_of_view_rad * (static_cast<double>(beam) / std::max(settings_.beams - 1, 1) - 0.5);
}

Hit Laser::cast(int beam, double off_rad, const RayCaster& world,
                const std::vector<Cylinder>& cylinders) const {
    const double a = angle_rad(beam) + off_rad;
    const Pose3& T_world_sensor = poses_[static_cast<std::size_t>(beam)];
    const Eigen::Vector3d direction = T_world_sensor.rotation * Eigen::Vector3d(std::cos(a), std::sin(a), 0);
    // Beyond the maximum too: a surface just behind it may still be measured just before it.
    return world.cast(T_world_sensor.translation_m, direction,
                      settings_.max_range_m + 6 * settings_.sigma_range_m, cylinders);
}

/// A beam has a width. Where its two sides meet different surfaces it may measure a mean of both: "mixed
/// pixels" (Ye, Borenstein 2002, "Characterization of a 2-D laser scanner for mobile robot obstacle
/// negotiation").
double Laser::true_range_m(int beam, const RayCaster& world, const std::vector<Cylinder>& cylinders) {
    const auto i = static_cast<std::size_t>(beam);
    const Hit& middle = hits_[i];
    // An edge within the beam shows as two surfaces on two neighbours: looked at only there.
    const bool edge = (i > 0 && hits_[i - 1].surface != middle.surface) ||
                      (i + 1 < hits_.size() && hits_[i + 1].surface != middle.surface);
    if (!edge || settings_.beam_width_rad <= 0) return middle.range_m;
    const Hit right = cast(beam, -settings_.beam_width_rad / 2, world, cylinders);
    const Hit left = cast(beam, settings_.beam_width_rad / 2, world, cylinders);
    const auto [near, far] = std::minmax({right.range_m, middle.range_m, left.range_m});
    const bool same = right.surface == middle.surface && left.surface == middle.surface;
    if (same || !std::isfinite(far)) return middle.range_m;
    if (far - near > settings_.mixed_gap_m) return near;
    return random_.chance(settings_.mixed_pixels) ? random_.uniform(near, far) : middle.range_m;
}

Beam Laser::measured(double true_range_m) {
    if (random_.chance(settings_.dropouts)) return {0, false};
    const Beam none{settings_.max_range_m, false};
    if (!std::isfinite(true_range_m)) return none;
    double range_m = true_range_m + random_.normal(settings_.sigma_range_m);
    if (settings_.resolution_m > 0)
        range_m = std::round(range_m / settings_.resolution_m) * settings_.resolution_m;
    if (range_m >= settings_.max_range_m) return none;
    if (range_m < settings_.min_range_m) return {0, false};
    return {range_m, true};
}

const std::vector<Beam>& Laser::scan(StampNs start_ns, const PoseAt& T_world_sensor, const RayCaster& world,
                                     const std::vector<Cylinder>& cylinders) {
    poses_.clear();
    hits_.clear();
    beams_.clear();
    for (int beam = 0; beam < settings_.beams; ++beam) {
        poses_.push_back(T_world_sensor(start_ns + beam_time_ns(beam)));
        hits_.push_back(cast(beam, 0, world, cylinders));
    }
    for (int beam = 0; beam < settings_.beams; ++beam)
        beams_.push_back(measured(true_range_m(beam, world, cylinders)));
    return beams_;
}

}  // namespace loopline::simulation
