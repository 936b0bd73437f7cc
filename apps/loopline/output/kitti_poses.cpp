#include "output/kitti_poses.h"

#include "output/output_file.h"

namespace loopline {

std::size_t write_kitti_poses(const std::filesystem::path& file, const Trajectory& trajectory) {
    OutputFile out(file);
    std::size_t left_out = 0;
    for (const auto& entry : trajectory.entries()) {
        const Pose3& pose = entry.T_map_base;
        if (!pose.translation_m.allFinite() || !pose.rotation.coeffs().allFinite()) {
            ++left_out;
            continue;
        }
        const Eigen::Matrix3d R_map_base = pose.rotation.toRotationMatrix();
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column) out.number(R_map_base(row, column)).character(' ');
            out.number(pose.translation_m[row]).character(row < 2 ? ' ' : '\n');
        }
    }
    out.commit();
    return left_out;
}

}  // namespace loopline
