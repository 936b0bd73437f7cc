/// Files of the KITTI datasets beside the scans: times, poses, calibration, and what its GNSS and IMU
/// measured.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "api/pose3.h"
#include "api/stamp.h"

namespace loopline::kitti {

/// A point of a .bin file: metres in the lidar's frame, reflectance 0 .. 1.
struct BinPoint {
    float x_m, y_m, z_m, reflectance;
};

/// The .bin files of a folder, by name: of itself, or of velodyne, velodyne_points/data or data below it.
std::vector<std::filesystem::path> bin_files(const std::filesystem::path& folder);
/// All functions that read throw std::runtime_error, with one sentence, if a file is missing or damaged.
std::vector<BinPoint> read_bin(const std::filesystem::path& file);

/// A time a line: seconds ("4.14e-01", or since 1970), "2011-09-26 13:02:25.964389445" (UTC), or either as
/// the last of several values with commas between them. Lines that are neither at the beginning are a
/// heading.
std::vector<StampNs> read_times(const std::filesystem::path& file);

/// Poses of the camera, as rows of 3 x 4 matrices: the lidar's, by `T_camera_lidar`, from its first on.
std::vector<Pose3> read_lidar_poses(const std::filesystem::path& file, const Pose3& T_camera_lidar);

/// "Tr:" of the odometry benchmark's calib.txt.
Pose3 read_T_camera_lidar(const std::filesystem::path& file);
/// Axes alone: x ahead, y left, z up to x right, y down, z ahead.
Pose3 axes_camera_lidar();

/// A packet of the OXTS unit.
struct Oxts {
    double latitude_deg, longitude_deg, altitude_m;
    Eigen::Vector3d acceleration_mps2, turn_radps;  ///< in the unit's frame: x ahead, y left, z up
    int satellites;
};
Oxts read_oxts(const std::filesystem::path& file);
std::vector<std::filesystem::path> oxts_files(const std::filesystem::path& folder);

/// `name` in the folder of the scans, or in one of the two above it.
std::optional<std::filesystem::path> beside(const std::filesystem::path& scans, const std::string& name);

}  // namespace loopline::kitti
