/// Module "grid_slam": scans with wheel odometry or an IMU in, path with closed loops out.
#pragma once

#include <memory>

#include "api/loop_closer.h"
#include "api/module.h"
#include "api/set_aside.h"
#include "grid_slam/grid_slam.h"
#include "grid_slam/navigated_scans.h"

namespace loopline {

class GridSlamModule : public Module, public LoopCloser {
    DEFINE_MRPT_OBJECT(GridSlamModule, loopline)
 public:
    static constexpr const char* published_label = "grid_slam";

    ModuleInfo info() const override;
    ParameterTable parameters() override;
    std::string check() const override;
    void start(const RunContext&) override;
    void process(const StreamItem& item, Publisher& publisher) override;
    void drain(Publisher& publisher) override;
    void finish(Results& results) override;
    const Trajectory* trajectory() const override { return &trajectory_; }
    bool can_resume() const override { return true; }
    void save_state(mrpt::serialization::CArchive& out) const override;
    void load_state(mrpt::serialization::CArchive& in) override;

    std::uint64_t loop_at_hand() const override {
        return slam_->loop_at_hand() && !slam_->loop_at_hand_is_refused() ? slam_->loops().size() : 0;
    }
    StampNs loop_at_hand_ns() const override { return slam_->map().stamps_ns.back(); }
    std::string refusals_key() const override { return "refuse_loops"; }
    std::string refusals() const override { return refused_loops_; }
    bool refuse_alike_before(const std::string& a, const std::string& b, StampNs loop_ns) const override;
    std::vector<std::string> loop_warnings() const override;

 private:
    template <class Archive>
    friend void fields(Archive&, GridSlamModule&);
    /// What was known at its time.
    struct OnlinePose {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        Pose2 T_map_base;
    };

    void estimate(const grid_slam::NavigatedScans::Scan& scan, Publisher& publisher);
    void lay_out_trajectory();
    void report_loops(Results& results) const;

    grid_slam::GridSlamSettings settings_;
    bool loops_ = true;
    std::string named_loops_, refused_loops_, without_search_;  ///< as the .ini has them

    // The state: all that a break between two scans must keep.
    std::unique_ptr<grid_slam::GridSlam> slam_;
    grid_slam::NavigatedScans scans_;
    std::unique_ptr<grid_slam::ReverseNavigation>
        reverse_navigation_;  ///< has no state of its own between two scans
    SetAside<OnlinePose> online_;

    Trajectory trajectory_;  ///< laid out at the end
};

}  // namespace loopline
