/// Wheels, steering, an IMU and landmarks out of tables, number by number.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationBearingRange.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <cmath>

#include "support/csv_import.h"

using namespace loopline;
using namespace loopline::csv;
using test::CsvImport;

TEST_F(CsvImport, odometry_has_pose_and_velocity) {
    folder.write("o.csv", "t,x_cm,y,h,v,w\n10.5,100,2,90,36,-180\n10.6,150,2,450,18,0\n");
    const auto log = import(
        "[wheels]\nkind = odometry\nfile = o.csv\ntime = t\nx = x_cm in cm\ny = y\nyaw = h in deg\n"
        "speed = v in km/h\nturn_rate = w in deg/s\n");
    EXPECT_EQ(log.summary, "2 of wheels, over 0.1 s");
    const auto first = log.at<mrpt::obs::CObservationOdometry>(0);
    EXPECT_EQ(first->sensorLabel, "wheels");
    EXPECT_EQ(log.stamp_ns(0), 10'500'000'000);
    EXPECT_DOUBLE_EQ(first->odometry.x(), 1);
    EXPECT_DOUBLE_EQ(first->odometry.y(), 2);
    EXPECT_DOUBLE_EQ(first->odometry.phi(), M_PI / 2);
    EXPECT_TRUE(first->hasVelocities);
    EXPECT_DOUBLE_EQ(first->velocityLocal.vx, 10);
    EXPECT_EQ(first->velocityLocal.vy, 0);
    EXPECT_DOUBLE_EQ(first->velocityLocal.omega, -M_PI);
    EXPECT_NEAR(log.at<mrpt::obs::CObservationOdometry>(1)->odometry.phi(), M_PI / 2, 1e-12);

    folder.write("o.csv", "t x y qw qx qy qz\n1 0 0 0.8 0 0 -0.6\n");
    const auto turned = import(
        "[wheels]\nkind = odometry\nfile = o.csv\ntime = t\nx = x\ny = y\nqw = qw\nqx = qx\nqy = qy\nqz = "
        "qz\n");
    const auto only = turned.at<mrpt::obs::CObservationOdometry>(0);
    EXPECT_NEAR(only->odometry.phi(), -2 * std::asin(0.6), 1e-12);
    EXPECT_FALSE(only->hasVelocities);
}

TEST_F(CsvImport, steering_is_added_up_along_a_circle) {
    // a quarter turn to the right about a point 10 m away, at 2 m/s of the middle; the wheel is 0.76 m left
    // of it
    std::string rows = "t,v,a\n";
    const double turn_radps = -0.2, wheel_mps = 2 + 0.2 * 0.76, angle_deg = -std::atan(0.283) * 180 / M_PI;
    const double end_s = M_PI / 2 / 0.2;
    for (int i = 0; i <= 100; ++i)
        rows += seconds_text(static_cast<StampNs>(std::llround(end_s * i * 1e7))) + "," +
                number_text(wheel_mps) + "," + number_text(15 * angle_deg + 3) + "\n";
    folder.write("car.csv", rows);
    const auto log = import(
        "[car]\nkind = steering\nfile = car.csv\ntime = t\nspeed = v\nsteering = a in deg\n"
        "steering_ratio = 15\nsteering_offset_deg = 3\nwheel_base_m = 2.83\nencoder_left_m = 0.76\n");
    ASSERT_EQ(log.observations.size(), 101u);
    const auto last = log.at<mrpt::obs::CObservationOdometry>(100);
    EXPECT_NEAR(last->odometry.x(), 10, 1e-7);
    EXPECT_NEAR(last->odometry.y(), -10, 1e-7);
    EXPECT_NEAR(last->odometry.phi(), -M_PI / 2, 1e-8);
    EXPECT_NEAR(last->velocityLocal.vx, 2, 1e-12);
    EXPECT_NEAR(last->velocityLocal.omega, turn_radps, 1e-12);

    EXPECT_NE(problems("[car]\nkind = steering\nfile = car.csv\ntime = t\nspeed = v\nsteering = a in rad\n"
                       "wheel_base_m = 2.83\n")
                  .find("no line of car.csv gives all that [car] in map.ini asks for"),
              std::string::npos);
}

TEST_F(CsvImport, landmarks_of_one_time_are_one_scan) {
    folder.write("trees.csv", "t,r,b,d\n1,10,90,0.5\n1,20,-45,0.25\n1.2,7,10,0\n1.2,-1,10,0\n1.4,5,350,1\n");
    const auto log = import(
        "[trees]\nkind = landmarks\nfile = trees.csv\ntime = t\nrange = r\nbearing = b in deg\ndiameter = d\n"
        "x_m = 3.5\nyaw_deg = -90\n");
    ASSERT_EQ(log.observations.size(), 3u);
    const auto first = log.at<mrpt::obs::CObservationBearingRange>(0);
    EXPECT_EQ(log.stamp_ns(0), 1'000'000'000);
    ASSERT_EQ(first->sensedData.size(), 2u);
    EXPECT_FLOAT_EQ(first->sensedData[0].range, 10.25F) << "to the middle of the trunk";
    EXPECT_FLOAT_EQ(first->sensedData[1].range, 20.125F);
    EXPECT_FLOAT_EQ(first->sensedData[1].yaw, float(-45 * M_PI / 180));
    EXPECT_EQ(first->sensedData[0].landmarkID, -1);
    EXPECT_DOUBLE_EQ(first->sensorLocationOnRobot.x(), 3.5);
    EXPECT_NEAR(first->sensorLocationOnRobot.yaw(), -M_PI / 2, 1e-12);
    EXPECT_EQ(log.at<mrpt::obs::CObservationBearingRange>(1)->sensedData.size(), 1u);
    EXPECT_FLOAT_EQ(log.at<mrpt::obs::CObservationBearingRange>(2)->sensedData[0].yaw,
                    float(-10 * M_PI / 180));
    EXPECT_NE(log.warnings.find("[trees]: 1 line has a range or a diameter that can't be and is left out"),
              std::string::npos)
        << log.warnings;
    EXPECT_NE(problems("[trees]\nkind = landmarks\nfile = trees.csv\ntime = t\nrange = r\n")
                  .find("[trees] bearing is missing; name the column that holds it"),
              std::string::npos);
}

TEST_F(CsvImport, wheels_are_merged_with_an_imu_by_time_and_lines_that_are_damaged_are_left_out) {
    folder.write("w.csv", "t,l,r\n1,1,2\n2,nan,2\n3,1\n4,1,inf\n5,1,2\n");
    folder.write("i.csv", "t,x,y,z\n0.5,1,2,3\n1,4,5,6\n4.5,7,8,9\n4.4,7,8,9\n");
    const auto log = import(
        "[wheels]\nkind = wheels\nfile = w.csv\ntime = t\nleft = l\nright = r\ntrack_width_m = 2\n"
        "[imu]\nkind = imu\nfile = i.csv\ntime = t\nturn_rate_x = x in deg/s\nturn_rate_y = y in "
        "rad/s\nturn_rate_z = z in rad/s times -1\nacceleration_x = x in g\nacceleration_y = "
        "y\nacceleration_z = z\n"
        "x_m = 0.5\nyaw_deg = -90\nroll_deg = 90\n");
    std::string order;
    for (const auto& observation : log.observations) order += observation->sensorLabel + " ";
    EXPECT_EQ(order, "imu wheels imu imu imu wheels ") << "of equal times, the section first in the map";
    EXPECT_NE(
        log.warnings.find("w.csv:3: the first of 3 lines that lack a number of [wheels] and are left out"),
        std::string::npos)
        << log.warnings;
    EXPECT_NE(log.warnings.find("the times of [imu] go back 1 time; the file's order is kept"),
              std::string::npos);
    const auto imu = log.at<mrpt::obs::CObservationIMU>(0);
    EXPECT_DOUBLE_EQ(imu->get(mrpt::obs::IMU_WX), M_PI / 180);
    EXPECT_DOUBLE_EQ(imu->get(mrpt::obs::IMU_WY), 2);
    EXPECT_DOUBLE_EQ(imu->get(mrpt::obs::IMU_WZ), -3);
    EXPECT_DOUBLE_EQ(imu->get(mrpt::obs::IMU_X_ACC), 9.80665);
    EXPECT_DOUBLE_EQ(imu->get(mrpt::obs::IMU_Z_ACC), 3);
    EXPECT_FALSE(imu->has(mrpt::obs::IMU_ORI_QUAT_W));
    // Its y axis points up, its x axis right.
    mrpt::math::TPoint3D up, right;
    imu->sensorPose.composePoint(mrpt::math::TPoint3D(0, 1, 0), up);
    imu->sensorPose.composePoint(mrpt::math::TPoint3D(1, 0, 0), right);
    EXPECT_NEAR(std::hypot(up.x - 0.5, up.y, up.z - 1), 0, 1e-12);
    EXPECT_NEAR(std::hypot(right.x - 0.5, right.y + 1, right.z), 0, 1e-12);
    const auto wheels = log.at<mrpt::obs::CObservationOdometry>(5);
    EXPECT_NEAR(wheels->odometry.phi(), 2.0, 1e-12) << "(2 - 1) / 2 rad/s for 4 s";
}

TEST_F(CsvImport, a_stamp_far_ahead_holds_up_nothing_behind_it) {
    folder.write("w.csv", "t,l,r\n1,1,1\n2,1,1\n3,1,1\n4,1,1\n");
    folder.write("i.csv", "t,x\n1.5,1\n100000,2\n2.5,3\n3.5,4\n");
    const auto log = import(
        "[wheels]\nkind = wheels\nfile = w.csv\ntime = t\nleft = l\nright = r\ntrack_width_m = 2\n"
        "[imu]\nkind = imu\nfile = i.csv\ntime = t\nturn_rate_x = x in rad/s\nturn_rate_y = x in rad/s\n"
        "turn_rate_z = x in rad/s\nacceleration_x = x\nacceleration_y = x\nacceleration_z = x\n");
    std::string order;
    for (const auto& observation : log.observations) order += observation->sensorLabel + " ";
    EXPECT_EQ(order, "wheels imu wheels imu imu wheels imu wheels ");
}

TEST_F(CsvImport, accelerations_of_another_table_are_interpolated) {
    folder.write("g.csv", "t,x,y,z\n0.99,0,0,0\n1,0,0,0\n1.025,0,0,0\n1.1,0,0,0\n1.2,0,0,0\n2,0,0,0\n");
    folder.write("a.csv", "at,x,y,z\n1000,0,1,10\n1100,4,1,20\n1900,4,1,20\n");
    const auto log = import(
        "[imu]\nkind = imu\nfile = g.csv\ntime = t\nturn_rate_x = x in rad/s\nturn_rate_y = y in rad/s\n"
        "turn_rate_z = z in rad/s\nacceleration_file = a.csv\nacceleration_time = at in ms\nacceleration_x = "
        "x\n"
        "acceleration_y = y\nacceleration_z = z\n");
    ASSERT_EQ(log.observations.size(), 3u);
    const double expected[] = {10, 12.5, 20};
    for (std::size_t i = 0; i < 3; ++i)
        EXPECT_NEAR(log.at<mrpt::obs::CObservationIMU>(i)->get(mrpt::obs::IMU_Z_ACC), expected[i], 1e-12);
    EXPECT_NE(log.warnings.find("[imu]: 3 lines have no accelerations around their time in a.csv"),
              std::string::npos)
        << log.warnings;
}
