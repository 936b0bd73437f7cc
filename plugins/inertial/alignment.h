/// Initial alignment from a standstill: which way is up, and what the gyros read when nothing turns.
#pragma once

#include <cstddef>
#include <deque>
#include <string>

#include "api/pose2.h"
#include "inertial/error_state.h"

namespace loopline::inertial {

struct AlignmentSettings {
    double duration_s = 2;  ///< of standstill that is needed
    /// Largest standard deviation of one axis at rest; a vehicle that rolls shakes by more.
    double still_gyro_radps = 0.02;
    double still_accelerometer_mps2 = 0.25;
    double largest_gyro_bias_radps = 0.1;         ///< a steady rate above is a turn and no bias
    double gravity_tolerance_mps2 = 0.5;          ///< of the mean specific force from gravity
    double sigma_accelerometer_bias_mps2 = 0.05;  ///< of one start to the next: it tilts the horizon
    double sigma_position_m = 1e-3;
    double sigma_velocity_mps = 5e-3;
    double sigma_heading_rad = 1e-3;
};

/// Mean and spread of readings.
struct ImuMean {
    std::size_t count = 0;
    double duration_s = 0;
    StampNs latest_ns = 0;
    Eigen::Vector3d omega_base_radps = Eigen::Vector3d::Zero();
    Eigen::Vector3d omega_sigma_radps =
        Eigen::Vector3d::Zero();  ///< standard deviation of one reading, per axis
    Eigen::Vector3d specific_force_base_mps2 = Eigen::Vector3d::Zero();
    Eigen::Vector3d specific_force_sigma_mps2 = Eigen::Vector3d::Zero();
};

/// Whether nothing shakes or turns. A steady straight motion looks the same: where there are wheels, ask them
/// too.
bool stands_still(const ImuMean& mean, const AlignmentSettings& settings);

enum class AlignmentStatus { aligned, too_short, moving, turning, wrong_gravity };
/// A clause to put after "no alignment: ", with what to do.
std::string words(AlignmentStatus status);

struct Alignment {
    AlignmentStatus status = AlignmentStatus::too_short;
    NavigationState state;  ///< at the last reading; valid if aligned
    /// Of its error. Tilt and accelerometer bias go together: what the bias pretends, the tilt has taken.
    ErrorMatrix covariance = ErrorMatrix::Zero();
    double gravity_mps2 = 0;  ///< length of the mean specific force
    bool aligned() const { return status == AlignmentStatus::aligned; }
};

/// Where the vehicle stands is given, heading included: gravity does not tell it. The accelerometer's biases
/// are taken for zero.
Alignment align(const ImuMean& mean, const Pose2& T_map_base, const Mechanisation& mechanisation,
                const AlignmentSettings& settings);

/// The readings of the last `duration_s`.
class StandstillWindow {
 public:
    explicit StandstillWindow(double duration_s) : duration_s_(duration_s) {}

    /// A stamp that goes backwards starts the window anew.
    void add(const ImuSample& sample);
    ImuMean mean() const;
    void clear() { samples_.clear(); }

 private:
    template <class Archive>
    friend void fields(Archive&, StandstillWindow&);
    double duration_s_;
    std::deque<ImuSample> samples_;
};

/// For checkpoints: api/state_archive.h.
template <class Archive>
void fields(Archive& archive, StandstillWindow& window) {
    archive.each(window.samples_, [](auto& a, ImuSample& s) {
        a(s.stamp_ns, s.omega_base_radps, s.specific_force_base_mps2);
    });
}

}  // namespace loopline::inertial
