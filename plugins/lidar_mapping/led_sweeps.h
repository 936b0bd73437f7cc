/// Sweeps of spinning lidars on their way to a module that matches them: read from observations, and held
/// until the odometry that leads, if there is one, has come to their time.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/module.h"
#include "lidar/observation_scan.h"
#include "lidar_mapping/published_odometry.h"

namespace loopline::lidar_mapping {

struct LedSweepsSettings {
    std::vector<std::string> sensors;  ///< labels of the lidars; empty for all
    lidar::SweepConvention cloud_sweep;
    PublishedOdometrySettings odometry;

    void declare_sensors(ParameterTable& table);
    void declare_odometry(ParameterTable& table);
    void declare_cloud_sweep(ParameterTable& table);
    /// Adds the classes of the odometry's poses to what a module uses.
    void use(ModuleInfo& info) const;
};

class LedSweeps {
 public:
    struct Sweep {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        mrpt::Clock::time_point timestamp;
        lidar::SpinningScan scan;

        /// After the scan's stamp.
        double middle_s() const { return (scan.begin_s + scan.end_s) / 2; }
        StampNs middle_ns() const;
    };
    using Follow = std::function<void(const Sweep&)>;

    explicit LedSweeps(const LedSweepsSettings& settings)
        : sensors_(settings.sensors), reader_(settings.cloud_sweep), odometry_(settings.odometry) {}

    /// Calls `follow` with each sweep whose turn has come.
    void take(const StreamItem& item, const Follow& follow);
    /// End of the log.
    void drain(const Follow& follow);

    /// By the odometry; none if there is none, or nothing to count from.
    std::optional<GivenMotion> motion(std::optional<StampNs> from_ns, StampNs to_ns) const {
        return from_ns && odometry_.wanted() ? odometry_.motion(*from_ns, to_ns) : std::nullopt;
    }
    void forget_before(StampNs stamp_ns) { odometry_.forget_before(stamp_ns); }
    bool odometry_never_came() const { return odometry_.wanted() && odometry_.taken() == 0; }
    /// Observations of such a lidar that can't be read.
    std::int64_t unusable() const { return unusable_; }

 private:
    template <class Archive>
    friend void fields(Archive&, LedSweeps&);
    std::vector<std::string> sensors_;
    lidar::SpinningScanReader reader_;
    PublishedOdometry odometry_;
    Sweep now_;
    bool waits_ = false;  ///< the sweep in now_
    std::int64_t unusable_ = 0;
};

}  // namespace loopline::lidar_mapping
