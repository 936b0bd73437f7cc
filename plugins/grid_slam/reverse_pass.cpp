#include "grid_slam/reverse_pass.h"

#include <algorithm>

#include "grid_map/scan_grid.h"

namespace loopline::grid_slam {

PassResult reverse_pass(const MapFrames& map, const std::vector<std::uint32_t>& old_map, const Loop& loop,
                        ReverseNavigation& navigation, const ForwardSettings& settings, double cell_m) {
    grid_map::ScanGridSettings grid_settings;
    grid_settings.cell_m = cell_m;
    grid_settings.free_space = false;
    grid_map::ScanGrid grid(grid_settings);
    for (const std::uint32_t frame : old_map) grid.insert(map.frames[frame], map.poses[frame]);
    grid.insert(map.frames[loop.last], loop.T_map_last);

    PassResult result;
    result.poses.push_back(loop.T_map_last);
    result.covariances.push_back(loop.covariance);
    navigation.start(loop.last, loop.T_map_last, loop.covariance);
    for (std::uint32_t frame = loop.last; frame-- > loop.first;) {
        // 5.2: where the navigation leads back to; 5.1: what the scan says there; 5.3: both.
        const Motion back = navigation.motion_back(frame);
        const Pose2& T_map_after = result.poses.back();
        const Motion there = Motion{T_map_after, Eigen::Matrix3d::Zero()} * back;
        const ForwardMatch match =
            match_forward(grid, map.frames[frame], there.T_before_now, there.covariance, settings);
        navigation.update(match);
        grid.insert(map.frames[frame], match.T_map_base);
        // The error of the pose after it turns the way to this one; what the step adds is its own.
        const Eigen::Matrix3d carried =
            carried_by(match.T_map_base.translation() - T_map_after.translation());
        result.covariances.push_back(carried * result.covariances.back() * carried.transpose() +
                                     match.covariance);
        result.poses.push_back(match.T_map_base);
    }
    std::reverse(result.poses.begin(), result.poses.end());
    std::reverse(result.covariances.begin(), result.covariances.end());
    return result;
}

}  // namespace loopline::grid_slam
