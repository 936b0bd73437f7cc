/// A path that a real vehicle drove, from a file of KITTI's odometry benchmark.
#pragma once

#include <string>
#include <vector>

#include "api/pose3.h"
#include "simulation/true_motion.h"

namespace loopline::simulation {

struct RecordedPathSettings {
    std::string folder;
    std::string sequence;           ///< "00": FOLDER/00.txt; empty: no recorded path
    double rate_hz = 10;            ///< of its poses
    double camera_height_m = 1.65;  ///< of their origin above the street
    bool level_revisits = true;
    int first = 0, poses = 0;  ///< of the file; 0 poses: all that follow

    std::string file() const { return folder + "/" + sequence + ".txt"; }
    /// In the map frame, which is the first of them. Throws std::runtime_error, with one sentence.
    std::vector<Pose3> read() const;
};

/// Poses of a file in KITTI's format, rows of a 3 x 4 matrix from the camera's axes (x right, y down, z
/// ahead), as poses of a vehicle with its origin where the camera is: x ahead, y left, z up. Throws
/// std::runtime_error, with one sentence.
std::vector<Pose3> read_kitti_poses(const std::string& file);

/// Satellites and integration leave the same crossing at heights that differ by metres from visit to visit.
/// Heights are changed by an amount that varies as slowly along the way as it can while they agree wherever
/// the path comes within a few metres of itself. The rest of the poses stays.
void level_revisits(std::vector<Pose3>& poses);

/// Through all poses at their times, with continuous acceleration: cubic splines of position and quaternion.
/// It goes on for most of an interval after the last pose, so that a sweep that begins there is whole.
TrueMotion motion_through(const std::vector<Pose3>& poses, double rate_hz, StampNs step_ns);

}  // namespace loopline::simulation
