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
#include "gnss/fix_noise.h"
#include "lidar_mapping/led_sweeps.h"

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
    void take_fix(const mrpt::obs::CObservationGPS& gps, StampNs stamp_ns);
    void follow(const lidar_mapping::LedSweeps::Sweep& sweep, Publisher& publisher);
    void report_start(Results& results) const;
    void report_lost(Results& results) const;
    void judge(Results& results) const;
    double share_matched() const;

    cloud_localisation::LocalisationSettings settings_;
    lidar_mapping::LedSweepsSettings led_settings_;
    gnss::FixNoiseSettings fix_noise_;
    std::string map_path_, receiver_;
    Start start_ = Start::gnss;
    double start_x_m_ = 0, start_y_m_ = 0, start_z_m_ = 0, start_yaw_rad_ = 0;
    double latency_s_ = 0, min_matched_ = 0.3;
    std::optional<gnss::GeoReference> georeference_;
    std::unique_ptr<cloud_localisation::FrozenCloud> map_;

    // The state: all that a break between two observations must keep.
    std::unique_ptr<cloud_localisation::CloudLocalisation> localisation_;
    std::unique_ptr<lidar_mapping::LedSweeps> led_;
    cloud_localisation::LocalisedPath path_;
    std::int64_t fixes_ = 0, fixes_usable_ = 0;
    double nearest_fix_m_ = 0;  ///< the least that a fix was off the map

    Trajectory trajectory_;  ///< laid out at the end
};

}  // namespace loopline
