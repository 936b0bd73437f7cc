/// A spinning lidar's path and local map, sweep after sweep.
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/given_motion.h"
#include "lidar_mapping/registration.h"
#include "lidar_mapping/standstill.h"

namespace loopline::lidar_mapping {

struct SweepMappingSettings {
    SamplingSettings sampling;
    double map_voxel_m = 0.25;                      ///< of the returns that go to the map
    double match_voxel_m = 1;                       ///< of those that are matched
    double map_step_m = 0.75, map_turn_rad = 0.05;  ///< from one sweep that goes to the map to the next
    double forget_every_m = 10;
    double first_speed_step_mps = 2, first_speed_max_mps = 36;  ///< that are tried for the first motion
    MotionNoise motion;
    SurfaceMapSettings map;
    RegistrationSettings registration;
};

class SweepMapping {
 public:
    SweepMapping(const SweepMappingSettings& settings, int threads)
        : settings_(settings), map_(settings.map), workers_(threads) {}

    /// Before the first sweep: the vehicle is known to move, and how fast in the middle of that sweep.
    /// `covariance`: of (v, omega), vehicle's axes.
    void begin_at_speed(const Twist3& velocity, const Matrix6d& covariance);
    /// `given`: the motion since the latest sweep by another odometry, if there is one.
    const Registration& add(const lidar::SpinningScan& scan, const GivenMotion* given = nullptr);
    const Registration& latest() const { return last_; }
    /// Where the vehicle is `duration_s` after the latest sweep, by another odometry, which also tells how
    /// fast it was in the very first one.
    MotionState carried(const GivenMotion& given, double duration_s) const;
    /// Of the latest sweep; none before the first.
    std::optional<StampNs> latest_middle_ns() const {
        return sweeps_ > 0 ? std::optional(last_ns_) : std::nullopt;
    }
    /// Of (shift, turn) of the latest pose in the map of the first sweep, map axes, about the vehicle: the
    /// map is renewed along the way, so each sweep's error adds to those before.
    const Matrix6d& covariance() const { return covariance_; }
    const SurfaceMap& map() const { return map_; }

 private:
    template <class Archive>
    friend void fields(Archive&, SweepMapping&);
    void begin(double middle_s);
    MotionState moving_first(const Twist3& velocity) const;
    MotionState second_after(const MotionState& first, double duration_s) const;
    Twist3 search_first_velocity(double duration_s);
    void follow_first(double duration_s);
    void follow(double duration_s);
    void search_wider(const MotionState& before, double duration_s);
    bool is_away_from_last_added() const;
    void follow_given(double duration_s, const GivenMotion& given);
    void carry_covariance(const Eigen::Vector3d& way_m, const Matrix6d& free_before);
    void add_to_map(const std::vector<SweepPoint>& points, const MotionState& state);
    void forget();

    SweepMappingSettings settings_;
    ScanSampler sampler_;
    SurfaceMap map_;
    WorkerPool workers_;
    std::vector<SweepPoint> points_, matched_;
    std::vector<PlacedReturn> returns_;
    std::vector<SweepPoint> first_;  ///< the first sweep, until its motion is known
    double first_middle_s_ = 0;      ///< its middle, after its stamp
    Registration last_;
    Pose3 added_at_;  ///< of the last sweep that went to the map
    Standstill standstill_;
    double usual_agreement_ = 0;   ///< of the latest sweeps
    bool stands_ = true;           ///< since the first sweep
    bool speed_is_known_ = false;  ///< of the first sweep
    Matrix6d covariance_ = Matrix6d::Zero();
    std::uint64_t sweeps_ = 0;
    StampNs last_ns_ = 0;
    Eigen::Vector3d forgot_at_m_ = Eigen::Vector3d::Zero();
};

}  // namespace loopline::lidar_mapping
