/// The inertial unit: without errors it leads back along the true path, with them it is as bad as asked for.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationIMU.h>

#include <cmath>

#include "api/pose3_motion.h"
#include "simulation/imu.h"
#include "support/simulated_scene.h"

using namespace loopline;
using namespace loopline::simulation;
using namespace loopline::test;

namespace {

struct ImuReading {
    StampNs time_ns;
    Eigen::Vector3d omega_radps, force_mps2;
};

/// All readings of a scenario's unit.
std::vector<ImuReading> imu_readings(const std::string& file, std::vector<std::string> overrides,
                                     std::unique_ptr<Scene>& scene) {
    overrides.push_back("simulation.sensors=imu");
    WorldSimulator simulator;
    load_scenario(file, overrides, simulator);
    scene = make_scene(simulator.scenario());
    Sensor* const imu = simulator.sensors_in_use().front();
    imu->start(*scene);
    std::vector<ImuReading> readings;
    while (imu->next_time_ns() <= scene->duration_ns()) {
        const StampNs time_ns = imu->next_time_ns();
        const auto o = std::dynamic_pointer_cast<mrpt::obs::CObservationIMU>(imu->next());
        EXPECT_EQ(*stamp_from_mrpt(o->timestamp), scene->start_ns + time_ns);
        using namespace mrpt::obs;
        readings.push_back({time_ns,
                            {o->get(IMU_WX), o->get(IMU_WY), o->get(IMU_WZ)},
                            {o->get(IMU_X_ACC), o->get(IMU_Y_ACC), o->get(IMU_Z_ACC)}});
    }
    return readings;
}

const std::vector<std::string> no_errors{"imu.gyro_noise_deg=0",
                                         "imu.gyro_bias_dps=0",
                                         "imu.gyro_drift_dps=0",
                                         "imu.gyro_scale_error=0",
                                         "imu.gyro_resolution_dps=0",
                                         "imu.accelerometer_noise_mps=0",
                                         "imu.accelerometer_bias_mps2=0",
                                         "imu.accelerometer_drift_mps2=0",
                                         "imu.accelerometer_scale_error=0",
                                         "imu.accelerometer_resolution_mps2=0"};

/// Strapdown integration by the book: rotation vectors, and velocity increments in the middle of each.
class Strapdown {
 public:
    explicit Strapdown(const Pose3& T_map_imu) : pose_(T_map_imu) {}

    void step(const Eigen::Vector3d& omega_radps, const Eigen::Vector3d& force_mps2, double dt_s) {
        const Eigen::Vector3d turn_rad = omega_radps * dt_s;
        const auto exp = [](const Eigen::Vector3d& v) {
            const double angle = v.norm();
            return angle > 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, v / angle))
                             : Eigen::Quaterniond::Identity();
        };
        const Eigen::Vector3d acceleration_mps2 =
            pose_.rotation * exp(turn_rad / 2) * force_mps2 - gravity_mps2 * Eigen::Vector3d::UnitZ();
        const Eigen::Vector3d before_mps = v_mps_;
        v_mps_ += acceleration_mps2 * dt_s;
        pose_.translation_m += (before_mps + v_mps_) / 2 * dt_s;
        pose_.rotation = (pose_.rotation * exp(turn_rad)).normalized();
    }
    const Pose3& pose() const { return pose_; }

 private:
    Pose3 pose_;
    Eigen::Vector3d v_mps_ = Eigen::Vector3d::Zero();
};

/// Readings of a triad at rest, one axis of them.
std::vector<double> at_rest(const TriadSettings& settings, double rate_hz, std::size_t count,
                            std::uint64_t seed, double truth = 0) {
    Triad triad(settings, rate_hz, RandomStream(seed, "triad"));
    std::vector<double> values;
    while (values.size() < count) values.push_back(triad.measured(Eigen::Vector3d::Constant(truth)).y());
    return values;
}

/// Allan variance over clusters of `length` samples.
double allan_variance(const std::vector<double>& values, std::size_t length) {
    std::vector<double> means;
    for (std::size_t i = 0; i + length <= values.size(); i += length) {
        double sum = 0;
        for (std::size_t k = 0; k < length; ++k) sum += values[i + k];
        means.push_back(sum / static_cast<double>(length));
    }
    double sum2 = 0;
    for (std::size_t i = 1; i < means.size(); ++i) sum2 += std::pow(means[i] - means[i - 1], 2);
    return sum2 / (2 * static_cast<double>(means.size() - 1));
}

}  // namespace

TEST(SimulatedImu, at_rest_it_feels_gravity_alone) {
    const Pose3 tilted({1, 2, 3}, Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX())));
    const InertialRates rates = true_rates([&](StampNs) { return tilted; }, 0, 5'000'000, 5'000'000);
    EXPECT_EQ(rates.omega_radps, Eigen::Vector3d::Zero());
    EXPECT_NEAR(rates.specific_force_mps2.x(), 0, 1e-12);
    EXPECT_NEAR(rates.specific_force_mps2.y(), gravity_mps2 * std::sin(0.1), 1e-12) << "the left side is up";
    EXPECT_NEAR(rates.specific_force_mps2.z(), gravity_mps2 * std::cos(0.1), 1e-12);
}

TEST(SimulatedImu, on_a_circle_it_feels_the_pull_of_its_own_place) {
    // Radius 2 m at 0.5 rad/s to the left; the unit 0.3 m ahead of the middle of the axle and turned by 90
    // degrees.
    const Pose3 T_base_imu({0.3, 0, 0},
                           Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ())));
    const auto T_map_imu = [&](StampNs t) {
        return Pose3(exp_se2({2 * 0.5 * seconds_between(0, t), 0, 0.5 * seconds_between(0, t)})) * T_base_imu;
    };
    const InertialRates rates = true_rates(T_map_imu, 1'000'000'000, 1'005'000'000, 5'000'000);
    EXPECT_NEAR(rates.omega_radps.z(), 0.5, 1e-9);
    // In the base: 0.25 (-0.3, 2) m/s^2; the unit's x axis points left there, its y axis back.
    EXPECT_NEAR(rates.specific_force_mps2.x(), 0.5, 1e-5);
    EXPECT_NEAR(rates.specific_force_mps2.y(), 0.075, 1e-5);
}

TEST(SimulatedImu, without_errors_its_readings_lead_along_the_true_path) {
    std::unique_ptr<Scene> scene;
    const auto readings = imu_readings(test_scenario("cart_floor.ini"), no_errors, scene);
    const Pose3 T_base_imu({0.1, -0.05, 0.4}, Eigen::Quaterniond::Identity());
    const auto truth = [&](StampNs t) { return scene->drive.motion.pose_at(t) * T_base_imu; };
    const double dt_s = 0.005;
    // A reading is the mean over the interval about its stamp; between two stamps, the mean of both.
    Strapdown by_interval(truth(0)), by_stamp(truth(0));
    double worst_interval_m = 0, worst_stamp_m = 0, worst_heading_rad = 0;
    for (std::size_t i = 1; i < readings.size(); ++i) {
        const ImuReading &before = readings[i - 1], &now = readings[i];
        by_interval.step(now.omega_radps, now.force_mps2, dt_s);
        by_stamp.step((before.omega_radps + now.omega_radps) / 2, (before.force_mps2 + now.force_mps2) / 2,
                      dt_s);
        const Pose3 at_end = truth(now.time_ns + 2'500'000), at_stamp = truth(now.time_ns);
        worst_interval_m =
            std::max(worst_interval_m, (by_interval.pose().translation_m - at_end.translation_m).norm());
        worst_stamp_m =
            std::max(worst_stamp_m, (by_stamp.pose().translation_m - at_stamp.translation_m).norm());
        worst_heading_rad =
            std::max({worst_heading_rad, by_interval.pose().rotation.angularDistance(at_end.rotation),
                      by_stamp.pose().rotation.angularDistance(at_stamp.rotation)});
    }
    EXPECT_GT(readings.size(), 45000u);
    EXPECT_LT(worst_interval_m, 0.01);
    EXPECT_LT(worst_stamp_m, 0.03);
    EXPECT_LT(worst_heading_rad, 0.01 * M_PI / 180);
    RecordProperty("worst_interval_m", std::to_string(worst_interval_m));
    RecordProperty("worst_stamp_m", std::to_string(worst_stamp_m));
    RecordProperty("worst_heading_deg", std::to_string(worst_heading_rad * 180 / M_PI));
}

TEST(SimulatedImu, with_its_errors_free_inertial_navigation_is_lost_within_a_minute) {
    std::unique_ptr<Scene> scene;
    const auto readings = imu_readings(test_scenario("cart_floor.ini"), {}, scene);
    Strapdown free(scene->drive.motion.pose_at(0));
    for (std::size_t i = 0; i < 12000; ++i) free.step(readings[i].omega_radps, readings[i].force_mps2, 0.005);
    EXPECT_GT((free.pose().translation_m - scene->drive.motion.pose_at(60'000'000'000).translation_m).norm(),
              10);
}

TEST(SimulatedImu, noise_is_white_with_the_density_asked_for) {
    TriadSettings settings;
    settings.noise = 0.02;
    for (const double rate_hz : {100.0, 200.0}) {
        const auto values = at_rest(settings, rate_hz, 200'000, 1);
        for (const std::size_t length : {1, 10, 100}) {
            // Allan variance of white noise: density^2 / tau.
            const double expected = 0.02 * 0.02 / (static_cast<double>(length) / rate_hz);
            const double clusters = 200'000.0 / static_cast<double>(length);
            EXPECT_NEAR(allan_variance(values, length), expected, 5 * expected * std::sqrt(3 / clusters));
        }
    }
}

TEST(SimulatedImu, biases_scale_factors_and_drift_have_the_deviations_asked_for) {
    TriadSettings settings;
    settings.bias = 0.3;
    settings.scale_error = 0.01;
    settings.drift = 0.05;
    settings.drift_s = 2;
    constexpr int units = 4000;
    double bias2 = 0, scale2 = 0, drift2 = 0, product = 0;
    for (int i = 0; i < units; ++i) {
        Triad triad(settings, 10, RandomStream(static_cast<std::uint64_t>(i), "triad"));
        const double turn_on = triad.bias().x();
        for (int k = 0; k < 100; ++k) triad.measured(Eigen::Vector3d::Zero());
        const double first = triad.bias().x() - turn_on;
        for (int k = 0; k < 20; ++k) triad.measured(Eigen::Vector3d::Zero());
        const double later = triad.bias().x() - turn_on;
        bias2 += turn_on * turn_on / units;
        scale2 += std::pow(triad.scale_error().x(), 2) / units;
        drift2 += first * first / units;
        product += first * later / units;
    }
    const double part = 5 / std::sqrt(2.0 * units);
    EXPECT_NEAR(std::sqrt(bias2), 0.3, part * 0.3);
    EXPECT_NEAR(std::sqrt(scale2), 0.01, part * 0.01);
    EXPECT_NEAR(std::sqrt(drift2), 0.05, part * 0.05);
    EXPECT_NEAR(product / drift2, std::exp(-1), 5 / std::sqrt(units)) << "after the correlation time";
}

TEST(SimulatedImu, errors_act_on_the_reading) {
    TriadSettings settings;
    settings.scale_error = 0.01;
    settings.bias = 0.1;
    Triad triad(settings, 200, RandomStream(1, "triad"));
    const Eigen::Vector3d truth(1, -2, 3);
    const Eigen::Vector3d expected = truth + triad.scale_error().cwiseProduct(truth) + triad.bias();
    EXPECT_LT((triad.measured(truth) - expected).norm(), 1e-12);
    settings.resolution = 0.25;
    for (const double value : at_rest(settings, 200, 10, 2, 1.3))
        EXPECT_NEAR(std::remainder(value, 0.25), 0, 1e-12);
}
