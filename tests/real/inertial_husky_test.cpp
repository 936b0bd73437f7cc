/// The check of IMUs on a real one, of a Clearpath Husky: it is mounted on its side, 30 readings a second,
/// and its stamps are late against those of the odometry.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "inertial/imu_verdict.h"
#include "support/shared_data.h"

using namespace loopline;
using namespace loopline::inertial;

namespace {

const char* const husky_imu = "husky_robot_localization/husky_imu.csv";
const char* const husky_odometry = "husky_robot_localization/husky_wheel_odom.csv";

struct Row {
    StampNs stamp_ns;
    std::vector<double> values;  ///< of the columns after the stamp
};

std::vector<Row> rows_of_csv(const std::filesystem::path& path) {
    std::ifstream file(path);
    std::vector<Row> rows;
    std::string line, word;
    std::getline(file, line);
    while (std::getline(file, line)) {
        std::istringstream words(line);
        std::getline(words, word, ',');
        Row row{*stamp_from_seconds_text(word), {}};
        while (std::getline(words, word, ',')) row.values.push_back(std::stod(word));
        rows.push_back(row);
    }
    return rows;
}

ImuCheck check_of_husky(const Eigen::Matrix3d& R_base_imu) {
    const auto imu = rows_of_csv(test::shared_data() / husky_imu);
    const auto odometry = rows_of_csv(test::shared_data() / husky_odometry);
    ImuCheck check;
    std::size_t next = 0;
    for (const auto& [stamp_ns, v] : imu) {
        for (; next < odometry.size() && odometry[next].stamp_ns <= stamp_ns; ++next) {
            const auto& pose = odometry[next].values;  // x y z qx qy qz qw ...
            check.add_odometry(odometry[next].stamp_ns, {pose[0], pose[1], 2 * std::atan2(pose[5], pose[6])});
        }
        check.add_imu({stamp_ns, {v[4], v[5], v[6]}, {v[7], v[8], v[9]}, R_base_imu});
    }
    return check;
}

std::string all_of(const std::vector<std::string>& sentences) {
    std::string text;
    for (const auto& sentence : sentences) text += sentence + "\n";
    return text;
}

}  // namespace

TEST(HuskyImu, is_found_mounted_as_it_was) {
    NEEDS_SHARED_DATA(husky_imu);
    NEEDS_SHARED_DATA(husky_odometry);
    const ImuCheck check = check_of_husky(Eigen::Matrix3d::Identity());
    const auto said = all_of(imu_complaints(check, "imu", 0));
    EXPECT_NE(
        said.find("feels gravity along its +y axis, (-0.22, 9.79, 0.08) at its mean, and turns with the "
                  "odometry about its +y axis (correlation 0.97): it is mounted turned"),
        std::string::npos)
        << said;
    EXPECT_NE(said.find("yaw_deg = -90, pitch_deg = 0, roll_deg = 90"), std::string::npos) << said;
    EXPECT_NE(said.find("comes at 30 Hz"), std::string::npos) << said;
    EXPECT_NEAR(check.agreement().peak.slope.norm(), 1, 0.02);
}

TEST(HuskyImu, righted_only_its_rate_and_its_stamps_are_left_to_complain_of) {
    NEEDS_SHARED_DATA(husky_imu);
    NEEDS_SHARED_DATA(husky_odometry);
    Eigen::Matrix3d as_mounted;
    as_mounted << 0, 0, -1, -1, 0, 0, 0, 1, 0;
    const ImuCheck check = check_of_husky(as_mounted);
    EXPECT_EQ(imu_complaints(check, "imu", 0).size(), 2u) << all_of(imu_complaints(check, "imu", 0));
    // By a search over delays in steps of 20 ms outside of this program, heading differences correlate best
    // at 0.10 s.
    const auto agreement = check.agreement();
    ASSERT_TRUE(agreement.gyro_later_s);
    EXPECT_NEAR(*agreement.gyro_later_s, 0.096, 0.01);
}
