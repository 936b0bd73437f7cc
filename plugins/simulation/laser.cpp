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

/// The world as it is when a beam is measured.
void Laser::aim(int beam, StampNs start_ns, const PoseAt& T_world_sensor, const CylindersAt& cylinders_at) {
    const StampNs time_ns = start_ns + beam_time_ns(beam);
    T_world_sensor_ = T_world_sensor(time_ns);
    if (cylinders_at) cylinders_ = cylinders_at(time_ns);
}

Hit Laser::cast(double a_rad, const RayCaster& world) const {
    const Eigen::Vector3d direction =
        T_world_sensor_.rotation * Eigen::Vector3d(std::cos(a_rad), std::sin(a_rad), 0);
    // Beyond the maximum too: a surface just behind it may still be measured just before it.
    return world.cast(T_world_sensor_.translation_m, direction,
                      settings_.max_range_m + 6 * settings_.sigma_range_m, cylinders_);
}

/// An edge within a beam shows as two surfaces on two neighbours.
bool Laser::meets_edge(int beam) const {
    const auto i = static_cast<std::size_t>(beam);
    return settings_.beam_width_rad > 0 &&
           ((i > 0 && hits_[i - 1].surface != hits_[i].surface) ||
            (i + 1 < hits_.size() && hits_[i + 1].surface != hits_[i].surface));
}

/// A beam has a width. Where its two sides meet different surfaces it may measure a mean of both: "mixed
/// pixels" (Ye, Borenstein 2002, "Characterization of a 2-D laser scanner for mobile robot obstacle
/// negotiation").
double Laser::range_at_edge_m(int beam, const RayCaster& world) {
    const Hit& middle = hits_[static_cast<std::size_t>(beam)];
    const Hit right = cast(angle_rad(beam) - settings_.beam_width_rad / 2, world);
    const Hit left = cast(angle_rad(beam) + settings_.beam_width_rad / 2, world);
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
                                     const CylindersAt& cylinders_at) {
    hits_.clear();
    beams_.clear();
    for (int beam = 0; beam < settings_.beams; ++beam) {
        aim(beam, start_ns, T_world_sensor, cylinders_at);
        hits_.push_back(cast(angle_rad(beam), world));
    }
    for (int beam = 0; beam < settings_.beams; ++beam) {
        double range_m = hits_[static_cast<std::size_t>(beam)].range_m;
        if (meets_edge(beam)) {
            aim(beam, start_ns, T_world_sensor, cylinders_at);
            range_m = range_at_edge_m(beam, world);
        }
        beams_.push_back(measured(range_m));
    }
    return beams_;
}

}  // namespace loopline::simulation
