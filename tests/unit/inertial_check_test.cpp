/// What is said of IMUs that are right, and of those that are wrong in one way each.
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "api/pose2.h"
#include "inertial/imu_verdict.h"
#include "support/inertial_drive.h"

using namespace loopline;
using namespace loopline::inertial;

namespace {

constexpr StampNs log_start_ns = 1'000'000'000'000;

/// A drive of a minute or more, an IMU at 100 Hz, odometry at 10 Hz.
struct CheckedLog {
    double duration_s = 60;
    double turning_radps = 1;
    double gyro_later_s = 0;
    Eigen::Matrix3d R_base_imu = Eigen::Matrix3d::Identity();  ///< how it is really mounted
    Eigen::Vector3d gyro_bias_radps{0.002, -0.001, 0.003};
    double gyro_noise_radps = 0.01, force_noise_mps2 = 0.1, heading_walk_rad = 0.001;
    bool with_odometry = true;
    std::uint64_t seed = 8;
    /// What a careless driver makes of reading number i; false drops it.
    std::function<bool(int i, ImuReading&)> spoil = [](int, ImuReading&) { return true; };

    ImuCheck check() const {
        test::SmoothDrive drive;
        drive.turning_radps = turning_radps;
        double heading_error_rad = 0;
        Eigen::Vector3d p_m = Eigen::Vector3d::Zero();
        std::mt19937_64 random(seed);
        std::normal_distribution<double> normal;
        const auto white = [&](double sigma) {
            const double x = normal(random), y = normal(random), z = normal(random);
            return Eigen::Vector3d(sigma * x, sigma * y, sigma * z);
        };
        ImuCheck result;
        for (int i = 0; i < duration_s * 100; ++i) {
            const ImuSample truth = drive.reading(i * 0.01 - gyro_later_s);
            ImuReading reading;
            const StampNs reading_stamp_ns = log_start_ns + i * 10'000'000LL;
            reading.stamp_ns = reading_stamp_ns;
            reading.omega_imu_radps =
                R_base_imu.transpose() * truth.omega_base_radps + gyro_bias_radps + white(gyro_noise_radps);
            reading.specific_force_imu_mps2 =
                R_base_imu.transpose() * truth.specific_force_base_mps2 + white(force_noise_mps2);
            if (spoil(i, reading)) result.add_imu(reading);
            p_m += drive.way_m(i * 0.01, i * 0.01 + 0.01);
            if (!with_odometry || i % 10 != 3) continue;
            heading_error_rad += heading_walk_rad * normal(random);
            result.add_odometry(
                reading_stamp_ns,
                {p_m.x(), p_m.y(), wrap_to_pi(drive.heading_rad(i * 0.01) + heading_error_rad)});
        }
        return result;
    }
    std::vector<std::string> complaints() const { return imu_complaints(check(), "imu", log_start_ns); }
};

/// Exactly one complaint, with all these words.
void expect_one(const std::vector<std::string>& complaints, const std::vector<std::string>& words) {
    ASSERT_EQ(complaints.size(), 1u) << testing::PrintToString(complaints);
    for (const auto& word : words)
        EXPECT_NE(complaints[0].find(word), std::string::npos) << word << " is not in: " << complaints[0];
}

CheckedLog spoilt(std::function<bool(int, ImuReading&)> spoil) {
    CheckedLog log;
    log.spoil = std::move(spoil);
    return log;
}

Eigen::Matrix3d turned(double angle_deg, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(angle_deg * M_PI / 180, axis).toRotationMatrix();
}

}  // namespace

TEST(ImuCheck, nothing_is_wrong_with_a_good_one) {
    for (const std::uint64_t seed : {1, 2, 3}) {
        CheckedLog log;
        log.seed = seed;
        EXPECT_EQ(log.complaints(), std::vector<std::string>());
        log.with_odometry = false;
        EXPECT_EQ(log.complaints(), std::vector<std::string>());
    }
}

TEST(ImuCheck, no_time_offset_is_made_up_where_turns_are_slow_and_wheels_slip) {
    for (const double duration_s : {45, 120}) {
        CheckedLog log;
        log.duration_s = duration_s;
        log.turning_radps = 0.3;
        log.heading_walk_rad = 0.003;
        for (log.seed = 200; log.seed < 220; ++log.seed)
            EXPECT_EQ(log.complaints(), std::vector<std::string>()) << log.seed;
    }
}

TEST(ImuCheck, rates_in_degrees_are_recognised_with_and_without_odometry) {
    auto log = spoilt([](int, ImuReading& r) {
        r.omega_imu_radps *= 180 / M_PI;
        return true;
    });
    expect_one(log.complaints(), {"turns 57", "in deg/s; divide them by 57.2958"});
    log.with_odometry = false;
    expect_one(log.complaints(), {"more than 6 rad/s", "probably in deg/s"});
    log.with_odometry = true;
    log.spoil = [](int, ImuReading& r) {
        r.omega_imu_radps *= M_PI / 180;
        return true;
    };
    log.gyro_noise_radps = 0.005;
    expect_one(log.complaints(), {"turned from degrees to radians twice"});
}

TEST(ImuCheck, accelerations_in_other_units_are_recognised) {
    const auto scaled = [](double factor) {
        return spoilt([factor](int, ImuReading& r) {
                   r.specific_force_imu_mps2 *= factor;
                   return true;
               })
            .complaints();
    };
    expect_one(scaled(1 / 9.80665), {"feels 1", "are in g"});
    expect_one(scaled(1000 / 9.80665), {"are in mg"});
    expect_one(scaled(1.1), {"feels 10.8", "off by 10 %"});
    expect_one(spoilt([](int, ImuReading& r) {
                   r.specific_force_imu_mps2.z() -= 9.80665;
                   return true;
               }).complaints(),
               {"gravity was taken out"});
}

TEST(ImuCheck, a_turned_mount_is_recognised_with_the_angles_that_put_it_right) {
    const struct {
        Eigen::Matrix3d R_base_imu;
        const char *axis, *mount;
    } table[] = {
        {turned(90, Eigen::Vector3d::UnitX()), "its +y axis", "yaw_deg = 0, pitch_deg = 0, roll_deg = 90"},
        {turned(-90, Eigen::Vector3d::UnitX()), "its -y axis", "yaw_deg = 0, pitch_deg = 0, roll_deg = -90"},
        {turned(180, Eigen::Vector3d::UnitX()), "its -z axis", "yaw_deg = 0, pitch_deg = 0, roll_deg = 180"},
        {turned(-90, Eigen::Vector3d::UnitY()), "its +x axis", "yaw_deg = 0, pitch_deg = -90, roll_deg = 0"},
    };
    for (const auto& row : table) {
        CheckedLog log;
        log.R_base_imu = row.R_base_imu;
        expect_one(log.complaints(), {std::string("gravity along ") + row.axis, "correlation 1.00", row.mount,
                                      "mounted turned"});
        log.spoil = [&](int, ImuReading& r) {
            r.R_base_imu = row.R_base_imu;
            return true;
        };
        EXPECT_EQ(log.complaints(), std::vector<std::string>()) << "the log knows how it is mounted";
    }
}

TEST(ImuCheck, where_x_points_is_known_from_driving) {
    for (const double yaw_deg : {90, -90, 180, 45}) {
        CheckedLog log;
        log.R_base_imu = turned(yaw_deg, Eigen::Vector3d::UnitZ());
        expect_one(log.complaints(),
                   {"feels accelerations of the odometry turned", "pitch_deg = 0, roll_deg = 0"});
        const auto yaw = log.check().travel().mount_yaw(Eigen::Matrix3d::Identity());
        ASSERT_TRUE(yaw);
        EXPECT_NEAR(wrap_to_pi(yaw->yaw_rad - yaw_deg * M_PI / 180), 0, 4 * yaw->sigma_rad + 0.02);
        EXPECT_LT(yaw->sigma_rad, 0.05);
        EXPECT_NEAR(yaw->gain, 1, 0.1);
    }
    CheckedLog log;  // lying on its side, and turned
    log.R_base_imu = turned(-90, Eigen::Vector3d::UnitZ()) * turned(90, Eigen::Vector3d::UnitX());
    expect_one(log.complaints(), {"gravity along its +y", "yaw_deg = -90, pitch_deg = 0, roll_deg = 90"});
}

TEST(ImuCheck, a_lean_is_told_from_a_turned_mount) {
    CheckedLog log;
    log.R_base_imu = turned(12, Eigen::Vector3d::UnitY());
    expect_one(log.complaints(), {"leans by 12 deg", "pitch_deg = 12, roll_deg = "});
}

TEST(ImuCheck, wrong_signs_and_mixed_axes_are_told_apart) {
    expect_one(spoilt([](int, ImuReading& r) {
                   r.omega_imu_radps.z() *= -1;
                   return true;
               }).complaints(),
               {"its +z axis", "about its -z axis", "the odometry's heading have the wrong sign"});
    expect_one(spoilt([](int, ImuReading& r) {
                   r.specific_force_imu_mps2 *= -1;
                   return true;
               }).complaints(),
               {"its -z axis", "about its +z axis", "accelerations have the wrong sign"});
    expect_one(spoilt([](int, ImuReading& r) {
                   std::swap(r.omega_imu_radps.x(), r.omega_imu_radps.z());
                   return true;
               }).complaints(),
               {"about its +x axis", "mixed up"});
}

TEST(ImuCheck, scale_and_bias_of_the_gyro_are_measured) {
    expect_one(spoilt([](int, ImuReading& r) {
                   r.omega_imu_radps *= 1.4;
                   return true;
               }).complaints(),
               {"turns 1.4 times as much", "track width"});
    CheckedLog biased;
    biased.gyro_bias_radps = {0, 0, 0.05};
    expect_one(biased.complaints(), {"0.05", " rad/s where the odometry does not turn", "standstill"});
}

TEST(ImuCheck, a_gyro_that_hangs_does_not_turn_with_the_odometry) {
    const auto complaints = spoilt([](int i, ImuReading& r) {
                                r.omega_imu_radps = {1e-3 * (i % 7), 1e-3 * (i % 5), 1e-3 * (i % 3)};
                                return true;
                            }).complaints();
    expect_one(complaints, {"does not turn with the odometry", "over 5"});
}

TEST(ImuCheck, stuck_channels_are_named) {
    expect_one(spoilt([](int, ImuReading& r) {
                   r.specific_force_imu_mps2.x() = 0;
                   return true;
               }).complaints(),
               {"accelerometer x stuck at 0 all the time"});
    expect_one(spoilt([](int i, ImuReading& r) {
                   if (i >= 2000 && i < 2350) r.omega_imu_radps.y() = 0.125;
                   return true;
               }).complaints(),
               {"gyro y stuck at 0.125 for 3.490 s from 20.000 s on (350 readings)"});
}

TEST(ImuCheck, stamps_are_looked_at) {
    expect_one(
        spoilt([](int i, ImuReading&) { return i < 1500 || i >= 1520; }).complaints(),
        {"has 1 gap of more than 5 of its usual steps of 0.0100 s, the longest of 0.210 s from 14.990 s on"});
    expect_one(spoilt([](int i, ImuReading& r) {
                   if (i % 10 == 5) r.stamp_ns -= 10'000'000;
                   return true;
               }).complaints(),
               {"has 600 observations with the stamp of the one before", "in packets"});
    expect_one(spoilt([](int i, ImuReading& r) {
                   if (i == 1000) r.stamp_ns -= 25'000'000;
                   return true;
               }).complaints(),
               {"goes back in time 1 times, by up to 0.0150 s"});
    expect_one(spoilt([](int i, ImuReading&) { return i % 4 == 0; }).complaints(), {"comes at 25 Hz"});
    auto check = CheckedLog().check();
    check.add_incomplete();
    expect_one(imu_complaints(check, "imu", log_start_ns), {"in 1 of 6001 observations"});
}

TEST(ImuCheck, time_offset_to_the_odometry_is_found_to_milliseconds) {
    for (const double later_s : {-0.42, -0.083, 0.0, 0.0137, 0.137, 0.6}) {
        CheckedLog log;
        log.duration_s = 100;
        log.gyro_later_s = later_s;
        const auto agreement = log.check().agreement();
        ASSERT_TRUE(agreement.gyro_later_s) << later_s;
        EXPECT_NEAR(*agreement.gyro_later_s, later_s, 0.005);
        EXPECT_NEAR(*agreement.gyro_later_s, later_s, 3 * agreement.gyro_later_sigma_s + 0.001);
        EXPECT_LT(agreement.gyro_later_sigma_s, 0.005);
    }
    CheckedLog late;
    late.gyro_later_s = 0.137;
    expect_one(late.complaints(),
               {"shows turns 0.13", "s after the odometry does", "stamps of one of the two"});
}

TEST(ImuCheck, stated_uncertainty_of_the_time_offset_is_its_scatter) {
    double sum = 0, squares = 0, stated = 0;
    constexpr int logs = 30;
    for (int i = 0; i < logs; ++i) {
        CheckedLog log;
        log.seed = 100 + static_cast<std::uint64_t>(i);
        log.gyro_noise_radps = 0.1;
        log.heading_walk_rad = 0.005;
        const auto agreement = log.check().agreement();
        ASSERT_TRUE(agreement.gyro_later_s);
        sum += *agreement.gyro_later_s;
        squares += *agreement.gyro_later_s * *agreement.gyro_later_s;
        stated += agreement.gyro_later_sigma_s * agreement.gyro_later_sigma_s / logs;
    }
    const double variance = squares / logs - sum / logs * sum / logs;
    EXPECT_GT(variance / stated, 0.4);
    EXPECT_LT(variance / stated, 2.5);
    EXPECT_NEAR(sum / logs, 0, 0.005);
}

TEST(ImuCheck, survives_logs_that_jump_in_time) {
    for (const StampNs jump_ns : {-30'000'000'000'000LL, 30'000'000'000'000LL}) {
        const auto complaints = spoilt([jump_ns](int i, ImuReading& r) {
                                    if (i >= 3000) r.stamp_ns += jump_ns;
                                    return true;
                                }).complaints();
        EXPECT_GE(complaints.size(), 1u);
    }
    EXPECT_EQ(imu_complaints(ImuCheck(), "", 0), std::vector<std::string>());
}

TEST(RateOnGrid, gives_the_mean_rate_of_each_cell_and_no_cell_across_a_gap) {
    GridSettings settings;
    settings.cell_ns = 20'000'000;
    settings.longest_gap_ns = 100'000'000;
    RateOnGrid<1> grid(settings);
    const auto angle = [](double x) { return Eigen::Matrix<double, 1, 1>(x); };
    grid.add(-15'000'000, angle(1));
    grid.add(35'000'000, angle(1.5));  // 10 rad/s
    grid.add(35'000'000, angle(7));    // the same stamp again: ignored
    grid.add(65'000'000, angle(1.5));  // at rest
    ASSERT_EQ(grid.first(), 0);
    ASSERT_EQ(grid.end(), 3);
    EXPECT_NEAR(grid.rate(0)(0), 10, 1e-12);
    EXPECT_NEAR(grid.rate(1)(0), 7.5, 1e-12);
    EXPECT_NEAR(grid.rate(2)(0), 0, 1e-12);
    grid.add(365'000'000, angle(2));
    EXPECT_TRUE(grid.empty());
    grid.add(425'000'000, angle(3));
    EXPECT_EQ(grid.first(), 19);
    EXPECT_EQ(grid.end(), 21);
}
