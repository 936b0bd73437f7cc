#include "simulation/gnss_errors.h"

#include <algorithm>
#include <cmath>

namespace loopline::simulation {

using gnss::FixQuality;

namespace {

constexpr double sky_s = 120;  ///< for how long a number of satellites lasts

/// Part of a Gauss-Markov process that is left after an interval.
double kept(double interval_s, double correlation_s) {
    return std::exp(-interval_s / correlation_s);
}

}  // namespace

GnssErrors::GnssErrors(const GnssErrorSettings& settings, double rate_hz, std::uint64_t seed)
    : settings_(settings),
      interval_s_(1 / rate_hz),
      noise_(seed, "gnss noise"),
      jumps_(seed, "gnss multipath"),
      white_(Eigen::Vector3d::Zero()),
      velocity_(Eigen::Vector3d::Zero()) {
    for (auto& process : correlated_) process = drawn();
    sky_ = noise_.normal(1);
}

Eigen::Vector3d GnssErrors::drawn() {
    const double x = noise_.normal(1), y = noise_.normal(1), z = noise_.normal(1);
    return {x, y, z};
}

const PositionNoise& GnssErrors::noise_of(FixQuality quality) const {
    return quality == FixQuality::rtk_fixed   ? settings_.fixed
           : quality == FixQuality::rtk_float ? settings_.floating
                                              : settings_.single;
}

std::size_t GnssErrors::process_of(FixQuality quality) const {
    return quality == FixQuality::rtk_fixed ? 0 : quality == FixQuality::rtk_float ? 1 : 2;
}

void GnssErrors::advance() {
    now_s_ += interval_s_;
    white_ = drawn();
    velocity_ = drawn();
    const PositionNoise* const noises[] = {&settings_.fixed, &settings_.floating, &settings_.single};
    for (std::size_t i = 0; i < 3; ++i) {
        const double keep = kept(interval_s_, noises[i]->correlation_s);
        correlated_[i] = keep * correlated_[i] + std::sqrt(1 - keep * keep) * drawn();
    }
    const double keep_sky = kept(interval_s_, sky_s);
    sky_ = keep_sky * sky_ + std::sqrt(1 - keep_sky * keep_sky) * noise_.normal(1);
    advance_multipath();
}

void GnssErrors::advance_multipath() {
    const bool begins = jumps_.chance(settings_.multipath_per_min / 60 * interval_s_);
    const double size_m = settings_.multipath_m * jumps_.uniform(0.6, 1.4),
                 direction_rad = jumps_.uniform(0, 2 * M_PI),
                 up_m = settings_.multipath_m * jumps_.uniform(-0.7, 0.7),
                 lasts_s = std::max(0.5, -settings_.multipath_s * std::log(1 - jumps_.uniform()));
    const bool noticed = jumps_.chance(settings_.multipath_noticed);
    const bool is_one = now_s_ < jump_ends_s_;
    if (begins && !is_one) {
        multipath_enu_m_ = {size_m * std::cos(direction_rad), size_m * std::sin(direction_rad), up_m};
        multipath_noticed_ = noticed;
        jump_ends_s_ = now_s_ + lasts_s;
    } else if (!is_one) {
        multipath_enu_m_.setZero();
        multipath_noticed_ = false;
    }
}

Eigen::Vector3d GnssErrors::position_enu_m(FixQuality quality) const {
    const PositionNoise& noise = noise_of(quality);
    Eigen::Vector3d error_m = noise.white_m * white_ + noise.correlated_m * correlated_[process_of(quality)];
    error_m.z() *= settings_.vertical_factor;
    return error_m;
}

Eigen::Vector3d GnssErrors::sigma_enu_m(FixQuality quality) const {
    const PositionNoise& noise = noise_of(quality);
    const double sigma_m = std::hypot(noise.white_m, noise.correlated_m);
    return {sigma_m, sigma_m, settings_.vertical_factor * sigma_m};
}

int GnssErrors::satellites(FixQuality quality) const {
    const double mean = quality == FixQuality::rtk_fixed ? 17 : quality == FixQuality::rtk_float ? 12 : 9;
    if (quality == FixQuality::invalid) return 0;
    return std::clamp(static_cast<int>(std::lround(mean + 2 * sky_)), 4, 40);
}

double hdop_of(int satellites) {
    return 2.1 / std::sqrt(std::max(1, satellites - 3));
}

double vdop_of(int satellites) {
    return 1.6 * hdop_of(satellites);
}

}  // namespace loopline::simulation
