/// The ways a vehicle is driven: straight, turning left, turning right. Hu, Chen, Zhang 2012, section 3.1:
/// wheels slip differently in each, and a change from one to another makes a prediction over a wide interval
/// wrong.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace loopline::line_slam {

enum class Regime { straight, left, right };
constexpr int regime_count = 3;
constexpr std::array<Regime, regime_count> all_regimes{Regime::straight, Regime::left, Regime::right};

/// What the keys of one regime begin with, as in the paper's dialog, figure 3.
inline const char* regime_key(Regime regime) {
    constexpr const char* keys[regime_count] = {"straight", "turn_left", "turn_right"};
    return keys[static_cast<int>(regime)];
}

/// At the rims, forward positive.
struct WheelSpeed {
    double left_mps = 0;
    double right_mps = 0;
};

/// One column of the paper's dialog, figure 3: what is known of one regime beforehand.
struct RegimeParameters {
    WheelSpeed commanded;  ///< that the motors are told to hold
    double slip_left = 0;  ///< true travel = (1 - slip) x measured
    double slip_right = 0;
    double sigma_left_m = 0;  ///< of the wheel's travel after 1 m; 0: as DriveParameters::sigma_wheel_m says
    double sigma_right_m = 0;
};

using Regimes = std::array<RegimeParameters, regime_count>;

/// Section 3.1.2, "watch the speed": which regime the measured wheel speeds belong to. The difference of the
/// wheels as a part of their sum decides, with hysteresis, so that noise does not change the regime.
class RegimeWatch {
 public:
    /// Once per scan, by mean and difference (right minus left) of the wheel speeds; returns the regime since
    /// that scan.
    Regime watch(double mean_mps, double difference_mps) {
        const double sum_mps = std::max(2 * std::abs(mean_mps), std::abs(difference_mps));
        if (sum_mps < 2 * rest_mps) return regime_;
        const double part = difference_mps / sum_mps;
        const bool turns = std::abs(part) > (regime_ == Regime::straight ? enter_turn : leave_turn);
        regime_ = !turns ? Regime::straight : part > 0 ? Regime::left : Regime::right;
        return regime_;
    }
    Regime regime() const { return regime_; }

 private:
    template <class Archive>
    friend void fields(Archive&, RegimeWatch&);
    static constexpr double enter_turn = 0.4, leave_turn = 0.2;
    static constexpr double rest_mps = 0.005;  // slower than this is standing still, which is no turn
    Regime regime_ = Regime::straight;
};

}  // namespace loopline::line_slam
