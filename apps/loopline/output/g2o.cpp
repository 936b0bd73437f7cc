#include "output/g2o.h"

#include <cmath>

#include "output/output_file.h"

namespace loopline {
namespace {

bool pose_is_finite(const Pose2& pose) {
    return std::isfinite(pose.x_m) && std::isfinite(pose.y_m) && std::isfinite(pose.phi_rad);
}

/// Our residual is e = (R_from' (t_to - t_from) - t, turn), along the axes of `from`. g2o's is that of
/// T_from_to^-1 T_from^-1 T_to, so (R' e, turn) with R the rotation of T_from_to: the same e along the axes
/// of the measured `to`. With the information turned likewise, e' information e is the same number.
Eigen::Matrix3d along_axes_of_to(const PoseGraph::Constraint& constraint) {
    const double c = std::cos(constraint.T_from_to.phi_rad), s = std::sin(constraint.T_from_to.phi_rad);
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    R.topLeftCorner<2, 2>() << c, -s, s, c;
    return R.transpose() * constraint.information * R;
}

OutputFile& write_pose(OutputFile& out, const Pose2& pose) {
    return out.number(pose.x_m).character(' ').number(pose.y_m).character(' ').number(pose.phi_rad);
}

void write_edge(OutputFile& out, const PoseGraph::Constraint& constraint) {
    out.text("EDGE_SE2 ").count(constraint.from).character(' ').count(constraint.to).character(' ');
    write_pose(out, constraint.T_from_to);
    const Eigen::Matrix3d information = along_axes_of_to(constraint);
    for (int row = 0; row < 3; ++row)
        for (int column = row; column < 3; ++column) out.character(' ').number(information(row, column));
    out.character('\n');
}

}  // namespace

std::size_t write_g2o(const std::filesystem::path& file, const PoseGraph& graph) {
    OutputFile out(file);
    std::size_t left_out = 0;
    for (std::size_t i = 0; i < graph.poses.size(); ++i) {
        if (!pose_is_finite(graph.poses[i])) {
            ++left_out;
            continue;
        }
        out.text("VERTEX_SE2 ").count(i).character(' ');
        write_pose(out, graph.poses[i]).character('\n');
    }
    const auto is_written = [&](std::uint32_t pose) {
        return pose < graph.poses.size() && pose_is_finite(graph.poses[pose]);
    };
    for (const auto& constraint : graph.constraints) {
        if (is_written(constraint.from) && is_written(constraint.to) &&
            pose_is_finite(constraint.T_from_to) && constraint.information.allFinite())
            write_edge(out, constraint);
        else
            ++left_out;
    }
    out.commit();
    return left_out;
}

}  // namespace loopline
