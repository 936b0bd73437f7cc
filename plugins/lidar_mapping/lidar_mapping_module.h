/// Module "lidar_mapping": sweeps of a spinning lidar in, their path out.
#pragma once

#include <array>
#include <memory>

#include "api/module.h"
#include "api/set_aside.h"
#include "lidar/observation_scan.h"
#include "lidar_mapping/sweep_mapping.h"

namespace loopline {

class LidarMappingModule : public Module {
    DEFINE_MRPT_OBJECT(LidarMappingModule, loopline)
 public:
    static constexpr const char* published_label = "lidar_mapping";

    ModuleInfo info() const override;
    ParameterTable parameters() override;
    void start(const RunContext&) override;
    void process(const StreamItem& item, Publisher& publisher) override;
    void finish(Results& results) override;
    const Trajectory* trajectory() const override { return &trajectory_; }
    bool can_resume() const override { return true; }
    void save_state(mrpt::serialization::CArchive& out) const override;
    void load_state(mrpt::serialization::CArchive& in) override;

 private:
    template <class Archive>
    friend void fields(Archive&, LidarMappingModule&);
    struct Sweep {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        std::array<double, 7> T_map_base{};  ///< x, y, z, qx, qy, qz, qw
        std::array<double, 36> covariance{};
    };
    void publish(const StreamItem& item, const Pose3& T_map_base, const Matrix6d& covariance,
                 Publisher& publisher) const;

    lidar_mapping::SweepMappingSettings settings_;
    lidar::SweepConvention cloud_sweep_;
    std::vector<std::string> sensors_;  ///< labels; empty for all

    std::unique_ptr<lidar::SpinningScanReader> reader_;
    std::unique_ptr<lidar_mapping::SweepMapping> mapping_;
    lidar::SpinningScan scan_;
    SetAside<Sweep> sweeps_;
    std::int64_t unusable_ = 0, degenerate_ = 0;

    Trajectory trajectory_;  ///< laid out at the end
};

}  // namespace loopline
