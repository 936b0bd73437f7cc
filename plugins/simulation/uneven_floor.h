/// A floor that is not quite level: a random field of heights.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "simulation/ground.h"

namespace loopline::simulation {

/// Lengths of the waves of an UnevenFloor.
struct WaveBand {
    double shortest_m = 1.5, longest_m = 12;  ///< under a cart: shorter than its wheelbase, or a ramp, beyond
};

/// h(p) = sum of a_k (sin(k . p + phase) - sin(phase)): height 0 at the origin of its frame.
class UnevenFloor : public Ground {
 public:
    /// `sigma_tilt_rad`: standard deviation of the slope in any one direction. Floors of one seed with
    /// different purposes are independent.
    UnevenFloor(double sigma_tilt_rad, std::uint64_t seed, WaveBand band = {},
                std::string_view purpose = "floor");

    double height_m(const Eigen::Vector2d& place_m) const override;
    Eigen::Vector2d slope(const Eigen::Vector2d& place_m) const override;

 private:
    struct Wave {
        Eigen::Vector2d k_per_m;
        double amplitude_m, phase_rad, sine_of_phase;
    };
    std::vector<Wave> waves_;
};

}  // namespace loopline::simulation
