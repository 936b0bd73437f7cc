/// A smooth random function of one variable: a sum of sinusoids whose wavelengths lie in a band.
#pragma once

#include <cmath>
#include <vector>

#include "simulation/random_stream.h"

namespace loopline::simulation {

/// A wavelength in a band; each octave of the band has an equal share.
inline double drawn_wavelength(double shortest, double longest, RandomStream& random) {
    return shortest * std::pow(longest / shortest, random.uniform());
}

class RandomWaves {
 public:
    RandomWaves() = default;
    /// Of mean 0 and standard deviation `sigma`; wavelengths in the unit of the variable.
    RandomWaves(double sigma, double shortest, double longest, RandomStream& random) {
        for (int i = 0; i < count; ++i)
            waves_.push_back({sigma * std::sqrt(2.0 / count),
                              2 * M_PI / drawn_wavelength(shortest, longest, random),
                              random.uniform(0, 2 * M_PI)});
    }

    double at(double x) const {
        double sum = 0;
        for (const Wave& w : waves_) sum += w.amplitude * std::sin(w.wave_number * x + w.phase_rad);
        return sum;
    }
    double slope_at(double x) const {
        double sum = 0;
        for (const Wave& w : waves_)
            sum += w.amplitude * w.wave_number * std::cos(w.wave_number * x + w.phase_rad);
        return sum;
    }

 private:
    static constexpr int count = 8;
    struct Wave {
        double amplitude, wave_number, phase_rad;
    };
    std::vector<Wave> waves_;
};

}  // namespace loopline::simulation
