/// `loopline check` on logs with an IMU: what it says to look at.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <functional>

#include "cli/run_support.h"

using namespace loopline;
using namespace loopline::testing;
using mrpt::obs::CObservationIMU;

namespace {

/// 40 s of curves: an IMU at 100 Hz with some noise, odometry and a scan at 10 Hz. `spoil` is a careless
/// driver.
std::string log_with_imu(const Folder& folder, const std::function<void(CObservationIMU&)>& spoil) {
    using namespace mrpt::obs;
    std::vector<mrpt::serialization::CSerializable::Ptr> objects;
    for (int i = 0; i < 4000; ++i) {
        const StampNs stamp_ns = log_start_ns + i * second_ns / 100;
        const double t_s = i / 100.0;
        const auto noise = [i](int channel) { return 0.01 * std::sin(12.9898 * i + 78.233 * channel); };
        auto imu = CObservationIMU::Create();
        imu->sensorLabel = "imu";
        imu->timestamp = stamp_to_mrpt(stamp_ns);
        imu->set(IMU_WX, noise(0));
        imu->set(IMU_WY, noise(1));
        imu->set(IMU_WZ, std::cos(t_s) + noise(2));
        imu->set(IMU_X_ACC, noise(3));
        imu->set(IMU_Y_ACC, noise(4));
        imu->set(IMU_Z_ACC, 9.80665 + noise(5));
        spoil(*imu);
        objects.push_back(imu);
        if (i % 10 != 0) continue;
        auto odometry = CObservationOdometry::Create();
        odometry->sensorLabel = "odometry";
        odometry->timestamp = stamp_to_mrpt(stamp_ns);
        odometry->odometry = {0.1 * t_s, 0, std::sin(t_s)};
        objects.push_back(odometry);
        objects.push_back(scan(stamp_ns, "LASER", 181));
    }
    const std::string path = folder / "imu.rawlog";
    write_log(path, objects);
    return path;
}

test::ProgramResult checked(const std::function<void(CObservationIMU&)>& spoil) {
    const SmallRun small;
    return test::run_loopline({"check", small.ini(), "--rawlog", log_with_imu(small.folder(), spoil)});
}

void expect_said(const test::ProgramResult& result, const std::vector<std::string>& said) {
    EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
    std::istringstream stream(result.out);
    std::string out, word;
    while (stream >> word) out += word + " ";  // in one line, wherever it was broken
    for (const auto& words : said)
        EXPECT_NE(out.find(words), std::string::npos) << "\"" << words << "\" is not in:\n"
                                                      << result.out << result.err;
}

}  // namespace

TEST(ImuOfALog, is_approved_if_right) {
    expect_said(checked([](CObservationIMU&) {}),
                {"CObservationIMU \"imu\": 4000, 100 Hz", "Verdict: good to run."});
}

TEST(ImuOfALog, in_degrees_and_g_is_pointed_out) {
    expect_said(checked([](CObservationIMU& imu) {
                    for (const auto i : {mrpt::obs::IMU_WX, mrpt::obs::IMU_WY, mrpt::obs::IMU_WZ})
                        imu.rawMeasurements[i] *= 180 / M_PI;
                    for (const auto i : {mrpt::obs::IMU_X_ACC, mrpt::obs::IMU_Y_ACC, mrpt::obs::IMU_Z_ACC})
                        imu.rawMeasurements[i] /= 9.80665;
                }),
                {"To look at:", "CObservationIMU \"imu\" turns 57.", "rates are in deg/s",
                 "CObservationIMU \"imu\" feels 1 where gravity is 9.8 m/s^2: its accelerations are in g",
                 "see above what to look at"});
}

TEST(ImuOfALog, mounted_turned_is_pointed_out_until_mount_says_so) {
    const auto on_its_side = [](CObservationIMU& imu) {  // its y axis points up
        std::swap(imu.rawMeasurements[mrpt::obs::IMU_WY], imu.rawMeasurements[mrpt::obs::IMU_WZ]);
        std::swap(imu.rawMeasurements[mrpt::obs::IMU_Y_ACC], imu.rawMeasurements[mrpt::obs::IMU_Z_ACC]);
        imu.rawMeasurements[mrpt::obs::IMU_WZ] *= -1;
        imu.rawMeasurements[mrpt::obs::IMU_Z_ACC] *= -1;
    };
    expect_said(checked(on_its_side), {"feels gravity along its +y axis", "mounted turned",
                                       "[mount] sensors = imu, yaw_deg = 0, pitch_deg = 0, roll_deg = 90"});

    const SmallRun small;
    const auto log = log_with_imu(small.folder(), on_its_side);
    expect_said(test::run_loopline({"check", small.ini(), "--rawlog", log, "--set", "mount.sensors=imu",
                                    "--set", "mount.roll_deg=90"}),
                {"Verdict: good to run."});
}

TEST(ImuOfALog, that_gives_angles_alone_is_left_in_peace) {
    expect_said(checked([](CObservationIMU& imu) {
                    imu.dataIsPresent.fill(false);
                    imu.set(mrpt::obs::IMU_ROLL, 0.01);
                }),
                {"Verdict: good to run."});
}
