/// What a run hands to the writers when the log has ended.
#pragma once

#include <mrpt/serialization/CSerializable.h>

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "api/earth_frame.h"
#include "api/line_map.h"
#include "api/pose2.h"
#include "api/set_aside.h"
#include "api/stamp.h"
#include "api/trajectory.h"

namespace loopline {

/// One flat key of metrics.json.
using MetricValue = std::variant<std::int64_t, double, std::string, bool>;

/// A finished map. The writers know COccupancyGridMap2D, CPointsMap and its children, and CSimpleMap; its
/// name becomes the file name (`map.<name>.*` unless it is the only one of its kind).
struct NamedMap {
    std::string name;
    mrpt::serialization::CSerializable::Ptr map;
    /// A cloud of points in three dimensions, which has files (`map.<name>.*`) and pictures of its own.
    bool survey = false;
};

/// A key of an .ini as a log tells it.
struct CalibratedKey {
    std::string key;  ///< with no value it may stand for several: turn_left_*
    std::optional<double>
        value;  ///< in the key's unit; none: the log does not tell it, and the key is left out
    double standard_error = 0;  ///< of the value; 0: it is no estimate but belongs to the others
    std::string comment;        ///< what the value rests on, or why there is none
};

/// Keys of one section that a log tells, to take the place of those it was run with.
struct Calibration {
    std::string section;
    std::vector<std::string> remarks;  ///< sentences on all of it
    std::vector<CalibratedKey> keys;
};

/// A place where the path was thought to meet itself, and what came of it.
struct LoopDecision {
    StampNs stamp_ns = 0, old_stamp_ns = 0;  ///< of the scan there, and of the earlier one
    double way_m = 0;                        ///< of the vehicle between the two
    double score = 0;                        ///< how well the scans fit the old map there, 0 .. 1
    double rival_score = 0;                  ///< that of the next best place elsewhere, 0 if there is none
    double shift_m = 0, shift_rad = 0;       ///< misclosure: what the vehicle is moved by
    double sigma_m = 0, sigma_rad = 0;       ///< what was uncertain before
    bool accepted = false;
    bool waits = false;  ///< not refused either: it counts once another match agrees
    std::string reason;
};

/// Poses and the constraints between them, as other tools for pose graphs take them.
struct PoseGraph {
    struct Constraint {
        std::uint32_t from = 0, to = 0;
        Pose2 T_from_to;
        Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< on (x, y, phi), along the axes of `from`
    };
    std::vector<Pose2> poses;
    std::vector<Constraint> constraints;
};

/// What closing a loop did to the path. Poses are of the frames that make the map, T_map_base, in the order of the log.
struct PathCorrection {
    StampNs stamp_ns = 0;                 ///< of the scan at which it took effect
    std::uint32_t loop_from = 0, loop_to = 0;  ///< frames that the loop joins: the old one and the late one
    Pose2 T_before_after;                 ///< misclosure: pose of frame `loop_to` after, seen from the one before
    std::vector<Pose2> before, after;     ///< of all frames up to then
    std::uint32_t reverse_first = 0;      ///< frame of the first pose of `reverse`
    std::vector<Pose2> reverse;           ///< the path found by going back from the loop's end; empty if none was
};

/// Points of many frames, put together when they are asked for. What they are taken from outlives this.
class FramePoints {
 public:
    using Points = std::vector<Eigen::Vector2f>;
    FramePoints() = default;
    FramePoints(std::size_t frames, std::function<Points(std::size_t frame)> points_of)
        : frames_(frames), points_of_(std::move(points_of)) {}
    FramePoints(std::vector<Points> points) : frames_(points.size()) {
        points_of_ = [all = std::move(points)](std::size_t frame) { return all[frame]; };
    }

    std::size_t size() const { return frames_; }
    Points operator[](std::size_t frame) const { return points_of_(frame); }

 private:
    std::size_t frames_ = 0;
    std::function<Points(std::size_t)> points_of_;
};

/// A path beside the result, in the frame of the run's trajectory.
struct NamedPath {
    std::string name;  ///< what it is, as a legend has it: "without fixes"
    std::shared_ptr<const Trajectory> path;
};

/// A place that a receiver said, and what became of it.
struct PlacedFix {
    StampNs stamp_ns = 0;
    /// Of the antenna, in the frame of the run's trajectory; z is NaN where the receiver says no height.
    std::array<double, 3> p_map_m{};
    std::uint64_t fate = 0;  ///< index into PlacedFixes::fates
};

struct PlacedFixes {
    const SetAside<PlacedFix>* list = nullptr;  ///< in the order in which they were decided on; outlives this
    /// The first is that of fixes that were used, the others are reasons why not: "off_the_path".
    std::vector<std::string> fates;

    bool empty() const { return list == nullptr || list->empty(); }
};

struct Results {
    std::map<std::string, MetricValue> metrics;  ///< sorted: the same run writes the same bytes
    std::optional<LineMap> line_map;
    std::vector<NamedMap> maps;
    std::vector<LoopDecision> loops;  ///< in the order of the log
    std::optional<PoseGraph> pose_graph;
    std::optional<EarthFrame> earth;  ///< of the run's trajectory, if it is placed
    std::string earth_by;             ///< name of the module that has placed it; the host's
    /// The path without what the result owes to the sensor that corrects it, for comparison; if any.
    std::optional<NamedPath> uncorrected;
    PlacedFixes fixes;
    std::vector<PathCorrection> corrections;  ///< in the order of the log
    /// Of each frame that makes the map: its returns in the vehicle's frame, to draw the map by other poses.
    FramePoints frame_points_base_m;
    std::vector<Calibration> calibrations;  ///< by modules that can_calibrate(), where the run is for it
    std::vector<std::string> warnings;       ///< sentences on what a user should look at
    /// Set, with one sentence, by a module whose estimate diverged or must be refused: exit code 4.
    std::optional<std::string> refused;
};

}  // namespace loopline
