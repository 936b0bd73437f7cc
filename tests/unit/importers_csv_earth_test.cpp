/// Fixes and reference paths on the Earth out of tables, number by number.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "gnss/local_frame.h"
#include "support/csv_import.h"

using namespace loopline;
using namespace loopline::csv;
using test::CsvImport;

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
    const Eigen::Quaterniond q_enu_base(Eigen::AngleAxisd(-30 * M_PI / 180, Eigen::Vector3d::UnitZ()));
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
            EXPECT_NEAR(pose.yaw_rad(), -30 * M_PI / 180, 1e-5);
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
