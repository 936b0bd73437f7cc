/// Calibration of a simulated drive: is what it finds the truth, and are its standard errors those of its
/// errors?
#include <gtest/gtest.h>

#include "api/dense_algebra.h"
#include "line_slam/calibration_section.h"
#include "support/slipping_vehicle.h"

using namespace loopline;
using namespace loopline::line_slam;
using test::SlippingDrive;
using test::SlippingVehicle;

namespace {

DriveCalibration calibrated(const SlippingVehicle& vehicle, const SlippingDrive& drive) {
    CalibrationParameters parameters;
    parameters.regimes = drive.interval.regimes;
    return calibrate_drive(vehicle.history(), vehicle.drive(), parameters);
}

/// Mean square of errors by their standard errors.
class Score {
 public:
    void add(const Estimate& estimate, double truth) {
        add((estimate.value - truth) / estimate.standard_error);
    }
    /// Noise is as likely to be half as to be twice as much.
    void add_factor(const Estimate& estimate, double truth) {
        add(std::log(estimate.value / truth) * estimate.value / estimate.standard_error);
    }
    double mean() const { return count_ > 0 ? sum_ / count_ : 0; }

 private:
    void add(double normalised_error) {
        sum_ += normalised_error * normalised_error;
        ++count_;
    }
    double sum_ = 0;
    int count_ = 0;
};

constexpr int drives = 20;
// 99.9 % of the mean of 20 squares of standard normal numbers. Of estimated scatters, Student's have longer
// tails, hence somewhat more.
constexpr double least_chi2 = 0.27, greatest_chi2 = 2.5;

TEST(LineSlamCalibration, errors_are_as_large_as_their_standard_errors_say) {
    const SlippingDrive drive;
    std::array<std::array<Score, wheel_count>, regime_count> slip, random_way, scatter;
    Score side;
    for (int seed = 1; seed <= drives; ++seed) {
        const SlippingVehicle vehicle(drive, static_cast<std::uint64_t>(seed));
        const DriveCalibration found = calibrated(vehicle, drive);
        ASSERT_TRUE(found.good) << seed;
        EXPECT_FALSE(found.track_told) << "wheels that always turn in the same ratio don't tell it";
        EXPECT_EQ(found.track_width_m.value, drive.truth.track_width_m);
        for (std::size_t r = 0; r < regime_count; ++r)
            for (std::size_t w = 0; w < wheel_count; ++w) {
                const WheelEstimate& e = found.wheels[r][w];
                slip[r][w].add(e.slip, drive.truth.slip[r][w]);
                // The inner wheels roll too little in all.
                if (found.amounts[r].rolled_m[w] > 10)
                    random_way[r][w].add_factor(e.random_way_m, drive.truth.sigma_m[r][w]);
                if (drive.truth.scatter[r][w] > 0)
                    scatter[r][w].add_factor(e.scatter, drive.truth.scatter[r][w]);
            }
        side.add_factor(found.sigma_side_m, drive.truth.sigma_side_m);
    }
    for (std::size_t r = 0; r < regime_count; ++r)
        for (std::size_t w = 0; w < wheel_count; ++w) {
            std::printf("regime %zu wheel %zu: slip %.2f, random way %.2f, scatter %.2f\n", r, w,
                        slip[r][w].mean(), random_way[r][w].mean(), scatter[r][w].mean());
            EXPECT_GT(slip[r][w].mean(), least_chi2);
            EXPECT_LT(slip[r][w].mean(), greatest_chi2);
            EXPECT_LT(random_way[r][w].mean(), greatest_chi2);
            EXPECT_LT(scatter[r][w].mean(), greatest_chi2);
        }
    std::printf("side %.2f\n", side.mean());
    EXPECT_LT(side.mean(), greatest_chi2);
}

TEST(LineSlamCalibration, turns_of_many_curvatures_tell_the_track_width) {
    SlippingDrive drive;
    drive.corners = 60;
    drive.smallest_inner_m = 0;
    drive.largest_inner_m = 0.012;
    drive.odometry_track_width_m = drive.slam.drive.track_width_m = 0.40;
    Score track, slip;
    for (int seed = 1; seed <= 5; ++seed) {
        const DriveCalibration found = calibrated({drive, static_cast<std::uint64_t>(seed)}, drive);
        ASSERT_TRUE(found.good && found.track_told) << seed;
        EXPECT_LT(found.track_width_m.standard_error, 0.002);
        track.add(found.track_width_m, drive.truth.track_width_m);
        for (std::size_t r = 0; r < regime_count; ++r)
            for (std::size_t w = 0; w < wheel_count; ++w)
                slip.add(found.wheels[r][w].slip, drive.truth.slip[r][w]);
    }
    EXPECT_LT(track.mean(), 4.1);  // 99.9 % of five
    EXPECT_LT(slip.mean(), 2.6);
}

/// The same drive again with what was found: predictions are as good as their covariance, which they were not
/// before.
TEST(LineSlamCalibration, a_run_with_it_predicts_as_well_as_it_says) {
    SlippingDrive drive;
    drive.corners = 150;
    drive.smallest_inner_m = 0;
    drive.largest_inner_m = 0.012;
    drive.odometry_track_width_m = drive.slam.drive.track_width_m = 0.40;
    const DriveCalibration found = calibrated({drive, 1}, drive);
    ASSERT_TRUE(found.good);
    SlippingDrive better = drive;
    better.slam.drive.track_width_m = found.track_width_m.value;
    better.slam.drive.odometry_track_width_m = drive.odometry_track_width_m;
    better.slam.drive.sigma_side_m = found.sigma_side_m.value;
    better.slam.drive.sigma_rest_m = found.sigma_rest_m.value;
    for (std::size_t r = 0; r < regime_count; ++r) {
        const auto& [left, right] = found.wheels[r];
        better.interval.regimes[r] = {
            {}, left.slip.value, right.slip.value, left.sigma_m.value, right.sigma_m.value};
    }
    const auto worth = [](const SlippingVehicle& vehicle) {
        double square_m2 = 0, normalised = 0;
        for (const auto& p : vehicle.predictions()) {
            const Eigen::Vector3d e(p.error.left_m, p.error.right_m, p.error.side_m);
            square_m2 += e.squaredNorm();
            normalised += squared_in_sigmas(e, p.covariance);
        }
        const auto n = static_cast<double>(vehicle.predictions().size());
        return std::pair(std::sqrt(square_m2 / n), normalised / n);
    };
    // Another drive of the same vehicle.
    const auto [error_before_m, normalised_before] = worth({drive, 2});
    const auto [error_m, normalised] = worth({better, 2});
    std::printf("prediction of a step: %.4f m, normalised %.2f; before %.4f m, %.2f\n", error_m, normalised,
                error_before_m, normalised_before);
    EXPECT_LT(error_m, 0.5 * error_before_m);
    EXPECT_NEAR(normalised, 3, 0.5);
}

TEST(LineSlamCalibration, what_the_log_does_not_hold_is_left_out) {
    SlippingDrive drive;
    drive.right_turns = false;
    drive.corners = 12;
    const DriveCalibration found = calibrated({drive, 1}, drive);
    ASSERT_TRUE(found.good);
    EXPECT_EQ(found.amounts[2].steps, 0);
    EXPECT_EQ(found.amounts[1].stretches, 12);
    const Calibration section = calibration_section(found, {drive.slam.drive, drive.interval.regimes});
    const auto value_of = [&section](const std::string& name) {
        for (const CalibratedKey& key : section.keys)
            if (key.key == name) return key.value;
        ADD_FAILURE() << name << " is not there";
        return std::optional<double>();
    };
    EXPECT_FALSE(value_of("track_width_m"));
    EXPECT_FALSE(value_of("turn_right_*"));
    EXPECT_NEAR(value_of("turn_left_slip_left").value_or(0), 0.3, 0.05);
    EXPECT_NEAR(value_of("straight_sigma_left_m").value_or(0), 0.002, 0.0015);
    for (const CalibratedKey& key : section.keys) EXPECT_NE(key.key, "turn_right_slip_left");
}

}  // namespace
