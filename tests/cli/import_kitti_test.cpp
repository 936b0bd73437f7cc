/// loopline import kitti as a user runs it: a made-up folder, real scans, and every way of being wrong.
#include <gtest/gtest.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/maps/CPointsMapXYZI.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/serialization/CArchive.h>

#include <cmath>

#include "lidar/beam_table.h"
#include "lidar/observation_scan.h"
#include "output/tum.h"
#include "support/run_program.h"

using namespace loopline;
using namespace loopline::test;

namespace {

/// Rings as KITTI stores them, and a point at the origin at last.
std::string small_bin(int rings) {
    std::vector<float> numbers;
    const auto table = lidar::table_of_beams(64)->elevations_deg;
    for (int ring = 0; ring < rings; ++ring)
        for (int k = 0; k < 100; ++k) {
            const double a = 2 * M_PI * (k + 0.5) / 100,
                         e = table[static_cast<std::size_t>(ring)] * M_PI / 180;
            for (const double v :
                 {12 * std::cos(e) * std::cos(a), 12 * std::cos(e) * std::sin(a), 12 * std::sin(e), 0.25})
                numbers.push_back(static_cast<float>(v));
        }
    numbers.resize(numbers.size() + 4, 0.0f);
    return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(float)};
}

std::vector<mrpt::obs::CObservation::Ptr> observations_of(const std::string& rawlog) {
    std::vector<mrpt::obs::CObservation::Ptr> all;
    mrpt::io::CFileGZInputStream stream(rawlog);
    auto archive = mrpt::serialization::archiveFrom(stream);
    try {
        while (true) all.push_back(std::dynamic_pointer_cast<mrpt::obs::CObservation>(archive.ReadObject()));
    } catch (const std::exception&) {  // the end
    }
    return all;
}

class ImportKitti : public ::testing::Test {
 protected:
    ProgramResult import(const std::vector<std::string>& more = {}, const std::string& input = {}) {
        std::vector<std::string> words{"import", "kitti", input.empty() ? (folder / "00").string() : input,
                                       "--out", out};
        words.insert(words.end(), more.begin(), more.end());
        return run_loopline(words);
    }
    void write_scans(const std::string& where, int scans) {
        for (int i = 0; i < scans; ++i)
            folder.write(where + "/00000" + std::to_string(i) + ".bin", small_bin(64));
    }
    TemporaryFolder folder;
    std::string out = (folder / "out.rawlog").string();
};

}  // namespace

TEST_F(ImportKitti, a_sequence_with_times_poses_and_calibration) {
    write_scans("00/velodyne", 3);
    folder.write("00/times.txt", "0.000000e+00\n1.037359e-01\n2.074732e-01\n");
    folder.write("00/calib.txt", "P0: 1 0 0 0 0 1 0 0 0 0 1 0\nTr: 0 -1 0 0 0 0 -1 -0.08 1 0 0 -0.27\n");
    // The camera goes 2 m ahead, then turns left on its spot, about its axis that looks down.
    folder.write("00/poses.txt",
                 "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 2\n0 0 -1 0 0 1 0 0 1 0 0 2\n");
    const auto result = import();
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    EXPECT_NE(result.out.find("3 scans"), std::string::npos) << result.out;
    const auto observations = observations_of(out);
    ASSERT_EQ(observations.size(), 3u);
    lidar::SpinningScanReader reader;
    lidar::SpinningScan scan;
    for (const auto& observation : observations) {
        ASSERT_TRUE(reader.read(*observation, scan));
        EXPECT_EQ(scan.rings(), 64u);
        EXPECT_EQ(scan.points.size(), 6400u);
    }
    EXPECT_EQ(scan.stamp_ns, 1'300'000'000'207'473'200);
    const auto* cloud = dynamic_cast<const mrpt::obs::CObservationPointCloud*>(observations[0].get());
    ASSERT_NE(cloud, nullptr);
    EXPECT_EQ(dynamic_cast<const mrpt::maps::CPointsMapXYZI&>(*cloud->pointcloud).getPointIntensity_fast(7),
              0.25f);
    const auto truth = read_tum(folder / "out.truth.tum");
    ASSERT_EQ(truth.size(), 3u);
    EXPECT_NEAR((truth[1].T_map_base.translation_m - Eigen::Vector3d(2, 0, 0)).norm(), 0, 1e-6);
    // The lidar, 0.27 m behind the camera, goes round it.
    EXPECT_NEAR(truth[2].T_map_base.yaw_rad(), M_PI / 2, 1e-6);
    EXPECT_NEAR((truth[2].T_map_base.translation_m - Eigen::Vector3d(2.27, -0.27, 0)).norm(), 0, 1e-6);
}

TEST_F(ImportKitti, a_raw_drive_with_oxts) {
    write_scans("00/velodyne_points/data", 2);
    folder.write("00/velodyne_points/timestamps.txt",
                 "2011-09-26 13:04:32.345000123\n2011-09-26 13:04:32.448000000\n");
    for (const char* name : {"0000000000", "0000000001"})
        folder.write(std::string("00/oxts/data/") + name + ".txt",
                     "49.01 8.43 112.8 0.02 0.01 -1.2 0 0 0 0 0 0.1 0.2 9.8 0 0 0 0.01 0.02 0.03 0 0 0 0.5 "
                     "0.1 4 10 4 4 0\n");
    folder.write("00/oxts/timestamps.txt", "2011-09-26 13:04:32.349000000\n2011-09-26 13:04:32.450000000\n");
    const auto result = import();
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto observations = observations_of(out);
    ASSERT_EQ(observations.size(), 6u);
    EXPECT_EQ(*stamp_from_mrpt(observations[0]->timestamp), 1317042272'345000100) << "a rawlog counts 100 ns";
    StampNs before_ns = 0;
    for (const auto& observation : observations) {
        EXPECT_GE(*stamp_from_mrpt(observation->timestamp), before_ns);
        before_ns = *stamp_from_mrpt(observation->timestamp);
    }
    const auto* imu = dynamic_cast<const mrpt::obs::CObservationIMU*>(observations[1].get());
    const auto* gnss = dynamic_cast<const mrpt::obs::CObservationGPS*>(observations[2].get());
    ASSERT_TRUE(imu && gnss);
    EXPECT_EQ(imu->get(mrpt::obs::IMU_Z_ACC), 9.8);
    EXPECT_EQ(imu->get(mrpt::obs::IMU_WZ), 0.03);
    EXPECT_EQ(gnss->getMsgByClass<mrpt::obs::gnss::Message_NMEA_GGA>().fields.latitude_degrees, 49.01);
    EXPECT_FALSE(std::filesystem::exists(folder / "out.truth.tum"));
}

TEST_F(ImportKitti, without_times_scans_follow_each_other) {
    write_scans("00", 2);
    const auto result = import({"--rate-hz", "20"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NE(result.err.find("there are no times"), std::string::npos) << result.err;
    const auto observations = observations_of(out);
    ASSERT_EQ(observations.size(), 2u);
    EXPECT_EQ(*stamp_from_mrpt(observations[1]->timestamp) - *stamp_from_mrpt(observations[0]->timestamp),
              50'000'000);
}

TEST_F(ImportKitti, what_is_wrong_is_said_and_nothing_is_written) {
    const auto expect = [&](const std::string& sentence, const std::vector<std::string>& more = {},
                            const std::string& input = {}) {
        const auto result = import(more, input);
        EXPECT_EQ(result.exit_code, 3) << sentence;
        EXPECT_NE(result.err.find(sentence), std::string::npos) << result.err;
        EXPECT_FALSE(std::filesystem::exists(out));
    };
    expect("there is no such file or folder");
    folder.write("00/readme", "");
    expect("there is no .bin file in");
    write_scans("00", 2);
    expect("has 1 lines for 2 scans", {"--times", folder.write("given_times.txt", "0.5\n")});
    expect("has a line that is no time", {"--times", folder.write("given_times.txt", "0.5\nlater\n")});
    expect("can't be read", {"--times", "nowhere.txt"});
    expect("is no row of 12 numbers", {"--poses", folder.write("given_poses.txt", "1 2 3\n")});
    folder.write("00/000001.bin", "12345");
    expect("is damaged");
}
