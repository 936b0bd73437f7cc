/// Trajectories of other programs and references, in the text formats of this field.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "output/tum.h"

namespace loopline {

struct TrajectoryFile {
    std::vector<StampedPose> poses;  ///< in file order
    bool has_stamps = true;          ///< false: stamps are the row numbers, in seconds
    bool has_orientation = true;     ///< false: positions alone; the rotations are none
};

enum class Needed { poses, positions };

/// Tells the format by the columns of the first row: 8 = TUM ("t x y z qx qy qz qw"), 4 = planar ("t x y
/// theta", also MRPT's .GT.txt), 12 = KITTI (3x4 transforms, no stamps), and where positions are enough, 3 =
/// tracked positions ("t x y"). `what` says what it should be ("the reference"). Throws
/// CommandError(exit_input_data), one sentence with file:line, if there is no pose in it or a row is wrong.
TrajectoryFile read_trajectory(const std::filesystem::path& file, const std::string& what,
                               Needed needed = Needed::poses);
/// The same, with the poses handed over one after the other instead.
TrajectoryFile read_trajectory(const std::filesystem::path& file, const std::string& what, Needed needed,
                               const std::function<void(const StampedPose&)>& take);

}  // namespace loopline
