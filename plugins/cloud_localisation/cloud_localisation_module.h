/// Module "cloud_localisation": sweeps of a spinning lidar and fixes in, path in a finished cloud out.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "api/module.h"
#include "api/timed_per.h"
#include "cloud_localisation/cloud_localisation.h"
#include "cloud_localisation/localised_path.h"
#include "cloud_localisation/map_file.h"
#include "fusion/fix_noise.h"
#include "lidar/observation_scan.h"
#include "lidar_mapping/published_odometry.h"

namespace mrpt::obs {
class CObservationGPS;
}

namespace loopline {

class CloudLocalisationModule : public Module, public TimedPerSweep {
    DEFINE_MRPT_OBJECT(CloudLocalisationModule, loopline)
 public:
    static constexpr const char* published_label = "cloud_localisation";

    ModuleInfo info() const override;
    ParameterTable parameters() override;
    std::string check() const override;
    std::vector<std::string> input_files() const override;
    std::string check_input_files() const override;
    void start(const RunContext&) override;
    void process(const StreamItem& item, Publisher& publisher) override;
    void drain(Publisher& publisher) override;
    void finish(Results& results) override;
    const Trajectory* trajectory() const override { return &trajectory_; }
    bool can_resume() const override { return true; }
    void save_state(mrpt::serialization::CArchive& out) const override;
    void load_state(mrpt::serialization::CArchive& in) override;

 private:
    template <class Archive>
    friend void fields(Archive&, CloudLocalisationModule&);
    enum class Start { gnss, given };
    /// A sweep on its way; with an odometry it waits for the pose of its time.
    struct Waiting {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        mrpt::Clock::time_point timestamp;
        lidar::SpinningScan scan;
    };
    void take_fix(const mrpt::obs::CObservationGPS& gps, StampNs stamp_ns);
    void follow(const Waiting& sweep, Publisher& publisher);
    void follow_waiting(Publisher& publisher);
    void report_start(Results& results) const;
    void report_lost(Results& results) const;
    void judge(Results& results) const;
    double share_matched() const;

    cloud_localisation::LocalisationSettings settings_;
    lidar::SweepConvention cloud_sweep_;
    std::vector<std::string> sensors_;  ///< labels; empty for all
    lidar_mapping::PublishedOdometrySettings odometry_settings_;
    fusion::FixNoiseSettings fix_noise_;
    std::string map_path_, receiver_;
    Start start_ = Start::gnss;
    double start_x_m_ = 0, start_y_m_ = 0, start_z_m_ = 0, start_yaw_rad_ = 0;
    double latency_s_ = 0, min_matched_ = 0.3;
    std::optional<gnss::GeoReference> georeference_;
    std::unique_ptr<cloud_localisation::FrozenCloud> map_;
    std::unique_ptr<lidar::SpinningScanReader> reader_;

    // The state: all that a break between two observations must keep.
    std::unique_ptr<cloud_localisation::CloudLocalisation> localisation_;
    std::unique_ptr<lidar_mapping::PublishedOdometry> odometry_;
    cloud_localisation::LocalisedPath path_;
    Waiting now_;
    bool waits_ = false;  ///< the sweep in now_
    std::int64_t unusable_ = 0, fixes_ = 0, fixes_usable_ = 0;
    double nearest_fix_m_ = 0;  ///< the least that a fix was off the map

    Trajectory trajectory_;  ///< laid out at the end
};

}  // namespace loopline
