/// Sensor "gnss": a receiver with an antenna on the roof.
#pragma once

#include <optional>

#include "gnss/geo_reference.h"
#include "simulation/gnss_errors.h"
#include "simulation/gnss_sky.h"
#include "simulation/sensor.h"

namespace loopline::simulation {

/// CObservationGPS. Its stamp is when the antenna was there; it comes, and stands in the log, later by the
/// latency. Without a fix there is one of quality 0.
class GnssSensor : public Sensor {
 public:
    std::string name() const override { return "gnss"; }
    ParameterTable parameters() override;
    std::string check() const override { return sky_.check(); }
    void start(const Scene& scene) override;
    StampNs next_time_ns() const override { return received_ns_; }
    mrpt::obs::CObservation::Ptr next() override;
    std::vector<TruthRow> truth() const override { return truth_; }
    std::string summary() const override;

    /// Of the map, as the parameters say.
    gnss::GeoReference geo_reference() const {
        return {{latitude_deg_, longitude_deg_, height_m_}, heading_deg_};
    }

 private:
    enum class Stamp { epoch, reception };

    StampNs epoch_ns() const { return sample_time_ns(index_, rate_hz_); }
    void await_next();
    Eigen::Vector3d p_map_antenna_m(StampNs time_ns) const;
    gnss::FixQuality quality_at(StampNs time_ns);
    gnss::GnssFix fix_at(StampNs time_ns, gnss::FixQuality quality) const;

    double rate_hz_ = 5;
    double latency_s_ = 0.12, latency_spread_s_ = 0.03;
    Stamp stamp_ = Stamp::epoch;
    Eigen::Vector3d p_base_antenna_m_{-0.6, 0.25, 1.6};
    double latitude_deg_ = 49.0116, longitude_deg_ = 8.4166, height_m_ = 163, heading_deg_ = 35;
    double geoid_separation_m_ = 48;
    double reported_sigma_factor_ = 1;
    GnssSky sky_;
    GnssErrorSettings error_settings_;

    const Scene* scene_ = nullptr;
    gnss::GeoReference reference_;
    std::optional<GnssErrors> errors_;
    std::optional<RandomStream> delays_;
    std::vector<double> ways_m_;  ///< at the end of each step
    std::int64_t index_ = 0;
    StampNs received_ns_ = 0;
    std::optional<StampNs> lost_ns_;  ///< when there was no fix, last
    std::size_t count_of_[9] = {};    ///< fixes of each quality
    std::vector<TruthRow> truth_;
};

}  // namespace loopline::simulation
