#include "evaluate/read_trajectory.h"

#include "commands/command.h"
#include "evaluate/text_rows.h"

namespace loopline {
namespace {

StampedPose planar_pose(const TextRow& row) {
    const double phi_rad = row.size() > 3 ? row.number(3) : 0;
    return {row.stamp(0), Pose3(Pose2{row.number(1), row.number(2), phi_rad})};
}

StampedPose kitti_pose(const TextRow& row, std::size_t index) {
    Eigen::Matrix<double, 3, 4> T;
    for (int i = 0; i < 12; ++i) T(i / 4, i % 4) = row.number(static_cast<std::size_t>(i));
    const Eigen::Matrix3d R = T.leftCols<3>();
    if (!(R * R.transpose()).isIdentity(0.01) || R.determinant() < 0)
        row.fail("the first three columns of the 3x4 transform are no rotation");
    return {static_cast<StampNs>(index) * 1'000'000'000, {T.col(3), Eigen::Quaterniond(R).normalized()}};
}

}  // namespace

TrajectoryFile read_trajectory(const std::filesystem::path& file, const std::string& what, Needed needed) {
    std::vector<StampedPose> poses;
    TrajectoryFile trajectory =
        read_trajectory(file, what, needed, [&poses](const StampedPose& pose) { poses.push_back(pose); });
    trajectory.poses = std::move(poses);
    return trajectory;
}

TrajectoryFile read_trajectory(const std::filesystem::path& file, const std::string& what, Needed needed,
                               const std::function<void(const StampedPose&)>& take) {
    TrajectoryFile trajectory;
    std::size_t poses = 0;
    const auto take_pose = [&](const StampedPose& pose) {
        ++poses;
        take(pose);
    };
    const std::size_t columns = columns_of_first_row(file, what);
    trajectory.has_stamps = columns != 12;
    trajectory.has_orientation = columns != 3;
    if (columns == 8) read_tum(file, take_pose);
    const auto take_row = [&](const TextRow& row) {
        if (columns != 4 && columns != 12 && !(columns == 3 && needed == Needed::positions))
            row.fail("a trajectory has 8 columns (TUM), 4 (t x y theta) or 12 (KITTI), this line has " +
                     std::to_string(columns));
        if (row.size() != columns)
            row.fail("this line has " + std::to_string(row.size()) + " columns, the first one has " +
                     std::to_string(columns));
        if (columns <= 4) take_pose(planar_pose(row));
        if (columns == 12) take_pose(kitti_pose(row, poses));
    };
    if (columns != 8) for_each_row(file, what, take_row);
    if (poses == 0)
        throw CommandError(exit_input_data, file.string() + " has no pose in it; give " + what +
                                                " as TUM (t x y z qx qy qz qw), "
                                                "\"t x y theta\" or KITTI poses");
    return trajectory;
}

}  // namespace loopline
