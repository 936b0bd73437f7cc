/// Localisation of a spinning lidar in a finished cloud. Where the place is known, each sweep is matched with
/// the map, as mapping does it, and adds nothing to it. Where it is not, sweeps make a small map of their
/// own, which tells the motion, and each is searched for in the finished map until the place is certain.
#pragma once

#include <deque>
#include <memory>
#include <optional>

#include "api/pose_observation.h"
#include "cloud_localisation/frozen_cloud.h"
#include "cloud_localisation/map_uncertainty.h"
#include "cloud_localisation/start_search.h"
#include "lidar_mapping/sweep_mapping.h"

namespace loopline::cloud_localisation {

struct LocalisationSettings {
    /// Sampling, matching and motion; the map of its own while the place is searched for.
    lidar_mapping::SweepMappingSettings sweeps;
    StartSettings start;
    /// At the first sweep; without one, a fix tells where to look.
    std::optional<Pose3> T_map_start;
    double sigma_start_m = 1, sigma_start_rad = 10 * M_PI / 180;
    double search_every_s = 0.3;
    double agree_m = 0.3, agree_rad = 2 * M_PI / 180;  ///< two looks are one place if they differ by less
    double fix_age_s = 1;                              ///< a fix tells where to look for so long
    /// Part of a sweep's returns from above the ground that are where the map has some, from which on it
    /// fits. The road below fits everywhere.
    double good_fit = 0.5;
    double lost_after_s = 2;  ///< without a sweep that fits
    double max_sigma_m = 1;   ///< nor is the place known if it is so uncertain
    /// Errors of the map, which all sweeps at a place share, beside those of the path that it was drawn by:
    /// of where its surfaces lie, and of their turn.
    double sigma_map_m = 0.005, sigma_map_rad = 0.005 * M_PI / 180;
};

/// What a receiver says of its antenna's place, in the map's frame.
struct FixInMap {
    StampNs stamp_ns = 0;
    Eigen::Vector3d p_map_m = Eigen::Vector3d::Zero();
    bool has_height = false;
    double sigma_m = 0, sigma_z_m = 0;  ///< along each axis of the horizon, and upward
    Eigen::Vector3d p_base_antenna_m = Eigen::Vector3d::Zero();
};

/// Where the vehicle was at a sweep's stamp.
struct LocalisedSweep {
    bool known = false;  ///< else the pose is a guess, or of the frame of the search's own map
    Pose3 T_map_base;
    Matrix6d covariance = Matrix6d::Zero();  ///< of (shift, turn) along the map's axes, about the vehicle
    Pose3 T_local_base;                      ///< while it is searched for: in that frame
    Matrix6d local_covariance = Matrix6d::Zero();  ///< of it
    bool begins_search = false;                    ///< the first sweep of a search
    /// With that: where it was lost, the pose at the stamp as the motion goes on.
    std::optional<PoseWithCovariance> lost_at;
    std::optional<Pose3>
        T_map_local;  ///< the place was found: of that frame, from the first of its sweeps on
};

class CloudLocalisation {
 public:
    /// `map` outlives it.
    CloudLocalisation(const LocalisationSettings& settings, const FrozenCloud& map, int threads,
                      MapUncertainty uncertainty = {});

    /// A fix, in the order of the log.
    void take_fix(const FixInMap& fix);
    /// The next sweep. `given`: the motion since the one before, by another odometry.
    LocalisedSweep add(const lidar::SpinningScan& scan, const lidar_mapping::GivenMotion* given = nullptr);
    std::optional<StampNs> latest_middle_ns() const { return latest_ns_; }

    struct Counts {
        std::int64_t sweeps = 0, matched = 0, unmatched = 0, degenerate = 0, searched = 0, looks = 0,
                     starts = 0, lost = 0, fixes_off = 0, moved_by_fixes = 0;
    };
    const Counts& counts() const { return counts_; }
    bool is_searching() const { return local_ != nullptr; }
    const StartLook& latest_look() const { return look_; }
    /// Mean of that part, of the sweeps that fitted.
    double mean_fit() const {
        return counts_.matched > 0 ? sum_of_fits_ / static_cast<double>(counts_.matched) : 0;
    }

 private:
    template <class Archive>
    friend void fields(Archive&, CloudLocalisation&);
    /// A pose on the way that the vehicle has come lately, in the frame of the map or of the search.
    struct OnTheWay {
        StampNs middle_ns = 0;
        Pose3 T_frame_base;
        Twist3 velocity;
    };
    struct Sighting {
        Pose3 T_local_base, T_map_base;
    };
    /// Where the search's own map may lie in the finished one.
    struct Guess {
        Pose3 T_map_local;
        double sigma_m = 0, sigma_z_m = 0, sigma_yaw_rad = 0;
    };
    bool follow(const lidar_mapping::GivenMotion* given, double duration_s, StampNs middle_ns);
    LocalisedSweep search(const lidar::SpinningScan& scan, const lidar_mapping::GivenMotion* given,
                          StampNs middle_ns);
    lidar_mapping::Registration registered(const lidar_mapping::MotionState& predicted);
    double fit_of(const lidar_mapping::Registration& found) const;
    bool is_certain() const;
    void begin_search(const std::optional<Guess>& guess);
    void lose(double middle_s);
    Guess guess_by_motion(double middle_s) const;
    bool look_is_due(StampNs middle_ns) const;
    bool look(const OnTheWay& now);
    bool agrees(const Sighting& sighting) const;
    std::optional<StartRegion> region_by_guess(const OnTheWay& now) const;
    std::optional<StartRegion> region_by_fix(const OnTheWay& now) const;
    std::optional<Pose3> T_frame_base_at(StampNs stamp_ns) const;
    void remember(const OnTheWay& now);
    void heed_fixes(StampNs middle_ns);
    void compare_with(const FixInMap& fix);
    void ask_for_second_opinion(StampNs middle_ns);
    Matrix6d covariance_of_map(const Eigen::Vector3d& p_map_m) const;
    void put(const lidar_mapping::MotionState& in_middle, double middle_s, LocalisedSweep& result) const;

    LocalisationSettings settings_;
    const FrozenCloud& map_;
    MapUncertainty uncertainty_;
    lidar_mapping::RegistrationSettings registration_;  ///< in the map
    WorkerPool workers_;
    int threads_ = 1;
    lidar_mapping::ScanSampler sampler_;
    std::vector<lidar_mapping::SweepPoint> points_, matched_;  ///< of the sweep at hand

    lidar_mapping::MotionState state_;
    std::optional<StampNs> latest_ns_;
    double unfitting_s_ = 0;  ///< since the latest sweep that fitted
    std::deque<OnTheWay> way_;
    std::deque<FixInMap> fixes_;          ///< that are later than the latest sweep
    std::optional<FixInMap> latest_fix_;  ///< of the others
    int off_in_a_row_ = 0;                ///< fixes that are not where the path is
    StampNs off_since_ns_ = 0;
    std::optional<StampNs> looked_ns_;

    // While the place is searched for.
    std::unique_ptr<lidar_mapping::SweepMapping> local_;
    std::int64_t local_sweeps_ = 0;
    double local_way_m_ = 0;
    std::optional<Guess> guess_;
    std::deque<Sighting> sightings_;
    StartLook look_;  ///< the latest
    Counts counts_;
    double sum_of_fits_ = 0;
};

}  // namespace loopline::cloud_localisation
