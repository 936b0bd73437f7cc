/// Round trips of the trajectory files.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>

#include "commands/command.h"
#include "output/covariance_csv.h"
#include "output/kitti_poses.h"
#include "output/tum.h"
#include "output_test_support.h"

using namespace loopline;
using output_test::content;
using output_test::Folder;
using output_test::random_trajectory;
using output_test::split;

namespace {

Trajectory with_a_pose_that_is_not_finite() {
    Trajectory trajectory = random_trajectory(9, 4);
    Pose3 bad = trajectory.entries()[2].T_map_base;
    bad.translation_m.y() = std::numeric_limits<double>::quiet_NaN();
    Matrix6d bad_covariance = Matrix6d::Identity();
    bad_covariance(3, 1) = std::numeric_limits<double>::infinity();
    trajectory.revise(2, bad, bad_covariance);
    trajectory.finish_revision();
    return trajectory;
}

std::string error_of(const std::filesystem::path& file) {
    try {
        read_tum(file);
    } catch (const CommandError& e) {
        EXPECT_EQ(e.code(), exit_input_data);
        return e.what();
    }
    return "no error";
}

}  // namespace

TEST(OutputTum, every_stamp_and_number_reads_back_to_the_same_bits) {
    const Folder folder;
    const Trajectory trajectory = random_trajectory(50, 1);
    EXPECT_EQ(write_tum(folder / "a.tum", trajectory, Estimate::latest), 0u);
    const auto poses = read_tum(folder / "a.tum");
    ASSERT_EQ(poses.size(), trajectory.size());
    for (std::size_t i = 0; i < poses.size(); ++i) {
        const auto& entry = trajectory.entries()[i];
        EXPECT_EQ(poses[i].stamp_ns, entry.stamp_ns);
        EXPECT_EQ(poses[i].T_map_base.translation_m, entry.T_map_base.translation_m);
        EXPECT_EQ(poses[i].T_map_base.rotation.coeffs(), entry.T_map_base.rotation.coeffs());
    }
}

TEST(OutputTum, columns_are_what_strtod_and_the_eye_read) {
    const Folder folder;
    Trajectory trajectory;
    trajectory.append(0, 1137834225973760001, Pose3(Pose2{1.5, -0.0, M_PI / 2}), Matrix6d::Zero());
    write_tum(folder / "a.tum", trajectory, Estimate::latest);
    const auto lines = split(content(folder / "a.tum"), '\n');
    ASSERT_EQ(lines.size(), 2u);
    EXPECT_EQ(lines[0].front(), '#');
    const auto words = split(lines[1], ' ');
    ASSERT_EQ(words.size(), 8u);
    EXPECT_EQ(words[0], "1137834225.973760001");
    EXPECT_EQ(words[1], "1.5");
    EXPECT_EQ(words[2], "0") << "not -0";
    EXPECT_DOUBLE_EQ(std::strtod(words[6].c_str(), nullptr), std::sin(M_PI / 4));
    EXPECT_DOUBLE_EQ(std::strtod(words[7].c_str(), nullptr), std::cos(M_PI / 4));
}

TEST(OutputTum, online_estimate_is_the_one_before_revisions) {
    const Folder folder;
    Trajectory trajectory = random_trajectory(3, 2);
    const Pose3 before = trajectory.entries()[1].T_map_base;
    trajectory.revise(1, Pose3(Pose2{7, 8, 0}), Matrix6d::Zero());
    trajectory.finish_revision();
    write_tum(folder / "online.tum", trajectory, Estimate::online);
    write_tum(folder / "latest.tum", trajectory, Estimate::latest);
    EXPECT_EQ(read_tum(folder / "online.tum")[1].T_map_base.translation_m, before.translation_m);
    EXPECT_EQ(read_tum(folder / "latest.tum")[1].T_map_base.translation_m, Eigen::Vector3d(7, 8, 0));
}

TEST(OutputTum, poses_that_are_not_finite_are_left_out_and_counted) {
    const Folder folder;
    const Trajectory trajectory = with_a_pose_that_is_not_finite();
    EXPECT_EQ(write_tum(folder / "a.tum", trajectory, Estimate::latest), 1u);
    EXPECT_EQ(write_kitti_poses(folder / "a.kitti", trajectory), 1u);
    EXPECT_EQ(write_covariance_csv(folder / "a.csv", trajectory), 1u);
    EXPECT_EQ(read_tum(folder / "a.tum").size(), 8u);
    for (const char* file : {"a.tum", "a.kitti", "a.csv"}) {
        const std::string text = content(folder / file);
        EXPECT_EQ(text.find("nan"), std::string::npos) << file;
        EXPECT_EQ(text.find("inf"), std::string::npos) << file;
    }
}

TEST(OutputTum, reader_names_file_line_and_what_is_wrong) {
    const Folder folder;
    EXPECT_NE(error_of(folder / "missing.tum").find("missing.tum"), std::string::npos);
    EXPECT_NE(error_of(folder.path()).find("no such file"), std::string::npos) << "a folder is no trajectory";
    const std::string good = "# comment\n\n1 0 0 0 0 0 0 1\n";
    for (const char* bad : {"1 0 0 0 0 0 1", "1 0 0 0 0 0 0 1 9", "x 0 0 0 0 0 0 1", "1 0 nan 0 0 0 0 1",
                            "1 0 inf 0 0 0 0 1", "1 0 0 0 0 0 0 0", "1 0 0,5 0 0 0 0 1"}) {
        std::ofstream(folder / "bad.tum") << good << bad << "\n";
        EXPECT_NE(error_of(folder / "bad.tum").find("bad.tum:4:"), std::string::npos) << bad;
    }
    std::ofstream(folder / "ok.tum") << good << "  1.25e0\t0 0 0 0 0 0 +2e-0 \r\n";
    EXPECT_NE(error_of(folder / "ok.tum").find("no error"), 0u) << "a quaternion of length 2 is none";
    std::ofstream(folder / "ok.tum") << good << "  1.25e0\t0 0 0 0 0 0 +1.001 \r\n";
    const auto poses = read_tum(folder / "ok.tum");
    ASSERT_EQ(poses.size(), 2u);
    EXPECT_EQ(poses[1].stamp_ns, 1'250'000'000);
    EXPECT_DOUBLE_EQ(poses[1].T_map_base.rotation.norm(), 1);
}

TEST(OutputCovariance, header_names_order_and_unit_and_values_read_back) {
    const Folder folder;
    const Trajectory trajectory = random_trajectory(7, 3);
    EXPECT_EQ(write_covariance_csv(folder / "c.csv", trajectory), 0u);
    const auto lines = split(content(folder / "c.csv"), '\n');
    ASSERT_EQ(lines.size(), 8u);
    const auto names = split(lines[0], ',');
    ASSERT_EQ(names.size(), 37u);
    EXPECT_EQ(names[0], "stamp_s");
    EXPECT_EQ(names[1], "cov_x_x_m2");
    EXPECT_EQ(names[6], "cov_x_yaw_m_rad");
    EXPECT_EQ(names[36], "cov_yaw_yaw_rad2");
    for (std::size_t i = 0; i < trajectory.size(); ++i) {
        const auto fields = split(lines[i + 1], ',');
        ASSERT_EQ(fields.size(), 37u);
        EXPECT_EQ(fields[0], seconds_text(trajectory.entries()[i].stamp_ns));
        for (int row = 0; row < 6; ++row)
            for (int column = 0; column < 6; ++column)
                EXPECT_EQ(
                    std::strtod(fields[static_cast<std::size_t>(1 + 6 * row + column)].c_str(), nullptr),
                    trajectory.entries()[i].covariance(row, column));
    }
}

TEST(OutputKitti, twelve_numbers_are_the_transform_row_by_row) {
    const Folder folder;
    const Trajectory trajectory = random_trajectory(6, 5);
    write_kitti_poses(folder / "a.kitti", trajectory);
    std::ifstream in(folder / "a.kitti");
    for (const auto& entry : trajectory.entries()) {
        Eigen::Matrix<double, 3, 4, Eigen::RowMajor> T;
        for (int i = 0; i < 12; ++i) in >> T.data()[i];
        const Eigen::Vector3d p(0.3, -2, 5);
        EXPECT_LT((T * p.homogeneous() - entry.T_map_base * p).norm(), 1e-12 * 1e4);
    }
    double more = 0;
    EXPECT_FALSE(in >> more);
}
