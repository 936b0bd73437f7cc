/// Module "landmark_odometry": landmarks by range and bearing and dead reckoning in, the motion out.
#pragma once

#include <array>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "api/module.h"
#include "api/planar_path.h"
#include "api/pose3_record.h"
#include "api/set_aside.h"
#include "landmark_odometry/landmark_odometry.h"
#include "landmark_odometry/sightings.h"

namespace mrpt::obs {
class CObservationBearingRange;
}

namespace loopline {

/// For every CObservationBearingRange from the second pose of the dead reckoning on it publishes the pose
/// since the first of them, with its covariance, as CObservationRobotPose.
class LandmarkOdometryModule : public Module {
    DEFINE_MRPT_OBJECT(LandmarkOdometryModule, loopline)
 public:
    static constexpr const char* published_label = "landmark_odometry";

    ModuleInfo info() const override;
    ParameterTable parameters() override;
    std::string check() const override;
    void start(const RunContext&) override;
    void process(const StreamItem& item, Publisher& publisher) override;
    void finish(Results& results) override;
    const Trajectory* trajectory() const override { return &trajectory_; }
    bool can_resume() const override { return true; }
    void save_state(mrpt::serialization::CArchive& out) const override;
    void load_state(mrpt::serialization::CArchive& in) override;

 private:
    template <class Archive>
    friend void fields(Archive&, LandmarkOdometryModule&);
    /// A scan that waits for dead reckoning of its time.
    struct Scan {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        mrpt::Clock::time_point timestamp;
        std::vector<landmark_odometry::Sighting> sightings;
    };
    struct Placed {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        Pose3Record T_map_base;
        std::array<double, 36> covariance{};
    };
    void take_landmarks(const StreamItem& item, const mrpt::obs::CObservationBearingRange& observation);
    void take_wheels(const mrpt::obs::CObservation& observation, StampNs stamp_ns);
    void place(const Scan& scan, Publisher& publisher);

    landmark_odometry::LandmarkOdometrySettings settings_;
    landmark_odometry::SightingSettings sightings_;
    std::string sensor_label_, odometry_label_;

    std::unique_ptr<landmark_odometry::LandmarkOdometry> odometry_;
    PlanarPath wheels_;
    std::string wheels_in_use_, label_in_use_;  ///< empty before the first, and where there is no label
    std::deque<Scan> waiting_;
    SetAside<Placed> placed_;
    StampNs last_ns_ = 0;  ///< of the scan placed last
    std::int64_t wheel_poses_ = 0, scans_ = 0, before_wheels_ = 0, backwards_ = 0, other_sensors_ = 0;

    Trajectory trajectory_;  ///< laid out at the end
};

}  // namespace loopline
