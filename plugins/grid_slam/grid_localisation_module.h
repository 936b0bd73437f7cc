/// Module "grid_localisation": scans with wheel odometry or an IMU in, path in a finished map out.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "api/module.h"
#include "grid_slam/grid_localisation.h"
#include "grid_slam/navigated_scans.h"

namespace loopline {

class GridLocalisationModule : public Module {
    DEFINE_MRPT_OBJECT(GridLocalisationModule, loopline)
 public:
    static constexpr const char* published_label = "grid_localisation";

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
    friend void fields(Archive&, GridLocalisationModule&);
    enum class Start { given, global };
    /// What was known at its time.
    struct OnlinePose {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        Pose2 T_map_base;
    };

    void estimate(const grid_slam::NavigatedScans::Scan& scan, Publisher& publisher);
    void lay_out_trajectory();
    void report_start(Results& results) const;
    void report_lost(Results& results) const;
    void judge(Results& results) const;
    double share_matched() const;
    double since_first_s(std::size_t scan) const;

    grid_slam::LocalisationSettings settings_;
    std::string map_path_;
    Start start_ = Start::given;
    double cell_m_ = 0.05;
    double min_matched_ = 0.3;
    std::unique_ptr<grid_slam::FrozenMap> map_;

    // The state: all that a break between two scans must keep.
    std::unique_ptr<grid_slam::GridLocalisation> localisation_;
    grid_slam::NavigatedScans scans_;
    std::vector<OnlinePose> online_;

    Trajectory trajectory_;  ///< laid out at the end
};

}  // namespace loopline
