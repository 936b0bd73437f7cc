#include "simulation/uneven_floor.h"

#include <cmath>

#include "simulation/random_waves.h"

namespace loopline::simulation {
namespace {

constexpr int wave_count = 12;

}  // namespace

UnevenFloor::UnevenFloor(double sigma_tilt_rad, std::uint64_t seed, WaveBand band, std::string_view purpose) {
    RandomStream random(seed, purpose);
    for (int i = 0; i < wave_count; ++i) {
        const double k_per_m = 2 * M_PI / drawn_wavelength(band.shortest_m, band.longest_m, random);
        const double direction_rad = random.uniform(0, 2 * M_PI), phase_rad = random.uniform(0, 2 * M_PI);
        // A wave's slope has the variance (a k)^2 / 2 along it, half of that in a direction at random.
        waves_.push_back({k_per_m * Eigen::Vector2d(std::cos(direction_rad), std::sin(direction_rad)),
                          2 * sigma_tilt_rad / (k_per_m * std::sqrt(static_cast<double>(wave_count))),
                          phase_rad, std::sin(phase_rad)});
    }
}

double UnevenFloor::height_m(const Eigen::Vector2d& place_m) const {
    double sum_m = 0;
    for (const Wave& w : waves_)
        sum_m += w.amplitude_m * (std::sin(w.k_per_m.dot(place_m) + w.phase_rad) - w.sine_of_phase);
    return sum_m;
}

Eigen::Vector2d UnevenFloor::slope(const Eigen::Vector2d& place_m) const {
    Eigen::Vector2d slope = Eigen::Vector2d::Zero();
    for (const Wave& w : waves_)
        slope += w.amplitude_m * std::cos(w.k_per_m.dot(place_m) + w.phase_rad) * w.k_per_m;
    return slope;
}

}  // namespace loopline::simulation
