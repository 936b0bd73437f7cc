/// Errors of a GNSS receiver's positions: white and correlated noise by the kind of fix, and multipath, which
/// makes a position jump while the receiver believes in it.
#pragma once

#include <Eigen/Core>

#include "gnss/gnss_fix.h"
#include "simulation/random_stream.h"

namespace loopline::simulation {

/// Of east and of north each; the height's is `vertical_factor` times that.
struct PositionNoise {
    double white_m = 0;
    double correlated_m = 0;   ///< a Gauss-Markov process
    double correlation_s = 1;  ///< its time constant
};

struct GnssErrorSettings {
    PositionNoise fixed{0.01, 0.004, 60}, floating{0.02, 0.3, 120}, single{0.3, 2, 45};
    double vertical_factor = 2;
    double velocity_mps = 0.03;  ///< of east and of north each, white

    double multipath_per_min = 0;  ///< jumps that begin in a minute, on the average
    double multipath_m = 15;       ///< size of one, about
    double multipath_s = 4;        ///< how long it lasts on the average, at least half a second
    double multipath_noticed = 0;  ///< part of them in which the receiver falls back to a single fix
};

/// What happens at one fix. Each draws the same number of random numbers, whatever the kind of fix is, so
/// that another schedule of fixes changes no noise.
class GnssErrors {
 public:
    GnssErrors(const GnssErrorSettings& settings, double rate_hz, std::uint64_t seed);

    /// Goes on to the next fix.
    void advance();

    Eigen::Vector3d position_enu_m(gnss::FixQuality quality) const;  ///< without multipath
    Eigen::Vector3d velocity_enu_mps() const { return settings_.velocity_mps * velocity_; }
    /// Standard deviations of position_enu_m().
    Eigen::Vector3d sigma_enu_m(gnss::FixQuality quality) const;
    const Eigen::Vector3d& multipath_enu_m() const { return multipath_enu_m_; }  ///< 0: there is none
    bool multipath_noticed() const { return multipath_noticed_; }
    /// Satellites in view, a number that wanders about that of the kind of fix; 0 without a fix.
    int satellites(gnss::FixQuality quality) const;

 private:
    const PositionNoise& noise_of(gnss::FixQuality quality) const;
    std::size_t process_of(gnss::FixQuality quality) const;
    Eigen::Vector3d drawn();
    void advance_multipath();

    GnssErrorSettings settings_;
    double interval_s_;
    RandomStream noise_, jumps_;
    Eigen::Vector3d white_, velocity_;
    Eigen::Vector3d correlated_[3];  ///< fixed, floating, single; of variance 1
    double sky_ = 0;                 ///< of variance 1
    double jump_ends_s_ = 0, now_s_ = 0;
    Eigen::Vector3d multipath_enu_m_ = Eigen::Vector3d::Zero();
    bool multipath_noticed_ = false;
};

/// Dilution of precision by so many satellites: with four just enough, with twenty 0.5.
double hdop_of(int satellites);
double vdop_of(int satellites);

}  // namespace loopline::simulation
