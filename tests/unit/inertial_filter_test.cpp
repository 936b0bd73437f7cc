/// The filter on the error of inertial navigation: measurements against central differences, directions
/// without information, gates, checkpoints, and how far its covariance may be trusted, forward and in
/// reverse.
#include <gtest/gtest.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>

#include <functional>

#include "api/dense_algebra.h"
#include "api/state_archive.h"
#include "inertial/planar_updates.h"
#include "least_squares/chi_square.h"
#include "support/inertial_drive.h"

using namespace loopline;
using namespace loopline::inertial;

namespace {

NavigationState tilted_state() {
    NavigationState state;
    state.q_map_base = exp_so3({0.2, -0.3, 2});
    state.v_map_mps = {1, -2, 0.5};
    state.p_map_m = {10, 20, -5};
    state.gyro_bias_radps = {0.02, -0.01, 0.03};
    return state;
}

ErrorMatrix diagonal_covariance(double position_m, double velocity_mps, double attitude_rad,
                                double gyro_bias_radps, double accelerometer_bias_mps2) {
    ErrorVector sigma;
    sigma << Eigen::Vector3d::Constant(position_m), Eigen::Vector3d::Constant(velocity_mps),
        Eigen::Vector3d::Constant(attitude_rad), Eigen::Vector3d::Constant(gyro_bias_radps),
        Eigen::Vector3d::Constant(accelerometer_bias_mps2);
    return sigma.cwiseAbs2().asDiagonal();
}

/// H is minus the derivative of the innovation by the state.
void expect_H_is_derivative(const NavigationState& state,
                            const std::function<ErrorMeasurement(const NavigationState&)>& measurement) {
    constexpr double h = 1e-6;
    const auto m = measurement(state);
    for (int i = 0; i < error_size; ++i) {
        const ErrorVector e = h * ErrorVector::Unit(i);
        const Eigen::VectorXd numeric =
            (measurement(inject(state, -e)).innovation - measurement(inject(state, e)).innovation) / (2 * h);
        EXPECT_LT((m.H.col(i) - numeric).cwiseAbs().maxCoeff(), 1e-7) << "column " << i;
    }
}

const ImuPlace aside{{0.3, -0.2, 0.5}};

}  // namespace

TEST(InertialMeasurement, jacobians_are_the_derivatives_of_the_innovations) {
    const NavigationState state = tilted_state();
    const Eigen::Vector3d omega_radps(0.3, -0.4, 0.8);
    expect_H_is_derivative(state, [&](const NavigationState& s) {
        return pose_measurement(s, aside, Pose2{9, 21, 1.8}, Eigen::Matrix3d::Identity());
    });
    PlanarInformation match;
    match.T_map_base = {9, 21, 1.8};
    match.information << 400, 30, -20, 30, 100, 10, -20, 10, 2500;
    match.gradient << 3, -2, 5;
    expect_H_is_derivative(state,
                           [&](const NavigationState& s) { return pose_measurement(s, aside, match); });
    expect_H_is_derivative(
        state, [&](const NavigationState& s) { return level_floor_measurement(s, aside, LevelFloor()); });
    expect_H_is_derivative(state,
                           [&](const NavigationState& s) { return zero_velocity_measurement(s, 0.01); });
    for (const int axis : {0, 1})
        expect_H_is_derivative(state, [&](const NavigationState& s) {
            return base_speed_measurement(s, aside, omega_radps, axis, 0.7, 0.01);
        });
}

TEST(InertialMeasurement, information_and_gradient_say_the_same_as_pose_and_covariance) {
    const NavigationState state = tilted_state();
    Eigen::Matrix3d covariance;
    covariance << 4e-4, 1e-4, -2e-5, 1e-4, 9e-4, 3e-5, -2e-5, 3e-5, 1e-4;
    const Pose2 peak{10.1, 20.1, 1.9};
    PlanarInformation match;
    match.T_map_base = {10.05, 20.2, 1.85};  // where the matcher looked: not at its peak
    match.information = covariance.inverse();
    match.gradient =
        match.information * Eigen::Vector3d(peak.x_m - match.T_map_base.x_m, peak.y_m - match.T_map_base.y_m,
                                            peak.phi_rad - match.T_map_base.phi_rad);
    ErrorStateFilter by_covariance, by_information;
    const ErrorMatrix P = diagonal_covariance(0.1, 0.1, 0.05, 0.01, 0.1);
    by_covariance.start(state, P);
    by_information.start(state, P);
    const auto a = by_covariance.update(pose_measurement(state, aside, peak, covariance));
    const auto b = by_information.update(pose_measurement(state, aside, match));
    EXPECT_NEAR(a.nis, b.nis, 1e-9 * a.nis);
    EXPECT_LT(error_between(by_covariance.state(), by_information.state()).norm(), 1e-10);
    EXPECT_LT((by_covariance.covariance() - by_information.covariance()).norm(), 1e-10);
}

TEST(InertialMeasurement, a_corridor_leaves_the_way_along_it_alone) {
    NavigationState state;
    ErrorStateFilter filter;
    const ErrorMatrix P = diagonal_covariance(0.5, 0.1, 0.05, 0.01, 0.1);
    filter.start(state, P);
    const Eigen::Vector3d along(std::cos(0.5), std::sin(0.5), 0), across(-along.y(), along.x(), 0);
    PlanarInformation corridor;
    corridor.information = 1e4 * across * across.transpose();
    corridor.information(2, 2) = 1e5;
    corridor.gradient =
        corridor.information * (0.2 * across + 7 * along);  // what noise says along it is lost
    const auto result = filter.update(pose_measurement(state, {}, corridor));
    EXPECT_TRUE(result.accepted());
    EXPECT_EQ(result.degrees_of_freedom, 2);
    EXPECT_NEAR(filter.state().p_map_m.dot(across), 0.2, 1e-3);
    EXPECT_NEAR(filter.state().p_map_m.dot(along), 0, 1e-12);
    const Eigen::Matrix3d cov_p = filter.covariance().topLeftCorner<3, 3>();
    EXPECT_NEAR(along.dot(cov_p * along), 0.25, 1e-12);
    EXPECT_NEAR(across.dot(cov_p * across), 1e-4, 1e-6);
}

TEST(InertialMeasurement, an_empty_match_changes_nothing) {
    ErrorStateFilter filter;
    filter.start(tilted_state(), diagonal_covariance(0.5, 0.1, 0.05, 0.01, 0.1));
    const auto result = filter.update(pose_measurement(filter.state(), {}, PlanarInformation()));
    EXPECT_EQ(result.status, UpdateResult::Status::empty);
    EXPECT_EQ(filter.state().p_map_m, tilted_state().p_map_m);
}

TEST(InertialFilter, the_gate_refuses_outliers_and_bad_numbers_without_a_trace) {
    ErrorStateFilter filter;
    filter.start({}, diagonal_covariance(0.1, 0.1, 0.05, 0.01, 0.1));
    const ErrorMatrix before = filter.covariance();
    const Eigen::Matrix3d R = 1e-4 * Eigen::Matrix3d::Identity();
    const auto far = filter.update(pose_measurement(filter.state(), {}, Pose2{2, 0, 0}, R), 0.999);
    EXPECT_EQ(far.status, UpdateResult::Status::gated);
    EXPECT_NEAR(far.nis, 4 / (0.01 + 1e-4), 1e-9);
    const auto nan = filter.update(pose_measurement(filter.state(), {}, Pose2{std::nan(""), 0, 0}, R));
    EXPECT_EQ(nan.status, UpdateResult::Status::unusable);
    const auto negative = filter.update(pose_measurement(filter.state(), {}, Pose2{0, 0, 0}, -R * 1e4));
    EXPECT_EQ(negative.status, UpdateResult::Status::unusable);
    EXPECT_EQ(filter.covariance(), before);
    EXPECT_EQ(filter.state().p_map_m, Eigen::Vector3d::Zero());
    EXPECT_TRUE(filter.update(pose_measurement(filter.state(), {}, Pose2{0.2, 0, 0}, R), 0.999).accepted());
}

TEST(InertialFilter, gates_pass_what_they_promise) {
    // Exact quantiles of chi-square.
    const struct {
        int n;
        double probability, quantile;
    } table[] = {{1, 0.95, 3.841},  {1, 0.99, 6.635},   {1, 0.999, 10.828}, {2, 0.99, 9.210},
                 {3, 0.99, 11.345}, {3, 0.999, 16.266}, {15, 0.95, 24.996}};
    for (const auto& row : table)
        EXPECT_NEAR(least_squares::chi_square_quantile(row.n, row.probability) / row.quantile, 1, 0.02)
            << row.n;
}

TEST(InertialFilter, reverse_prediction_takes_back_a_forward_one_without_noise) {
    std::mt19937_64 random(6);
    const auto run = test::simulate_imu({}, 20, 100, ImuNoise(), {}, random);
    ErrorStateFilter filter({}, {{0, 0}, {0, 0}});
    const ErrorMatrix P = diagonal_covariance(0.1, 0.1, 0.02, 0.001, 0.05);
    filter.start(run.truth.front(), P);
    for (std::size_t i = 1; i < run.samples.size(); ++i)
        filter.predict_forward(run.samples[i - 1], run.samples[i]);
    EXPECT_GT(filter.covariance()(0, 0), 1);
    for (std::size_t i = run.samples.size() - 1; i > 0; --i)
        filter.predict_reverse(run.samples[i - 1], run.samples[i]);
    EXPECT_LT((filter.covariance() - P).cwiseAbs().maxCoeff(), 1e-8);
    EXPECT_LT(error_between(filter.state(), run.truth.front()).norm(), 1e-10);
}

TEST(InertialFilter, goes_on_from_a_checkpoint_bit_for_bit) {
    ErrorStateFilter filter, restored;
    filter.start(tilted_state(), diagonal_covariance(0.1, 0.2, 0.3, 0.4, 0.5));
    mrpt::io::CMemoryStream stream;
    auto archive = mrpt::serialization::archiveFrom(stream);
    write_state(archive, "filter", 1, filter);
    stream.Seek(0);
    read_state(archive, "filter", 1, restored);
    EXPECT_EQ(restored.covariance(), filter.covariance());
    EXPECT_EQ(restored.state().q_map_base.coeffs(), filter.state().q_map_base.coeffs());
    EXPECT_EQ(restored.state().gyro_bias_radps, filter.state().gyro_bias_radps);
}

namespace {

/// Draws from a normal distribution.
struct Draws {
    std::mt19937_64 random;
    std::normal_distribution<double> normal;
    explicit Draws(std::uint64_t seed) : random(seed) {}
    double operator()(double sigma) { return sigma * normal(random); }
};

/// A measurement of `truth` by a filter: nothing but its innovation tells it.
using Measure =
    std::function<void(ErrorStateFilter&, const NavigationState& truth, const ImuSample& reading, Draws&)>;

void measure_pose(ErrorStateFilter& filter, const NavigationState& truth, const ImuSample&, Draws& draw) {
    const Eigen::Vector3d sigma(0.02, 0.03, 0.01);
    const Pose2 pose = base_pose(truth, aside).planar();
    const Pose2 measured{pose.x_m + draw(sigma(0)), pose.y_m + draw(sigma(1)),
                         wrap_to_pi(pose.phi_rad + draw(sigma(2)))};
    const Eigen::Matrix3d covariance = sigma.cwiseAbs2().asDiagonal();
    filter.update(pose_measurement(filter.state(), aside, measured, covariance));
}

/// Wheels that roll and do not slide, on a floor: their noise about the truth of the drive, which is of the
/// IMU's place.
void measure_wheels_and_floor(ErrorStateFilter& filter, const NavigationState& truth,
                              const ImuSample& reading, Draws& draw) {
    constexpr double sigma_mps = 0.02;
    const Eigen::Vector3d v_mps = base_velocity_mps(truth, aside, reading.omega_base_radps);
    for (const int axis : {0, 1})
        filter.update(base_speed_measurement(filter.state(), aside, reading.omega_base_radps, axis,
                                             v_mps(axis) + draw(sigma_mps), sigma_mps));
    LevelFloor floor;
    floor.height_map_m = base_pose(truth, aside).translation_m.z() + draw(floor.sigma_height_m);
    auto m = level_floor_measurement(filter.state(), aside, floor);
    m.innovation(1) += truth.v_map_mps.z() + draw(floor.sigma_climb_mps);
    filter.update(m);
}

/// Mean over seeded drives of the normalised error squared, e' P^-1 e, at a few times of each; 15 if P is
/// right.
struct Trust {
    static constexpr int drives = 50;
    static constexpr double duration_s = 20, rate_hz = 100, measure_every_s = 0.2;
    static constexpr std::size_t looks = 4;  ///< at 5, 10, 15 and 20 s after the start of the pass
    enum class Way { forward, reverse };

    std::vector<double> nees;

    Trust(Way way, const Measure& measure, double sigma_gyro_bias_radps = 0.01)
        : nees(looks, 0), sigma_gyro_bias_radps_(sigma_gyro_bias_radps) {
        for (int drive = 0; drive < drives; ++drive) add(drive, way, measure);
        for (double& mean : nees) mean /= drives;
    }

 private:
    double sigma_gyro_bias_radps_;
    const ImuNoise noise{{1e-3, 2e-4}, {1e-2, 2e-3}};

    void add(int drive, Way way, const Measure& measure) {
        Draws draw(1000 + static_cast<std::uint64_t>(drive));
        NavigationState start;
        start.gyro_bias_radps = {0.01, -0.02, 0.015};
        start.accelerometer_bias_mps2 = {0.1, -0.05, 0.08};
        const auto run = test::simulate_imu({}, duration_s, rate_hz, noise, start, draw.random);
        const std::size_t last = run.samples.size() - 1;
        const std::size_t first = way == Way::forward ? 0 : last;

        const ErrorMatrix P = diagonal_covariance(0.05, 0.05, 0.02, sigma_gyro_bias_radps_, 0.1);
        ErrorVector error;
        for (int i = 0; i < error_size; ++i) error(i) = draw(std::sqrt(P(i, i)));
        ErrorStateFilter filter({}, noise);
        filter.start(inject(run.truth[first], error), P);

        for (std::size_t step = 1; step <= last; ++step) {
            const std::size_t at = way == Way::forward ? step : last - step;
            if (way == Way::forward)
                filter.predict_forward(run.samples[at - 1], run.samples[at]);
            else
                filter.predict_reverse(run.samples[at], run.samples[at + 1]);
            if (step % std::lround(measure_every_s * rate_hz) == 0)
                measure(filter, run.truth[at], run.samples[at], draw);
            if (step % (last / looks) == 0) {
                const ErrorVector e = error_between(filter.state(), run.truth[at]);
                nees[step / (last / looks) - 1] += squared_in_sigmas(e, filter.covariance());
            }
        }
    }
};

/// The mean over n drives of a chi-square of 15 degrees has a standard deviation of sqrt(2 * 15 / n).
void expect_trusty(const Trust& trust) {
    const double band = 1.96 * std::sqrt(2.0 * error_size / Trust::drives);
    for (const double nees : trust.nees) EXPECT_NEAR(nees, error_size, band);
}

}  // namespace

TEST(InertialFilter, covariance_may_be_trusted_forward) {
    expect_trusty(Trust(Trust::Way::forward, measure_pose));
}

TEST(InertialFilter, covariance_may_be_trusted_in_reverse) {
    expect_trusty(Trust(Trust::Way::reverse, measure_pose));
}

TEST(InertialFilter, covariance_may_be_trusted_with_wheels_and_a_floor_alone) {
    // Nothing sees the heading: with the gyro's bias as an alignment leaves it, it stays small enough to be
    // linear in.
    expect_trusty(Trust(Trust::Way::forward, measure_wheels_and_floor, 1e-3));
}
