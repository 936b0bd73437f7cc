/// A spinning lidar's path from each sweep to the next: LOAM's lidar odometry.
#pragma once

#include "lidar_odometry/scan_to_scan.h"

namespace loopline::lidar_odometry {

struct SweepOdometrySettings {
    FeatureSettings features;
    MatchingSettings matching;
    /// How quickly the vehicle's speed and its rates of turn change.
    double sigma_acceleration_mps2 = 3, sigma_turn_radps2 = 1.5;
    /// For the first motion: speeds that are tried, and what is unknown about each.
    double first_speed_step_mps = 3, first_speed_min_mps = -6, first_speed_max_mps = 36;
    double sigma_first_speed_mps = 1, sigma_first_turn_radps = 0.3;
};

/// What a sweep told.
struct OdometryStep {
    MatchedMotion motion;  ///< since the sweep before; nothing in it after the first sweep
    Pose3 T_map_base;      ///< at the sweep's stamp
    Twist3 velocity;       ///< a second, along the vehicle's axes
    /// Of (shift, turn) along the map's axes, about the vehicle: of the motion since the sweep before, and of
    /// the way since the first one. Motions count as independent, though each sweep has a part in two of
    /// them.
    Matrix6d motion_covariance = Matrix6d::Zero(), covariance = Matrix6d::Zero();
};

class SweepOdometry {
 public:
    SweepOdometry(const SweepOdometrySettings& settings, int threads)
        : settings_(settings), workers_(threads) {}

    /// False, and nothing changed, if the sweep is not later than the one before.
    bool add(const lidar::SpinningScan& scan);
    const OdometryStep& latest() const { return step_; }

 private:
    template <class Archive>
    friend void fields(Archive&, SweepOdometry&);
    ExpectedMotion expected(double duration_s) const;
    ExpectedMotion first_expected(const Twist3& velocity, double duration_s) const;
    Twist3 search_first_velocity(double duration_s);
    MatchedMotion match_first(double duration_s);
    void follow(const MatchedMotion& motion, const ExpectedMotion& expected);
    void carry_covariance(const Matrix6d& motion, const Matrix6d& kept, const Eigen::Vector3d& way_m,
                          double duration_s);

    SweepOdometrySettings settings_;
    WorkerPool workers_;
    FeatureFinder finder_;
    ReferenceSweep reference_;
    SweepFeatures now_;

    SweepFeatures before_;  ///< of the latest sweep
    OdometryStep step_;
    Pose3 T_map_middle_;  ///< in the middle of the latest sweep
    /// Of the velocity, a second, along the map's axes; and of the way with it: where the scene leaves a
    /// direction free, an error of the velocity stays, and adds up.
    Matrix6d velocity_covariance_ = Matrix6d::Zero(), way_velocity_ = Matrix6d::Zero();
    std::uint64_t sweeps_ = 0;
    StampNs middle_ns_ = 0;
    double middle_s_ = 0;  ///< after the stamp
};

}  // namespace loopline::lidar_odometry
