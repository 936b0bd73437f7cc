#include "simulation/uneven_floor.h"

#include <cmath>

#include "simulation/random_waves.h"

namespace loopline::simulation {
namespace {

constexpr int wave_count = 12;
/// What is shorter than its wheelbase a cart does not follow; what is longer is a ramp.
constexpr double shortest_m = 1.5, longest_m = 12;

}  // namespace

Pose3 on_floor(const Pose2& planar, const FloorAttitude& floor) {
    const Eigen::AngleAxisd yaw(planar.phi_rad, Eigen::Vector3d::UnitZ()),
        pitch(floor.pitch_rad, Eigen::Vector3d::UnitY()), roll(floor.roll_rad, Eigen::Vector3d::UnitX());
    return {{planar.x_m, planar.y_m, floor.z_m}, Eigen::Quaterniond(yaw * pitch * roll)};
}

UnevenFloor::UnevenFloor(double sigma_tilt_rad, std::uint64_t seed) {
    RandomStream random(seed, "floor");
    for (int i = 0; i < wave_count; ++i) {
        const double k_per_m = 2 * M_PI / drawn_wavelength(shortest_m, longest_m, random);
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

FloorAttitude UnevenFloor::below(const Pose2& T_floor_base) const {
    const Eigen::Vector2d place_m = T_floor_base.translation();
    Eigen::Vector2d slope = Eigen::Vector2d::Zero();
    for (const Wave& w : waves_)
        slope += w.amplitude_m * std::cos(w.k_per_m.dot(place_m) + w.phase_rad) * w.k_per_m;
    const Eigen::Vector2d ahead(std::cos(T_floor_base.phi_rad), std::sin(T_floor_base.phi_rad));
    const double ahead_slope = slope.dot(ahead), left_slope = -ahead.y() * slope.x() + ahead.x() * slope.y();
    // The x axis rises by the slope ahead; the y axis, turned about it, by that to the left.
    const double pitch_rad = -std::atan(ahead_slope);
    return {height_m(place_m), pitch_rad, std::atan(left_slope * std::cos(pitch_rad))};
}

}  // namespace loopline::simulation
