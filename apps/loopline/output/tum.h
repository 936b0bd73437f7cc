/// TUM trajectories: "t x y z qx qy qz qw" a line, seconds with nine decimals, metres, unit quaternion.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <vector>

#include "api/trajectory.h"
#include "output/stamped_path.h"

namespace loopline {

enum class Estimate {
    latest,  ///< after all revisions
    online   ///< what was known at the time
};

/// One line a pose in log order, T_map_base. Returns how many poses were left out because they are not
/// finite.
std::size_t write_tum(const std::filesystem::path& file, const Trajectory& trajectory, Estimate estimate);

/// All poses in file order; lines that are empty or start with "#" are skipped. Quaternions are normalised.
/// Throws CommandError(exit_input_data) with one sentence and file:line if the file is missing or anything in
/// it is not a pose.
std::vector<StampedPose> read_tum(const std::filesystem::path& file);
/// The same, one after the other.
void read_tum(const std::filesystem::path& file, const std::function<void(const StampedPose&)>& take);

}  // namespace loopline
