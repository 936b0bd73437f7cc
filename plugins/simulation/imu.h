/// A MEMS inertial measurement unit: three gyros and three accelerometers that integrate over each sample
/// interval, with the errors that such units have.
#pragma once

#include <functional>

#include "api/pose3.h"
#include "api/stamp.h"
#include "simulation/random_stream.h"

namespace loopline::simulation {

constexpr double gravity_mps2 = 9.80665;  ///< along -z of the map

/// Errors of three axes of one kind, in the unit of the measurement: rad/s or m/s^2.
struct TriadSettings {
    double noise = 0;        ///< density: standard deviation of the integral after 1 s, unit * sqrt(s)
    double bias = 0;         ///< standard deviation, each axis at turn-on
    double drift = 0;        ///< standard deviation of what wanders about that, a Gauss-Markov process
    double drift_s = 300;    ///< its correlation time
    double scale_error = 0;  ///< standard deviation of each axis' scale factor
    double resolution = 0;   ///< readings are multiples of it; 0: any number
};

struct ImuSettings {
    double rate_hz = 200;
    TriadSettings gyro{0.01 * M_PI / 180, 0.2 * M_PI / 180, 0.01 * M_PI / 180, 300, 0.001,
                       0.004 * M_PI / 180};
    TriadSettings accelerometer{0.0015, 0.03, 0.003, 300, 0.001, 0.0006};
};

/// Of one sample interval, in the axes of the sensor.
struct InertialRates {
    Eigen::Vector3d omega_radps = Eigen::Vector3d::Zero();  ///< rotation vector over the interval, a second
    /// Acceleration minus gravity, mean over the interval: (0, 0, +9.8) at rest on level ground.
    Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Zero();
};

/// Pose of the sensor in a level frame at a time.
using SensorPoseAt = std::function<Pose3(StampNs time_ns)>;

/// What a perfect unit integrates from `from_ns` to `to_ns`. Velocities at both ends are means over
/// `window_ns` before and after, so a path without jumps is enough: it need not have an acceleration at every
/// moment.
InertialRates true_rates(const SensorPoseAt& T_map_sensor, StampNs from_ns, StampNs to_ns, StampNs window_ns);

/// Readings of one triad; draws its errors at turn-on.
class Triad {
 public:
    Triad(const TriadSettings& settings, double rate_hz, RandomStream random);

    /// To be called for sample after sample, with the true mean over the interval.
    Eigen::Vector3d measured(const Eigen::Vector3d& truth);
    /// Turn-on bias and drift as they were in the last sample.
    Eigen::Vector3d bias() const { return turn_on_bias_ + drift_; }
    const Eigen::Vector3d& scale_error() const { return scale_error_; }

 private:
    Eigen::Vector3d drawn(double sigma);

    TriadSettings settings_;
    double keep_;          ///< part of the drift that is left after a sample interval
    double sigma_sample_;  ///< noise of a mean over the interval
    RandomStream random_;
    Eigen::Vector3d turn_on_bias_, scale_error_, drift_;
};

}  // namespace loopline::simulation
