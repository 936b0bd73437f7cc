/// Column maps: small tables, and the observations that come out of them number by number.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationBearingRange.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <Eigen/Geometry>
#include <cmath>

#include "config/problems.h"
#include "gnss/gps_observation.h"
#include "gnss/local_frame.h"
#include "importers/csv_importer.h"
#include "importers/csv_table.h"
#include "support/run_program.h"

using namespace loopline;
using namespace loopline::csv;

namespace {

constexpr double rad_of_deg = M_PI / 180;

struct Imported : RawlogSink {
    void write(const mrpt::serialization::CSerializable& object) override {
        observations.emplace_back(dynamic_cast<mrpt::obs::CObservation*>(object.clone()));
    }
    void true_pose(StampNs stamp_ns, const Pose3& T_map_base) override {
        truth.emplace_back(stamp_ns, T_map_base);
    }
    void true_frame(const EarthFrame& where) override { frame = where; }
    void warn(const std::string& sentence) override { warnings += sentence + "\n"; }

    template <class Observation>
    std::shared_ptr<Observation> at(std::size_t i) const {
        return std::dynamic_pointer_cast<Observation>(observations.at(i));
    }
    gnss::GnssFix fix(std::size_t i) const {
        const auto gps = at<mrpt::obs::CObservationGPS>(i);
        return gnss::fix_from_mrpt(*gps, *stamp_from_mrpt(gps->timestamp)).value();
    }
    StampNs stamp_ns(std::size_t i) const { return *stamp_from_mrpt(observations.at(i)->timestamp); }

    std::vector<std::shared_ptr<mrpt::obs::CObservation>> observations;
    std::vector<std::pair<StampNs, Pose3>> truth;
    std::optional<EarthFrame> frame;
    std::string warnings, summary;
};

class CsvImport : public ::testing::Test {
 protected:
    Imported import(const std::string& map) {
        CsvImporter importer;
        const auto table = importer.parameters();
        EXPECT_FALSE(table.find("columns")->parse(folder.write("map.ini", map)));
        Imported imported;
        imported.summary = importer.import({folder.path().string()}, imported);
        return imported;
    }
    /// The sentences, of "map.ini:LINE: ..." without the folder.
    std::string problems(const std::string& map) {
        try {
            import(map);
        } catch (const std::runtime_error& e) {
            std::string text = e.what();
            const std::string path = folder.path().string() + "/";
            for (auto at = text.find(path); at != std::string::npos; at = text.find(path))
                text.erase(at, path.size());
            return text;
        }
        return "none";
    }
    test::TemporaryFolder folder;
};

}  // namespace

TEST(CsvColumns, say_name_unit_and_factor) {
    const auto parsed = column_from_text("a wheel in deg times -1", Quantity::angle);
    EXPECT_EQ(parsed.problem, "");
    EXPECT_EQ(parsed.choice.name, "a wheel");
    EXPECT_DOUBLE_EQ(parsed.choice.factor, -rad_of_deg);
    EXPECT_EQ(column_from_text("\"speed in town\" in km/h", Quantity::speed).choice.name, "speed in town");
    EXPECT_DOUBLE_EQ(column_from_text("v in km/h", Quantity::speed).choice.factor, 1 / 3.6);
    EXPECT_EQ(column_from_text("column 3", Quantity::length).choice.number, 2u);
    EXPECT_EQ(column_from_text("v", Quantity::speed).choice.factor, 1);
    EXPECT_EQ(column_from_text("yaw", Quantity::angle).problem,
              "does not say its unit; write \"yaw in deg\" or \"yaw in rad\"");
    EXPECT_EQ(column_from_text("v in kmh", Quantity::speed).problem,
              "is a speed, which can't be in \"kmh\"; did you mean \"km/h\"?");
    EXPECT_EQ(column_from_text("v times fast", Quantity::speed).problem,
              "has no number but 0 behind \"times\": \"fast\"");
    EXPECT_EQ(column_from_text("q in deg", Quantity::number).problem,
              "is a plain number and has no unit; leave \"in deg\" away");
}

TEST(CsvColumns, times_keep_every_digit) {
    EXPECT_EQ(time_from_text("46408.654976041", 0), 46408'654'976'041);
    EXPECT_EQ(time_from_text("1533226488299.000000001", -3), 1'533'226'488'299'000'000);
    EXPECT_EQ(time_from_text("1533226488299.123456", -3), 1'533'226'488'299'123'456);
    EXPECT_EQ(time_from_text("1533226488299123456", -9), 1'533'226'488'299'123'456);
    EXPECT_EQ(time_from_text("-5", -9), -5);
    EXPECT_EQ(time_from_text("-0.25", -6), -250);
    EXPECT_EQ(time_from_text("7", -6), 7000);
    EXPECT_EQ(time_from_text("1.5e3", 0), 1'500'000'000'000);
    for (const char* wrong : {"", "-", ".", "nan", "inf", "1e30", "12:30", "1 2"})
        EXPECT_FALSE(time_from_text(wrong, 0)) << wrong;
}

TEST(CsvTable, finds_header_and_separator) {
    const test::TemporaryFolder folder;
    const auto cells = [&](const std::string& text, const std::string& name) {
        Table table(folder.write("t.csv", text));
        const auto column = table.find(column_from_text(name, Quantity::length).choice);
        std::string all;
        while (column && table.next()) all += std::string(table.cell(*column)) + "|";
        return column ? all : "none";
    };
    EXPECT_EQ(cells("t,ax,az (fwd,right,down m/s2)\n1,2,3\n\n4,5,6\n", "az"), "3|6|");
    EXPECT_EQ(cells("t,ax,az (fwd,right,down m/s2)\n1,2,3\n", "az (fwd,right,down m/s2)"), "3|");
    EXPECT_EQ(cells("\xEF\xBB\xBF\"t\";\"x [m]\"\r\n1;2\r\n", "x"), "2|");
    EXPECT_EQ(cells("#timestamp [ns],w [rad s^-1]\n1,2\n# a remark\n3,4\n", "w"), "2|4|");
    EXPECT_EQ(cells("1  2 3\n 4 5\t6 \n", "column 3"), "3|6|");
    EXPECT_EQ(cells("a,b\n1,2\n", "column 3"), "none");
    EXPECT_EQ(cells("a (open,b\n1,2\n", "b"), "2|");
    EXPECT_THROW(cells("", "a"), std::runtime_error);
    EXPECT_THROW(cells("# only\n\n", "a"), std::runtime_error);
}

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
    const double turn_radps = -0.2, wheel_mps = 2 + 0.2 * 0.76, angle_deg = -std::atan(0.283) / rad_of_deg;
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
    EXPECT_FLOAT_EQ(first->sensedData[1].yaw, float(-45 * rad_of_deg));
    EXPECT_EQ(first->sensedData[0].landmarkID, -1);
    EXPECT_DOUBLE_EQ(first->sensorLocationOnRobot.x(), 3.5);
    EXPECT_NEAR(first->sensorLocationOnRobot.yaw(), -M_PI / 2, 1e-12);
    EXPECT_EQ(log.at<mrpt::obs::CObservationBearingRange>(1)->sensedData.size(), 1u);
    EXPECT_FLOAT_EQ(log.at<mrpt::obs::CObservationBearingRange>(2)->sensedData[0].yaw,
                    float(-10 * rad_of_deg));
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
    EXPECT_DOUBLE_EQ(imu->get(mrpt::obs::IMU_WX), rad_of_deg);
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

TEST_F(CsvImport, fixes_have_all_that_the_table_tells) {
    folder.write("f.csv",
                 "t,lat,lon,alt,v,course,ve,vn,vu,st,n,hdop\n100,49.5,8.25,120,10,90,4,9,16,0,7,1.5\n"
                 "101,49.5,8.25,120,0,0,0,0,0,2,7,0\n102,49.5,8.25,120,0,0,1,1,1,-1,0,0\n103,99,8.25,1,0,0,1,"
                 "1,1,0,0,0\n");
    const auto log = import(
        "[gps]\nkind = gnss\nfile = f.csv\ntime = t\nlatitude = lat in deg\nlongitude = lon in deg\naltitude "
        "= "
        "alt\ngeoid_separation_m = 48\nspeed = v in km/h\ncourse = course in deg\nvariance_east = ve\n"
        "variance_north = vn\nvariance_up = vu\nquality = st\nquality_codes = ros\nsatellites = n\nhdop = "
        "hdop\n"
        "x_m = -0.5\nz_m = 1.8\n");
    ASSERT_EQ(log.observations.size(), 3u);
    EXPECT_NE(log.warnings.find("[gps]: 1 fixes are nowhere on the Earth"), std::string::npos)
        << log.warnings;
    const auto fix = log.fix(0);
    EXPECT_EQ(fix.stamp_ns, 100'000'000'000);
    EXPECT_FALSE(fix.received_ns);
    EXPECT_EQ(fix.quality, gnss::FixQuality::single);
    EXPECT_NEAR(fix.antenna.latitude_deg, 49.5, 1e-12);
    EXPECT_NEAR(fix.antenna.longitude_deg, 8.25, 1e-12);
    EXPECT_DOUBLE_EQ(fix.antenna.height_m, 168);
    EXPECT_DOUBLE_EQ(fix.geoid_separation_m, 48);
    EXPECT_NEAR(*fix.speed_mps, 10 / 3.6, 1e-9);
    EXPECT_NEAR(*fix.course_rad, 0, 1e-9) << "east";
    EXPECT_NEAR((*fix.sigma_enu_m - Eigen::Vector3d(2, 3, 4)).norm(), 0, 1e-6);
    EXPECT_EQ(fix.satellites, 7);
    EXPECT_NEAR(*fix.hdop, 1.5, 1e-6);
    EXPECT_EQ(fix.p_base_antenna_m, Eigen::Vector3d(-0.5, 0, 1.8));
    EXPECT_EQ(log.fix(1).quality, gnss::FixQuality::differential);
    EXPECT_FALSE(log.fix(1).sigma_enu_m) << "0 is what receivers write for not known";
    EXPECT_FALSE(log.fix(2).has_position);
}

TEST_F(CsvImport, fixes_in_metres_lie_about_their_origin) {
    folder.write("f.csv", "t e n\n1 100 -200\n");
    const std::string map =
        "[gps]\nkind = gnss\nfile = f.csv\ntime = t\neast = e\nnorth = n\norigin_latitude_deg = -33.9\n"
        "origin_longitude_deg = 151.2\norigin_height_m = 20\nfixes = rtk_float\n";
    const auto flat = import(map).fix(0);
    EXPECT_FALSE(flat.has_height);
    const gnss::LocalFrame frame({-33.9, 151.2, 20});
    const auto place = frame.geodetic({100, -200, 0});
    EXPECT_NEAR(flat.antenna.latitude_deg, place.latitude_deg, 1e-12);
    EXPECT_NEAR(flat.antenna.longitude_deg, place.longitude_deg, 1e-12);
    folder.write("f.csv", "t e n u\n1 100 -200 5\n");
    const auto high = import(map + "height = u\n").fix(0);
    EXPECT_EQ(high.quality, gnss::FixQuality::rtk_float);
    EXPECT_NEAR((frame.p_enu_m(high.antenna) - Eigen::Vector3d(100, -200, 5)).norm(), 0, 1e-6);
}

TEST_F(CsvImport, the_clock_of_the_tables_becomes_utc_by_the_quickest_fixes) {
    // The device has been on for 1000 s at 1 600 000 000; fixes come 60 to 160 ms late, one is stamped a day
    // off.
    std::string fixes = "t,utc,lat,lon\n";
    for (int i = 0; i < 50; ++i) {
        const double late_s = 0.06 + 0.1 * (i * 7 % 10) / 9;
        fixes += number_text(1000 + i + late_s) + "," +
                 (i == 20 ? "1600086400000" : std::to_string(1600000000LL + i) + "000") + ",50,8\n";
    }
    folder.write("f.csv", fixes);
    folder.write("o.csv", "t,x,y,h\n1000,0,0,0\n1002.0005,1,0,0\n1049,2,0,0\n");
    const std::string map =
        "[gps]\nkind = gnss\nfile = f.csv\ntime = t\nutc = utc in ms\nlatitude = lat in deg\nlongitude = lon "
        "in "
        "deg\n[wheels]\nkind = odometry\nfile = o.csv\ntime = t\nx = x\ny = y\nyaw = h in rad\n";
    const auto log = import("[clock]\nutc_from = gps\nlatency_s = 0.06\n" + map);
    ASSERT_EQ(log.observations.size(), 53u);
    EXPECT_NE(log.warnings.find("[gps]: 1 fixes have a utc more than an hour from"), std::string::npos);
    EXPECT_NE(import(map).warnings.find(
                  "[gps]: 50 fixes have a utc more than an hour from the times of the tables; if "
                  "these are not UTC, name a section in [clock] utc_from"),
              std::string::npos);
    EXPECT_EQ(log.observations[0]->sensorLabel, "wheels");
    EXPECT_EQ(log.stamp_ns(0), 1'600'000'000'000'000'000);
    std::size_t fix_count = 0;
    for (std::size_t i = 0; i < log.observations.size(); ++i)
        if (log.observations[i]->sensorLabel == "gps" && fix_count++ == 1) {
            EXPECT_EQ(log.fix(i).stamp_ns, 1'600'000'001'000'000'000) << "when it was measured";
            EXPECT_NEAR(seconds_between(log.fix(i).stamp_ns, *log.fix(i).received_ns), 0.06 + 0.7 / 9, 1e-6);
        }
    for (std::size_t i = 0; i + 1 < log.observations.size(); ++i) {
        if (log.observations[i]->sensorLabel != "wheels" || log.stamp_ns(i) != 1'600'000'002'000'500'000)
            continue;
        EXPECT_EQ(log.fix(i - 1).stamp_ns, 1'600'000'001'000'000'000) << "fixes stand where they came";
        EXPECT_EQ(log.fix(i + 1).stamp_ns, 1'600'000'002'000'000'000);
    }
    const auto late = import(
        "[wheels]\nkind = odometry\nfile = o.csv\ntime = t\nx = x\ny = y\nyaw = h in rad\nlate_s = 0.25\n");
    EXPECT_EQ(late.stamp_ns(1), 1'001'750'500'000);
    const auto shifted = import(
        "[clock]\nadd_s = 100\n[wheels]\nkind = odometry\nfile = o.csv\ntime = t\nx = x\ny = y\nyaw = h "
        "in rad\n");
    EXPECT_EQ(shifted.stamp_ns(1), 1'102'000'500'000);
}

TEST_F(CsvImport, a_reference_on_the_earth_becomes_a_path_about_its_first_pose) {
    // 30 m north-east and up, heading 120 deg of the compass; the camera looks ahead, x right, y down.
    const gnss::Geodetic origin{37.721, -122.4723, 31.6};
    const gnss::LocalFrame frame(origin);
    const Eigen::Matrix3d R_ecef_enu = gnss::R_ecef_enu(origin.latitude_deg, origin.longitude_deg);
    const Eigen::Quaterniond q_enu_base(Eigen::AngleAxisd(-30 * rad_of_deg, Eigen::Vector3d::UnitZ()));
    const Pose3 T_base_camera({1.5, 0, 1.2},
                              Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX())));
    const std::vector<Pose3> T_enu_base{{{0, 0, 0}, q_enu_base}, {{20, 22, 2}, q_enu_base}};
    const Eigen::Vector3d first_camera_m = T_enu_base[0] * T_base_camera.translation_m;
    std::string rows = "t,x,y,z,qw,qx,qy,qz\n", inverse = rows;
    for (std::size_t i = 0; i < 2; ++i) {
        const Pose3 T_enu_camera = T_enu_base[i] * T_base_camera;
        const Eigen::Vector3d p_m = gnss::p_ecef_m(origin) + R_ecef_enu * T_enu_camera.translation_m;
        const Eigen::Quaterniond q(R_ecef_enu * T_enu_camera.rotation);
        const auto row = [&](const Eigen::Quaterniond& r) {
            std::string text = std::to_string(i);
            for (const double v : {p_m.x(), p_m.y(), p_m.z(), r.w(), r.x(), r.y(), r.z()})
                text += "," + number_text(v);
            return text + "\n";
        };
        rows += row(q);
        inverse += row(q.conjugate());
    }
    folder.write("o.csv", "t,x,y,h\n0,0,0,0\n");
    const std::string map =
        "[wheels]\nkind = odometry\nfile = o.csv\ntime = t\nx = x\ny = y\nyaw = h in rad\n[truth]\nkind = "
        "reference\nfile = r.csv\ntime = t\necef_x = x\necef_y = y\necef_z = z\nqw = qw\nqx = qx\nqy = "
        "qy\nqz = "
        "qz\nx_m = 1.5\nz_m = 1.2\nroll_deg = 180\n";
    for (const bool inverted : {false, true}) {
        folder.write("r.csv", inverted ? inverse : rows);
        const auto log = import(map + (inverted ? "quaternion_is_inverse = true\n" : ""));
        ASSERT_EQ(log.truth.size(), 2u);
        const auto camera = frame.geodetic(first_camera_m);
        ASSERT_TRUE(log.frame);
        EXPECT_NEAR(log.frame->latitude_deg, camera.latitude_deg, 1e-11);
        EXPECT_NEAR(log.frame->longitude_deg, camera.longitude_deg, 1e-11);
        EXPECT_NEAR(log.frame->height_m, camera.height_m, 1e-6);
        EXPECT_EQ(log.frame->heading_deg, 0);
        for (std::size_t i = 0; i < 2; ++i) {
            const Pose3& pose = log.truth[i].second;
            EXPECT_NEAR((pose.translation_m - (T_enu_base[i].translation_m - first_camera_m)).norm(), 0, 1e-4)
                << "frames 2 m apart are parallel to 0.1 mm over 30 m";
            EXPECT_NEAR(pose.yaw_rad(), -30 * rad_of_deg, 1e-5);
        }
    }
}

TEST_F(CsvImport, a_reference_by_latitude_or_in_a_local_frame_says_the_same) {
    const gnss::LocalFrame frame({50, 8, 100});
    const auto place = frame.geodetic({-300, 400, 7});
    folder.write("o.csv", "t,x,y,h\n0,0,0,0\n");
    folder.write("r.csv", "t,lat,lon,h,heading\n0,50,8,100,90\n1," + number_text(place.latitude_deg) + "," +
                              number_text(place.longitude_deg) + "," + number_text(place.height_m) + ",0\n");
    const std::string wheels =
        "[wheels]\nkind = odometry\nfile = o.csv\ntime = t\nx = x\ny = y\nyaw = h in rad\n[truth]\nkind = "
        "reference\nfile = r.csv\ntime = t\n";
    const auto by_latitude = import(
        wheels + "latitude = lat in deg\nlongitude = lon in deg\nheight = h\nheading = heading in deg\n");
    EXPECT_NEAR((by_latitude.truth.at(1).second.translation_m - Eigen::Vector3d(-300, 400, 7)).norm(), 0,
                1e-5);
    EXPECT_NEAR(by_latitude.truth[0].second.yaw_rad(), 0, 1e-9);
    EXPECT_NEAR(by_latitude.truth[1].second.yaw_rad(), M_PI / 2, 1e-4);
    EXPECT_NEAR(by_latitude.frame->latitude_deg, 50, 1e-11);

    folder.write("r.csv", "t x y yaw\n5 1 2 90\n");
    const auto local = import(wheels + "x = x\ny = y\nyaw = yaw in deg\nx_m = 3\n");
    EXPECT_NEAR((local.truth.at(0).second.translation_m - Eigen::Vector3d(1, -1, 0)).norm(), 0, 1e-12)
        << "what the reference is of is 3 m ahead of the origin";
    EXPECT_FALSE(local.frame) << "nobody said where it lies";
    const auto placed = import(wheels +
                               "x = x\ny = y\nyaw = yaw in deg\norigin_latitude_deg = 50\n"
                               "origin_longitude_deg = 8\norigin_heading_deg = 35\n");
    EXPECT_EQ(placed.frame->heading_deg, 35);
}

TEST_F(CsvImport, all_that_is_wrong_with_a_map_is_said_with_its_line) {
    folder.write("w.csv", "t,left,right\n1,1,1\n");
    EXPECT_EQ(problems("[wheels]\nkind = wheel\n[gps]\nfile = x.csv\n"),
              "map.ini:2: [wheels] kind can't be \"wheel\"; did you mean \"wheels\"?\n"
              "map.ini:3: [gps] kind is missing; it is one of odometry, steering, wheels, imu, gnss, "
              "landmarks and reference");
    EXPECT_EQ(problems("[wheels]\nkind = wheels\nfile = w.csv\ntime = t in h\nleft = left\nrigth = right\n"),
              "map.ini:4: [wheels] time is a time, which can't be in \"h\"; its units are s, ms, us and ns\n"
              "map.ini:6: [wheels] rigth is not a key of this section; did you mean \"right\"?");
    EXPECT_EQ(problems("[wheels]\nkind = wheels\nfile = w.csv\ntime = t\nleft = left\n"),
              "map.ini:1: [wheels] right is missing; name the column that holds it\n"
              "map.ini:1: [wheels] track_width_m is missing; give the distance of the wheels");
    const std::string good =
        "[wheels]\nkind = wheels\nfile = w.csv\ntime = t\ntrack_width_m = 1.5\nright = right\n";
    EXPECT_EQ(problems(good + "left = lefft in km/h\n"),
              "map.ini:7: [wheels] left names the column \"lefft\", which w.csv does not have; did you mean "
              "\"left\"?");
    EXPECT_EQ(problems(good + "left = column 4\n"), "map.ini:7: [wheels] left is column 4, and w.csv has 3");
    EXPECT_EQ(problems("[wheels]\nkind = wheels\nfile = v.csv\ntime = t\ntrack_width_m = 1\nleft = "
                       "left\nright = right\n"),
              "map.ini:3: [wheels] file names v.csv, which is neither an input nor in one; did you mean "
              "\"w.csv\"?");
    EXPECT_EQ(problems("[clock]\nutc_from = gps\n" + good + "left = left\n"),
              "map.ini:2: [clock] utc_from names no GNSS section with a column utc: \"gps\"; there is none");
    EXPECT_EQ(
        problems("[gps]\nkind = gnss\nfile = w.csv\ntime = t\neast = left\nheight = right\naltitude = right\n"
                 "speed = left\n"),
        "map.ini:1: [gps] north is missing: east and north go together\n"
        "map.ini:1: [gps] origin_latitude_deg is missing; say where east and north begin\n"
        "map.ini:1: [gps] course is missing: speed and course go together\n"
        "map.ini:7: [gps] altitude says the same as height; give one of them\n"
        "map.ini:7: [gps] altitude goes with latitude and longitude; with east and north give height, above "
        "the "
        "origin");
    folder.write("w.csv", "t,left,right\n1,x,1\n");
    EXPECT_EQ(problems(good + "left = left\n"),
              "no line of w.csv gives all that [wheels] in map.ini asks for");
    EXPECT_EQ(problems(""), "map.ini:1: there is no section of a sensor; write one, as in datasets/columns");
}
