#include "line_slam/calibration.h"

#include <cmath>

#include "line_slam/likeliest_noise.h"

namespace loopline::line_slam {
namespace {

constexpr double as_stated = 1e-9, unknown_track = 1;  ///< standard deviations of the track a priori
constexpr double no_scatter = -30;                     ///< logarithm of a variance that is as good as none

double log_variance_of(double sigma) {
    return 2 * std::log(sigma);
}

double log_information_of(double factor) {
    return 1 / std::pow(2 * std::log(factor), 2);
}

AssumedDrive presumed(const DriveParameters& drive, const CalibrationParameters& p) {
    AssumedDrive a;
    a.track_width_m = drive.track_width_m;
    for (const Regime regime : all_regimes) {
        const RegimeParameters& known = p.regimes[static_cast<std::size_t>(regime)];
        a.slip[static_cast<std::size_t>(regime)] = {known.slip_left, known.slip_right};
        const WheelValues sigma_m{known.sigma_left_m, known.sigma_right_m};
        for (const Wheel wheel : both_wheels) {
            a.log_variance(wheel_noise(regime, wheel)) =
                log_variance_of(of(sigma_m, wheel) > 0 ? of(sigma_m, wheel) : drive.sigma_wheel_m);
            a.log_variance(slip_scatter(regime, wheel)) = log_variance_of(p.likely_scatter);
        }
    }
    a.log_variance(side_noise) = log_variance_of(drive.sigma_side_m);
    a.log_variance(rest_noise) = log_variance_of(p.likely_rest_m);
    return a;
}

/// Of two wheels, the mean of their logarithms and half the difference are presumed independently.
NoisePrior prior_of(const NoiseVector& mean, const CalibrationParameters& p) {
    NoisePrior prior;
    prior.mean = mean;
    const double of_mean = 0.25 * log_information_of(p.factor_noise),
                 of_half_difference = 0.25 * log_information_of(p.factor_wheels);
    for (const Regime regime : all_regimes)
        for (const Wheel wheel : both_wheels) {
            const int own = wheel_noise(regime, wheel), scatter = slip_scatter(regime, wheel);
            for (const Wheel second : both_wheels)
                prior.information(own, wheel_noise(regime, second)) =
                    of_mean + (second == wheel ? of_half_difference : -of_half_difference);
            prior.information(scatter, scatter) = log_information_of(p.factor_scatter);
        }
    prior.information(side_noise, side_noise) = log_information_of(p.factor_noise);
    prior.information(rest_noise, rest_noise) = log_information_of(p.factor_rest);
    return prior;
}

/// As if there were no scatter of slip.
NoiseEstimate likeliest_white_noise(CalibrationSolver& solver, CalibrationGraph graph, NoiseVector start,
                                    NoisePrior prior) {
    for (const Regime regime : all_regimes)
        for (const Wheel wheel : both_wheels) {
            const int at = slip_scatter(regime, wheel);
            start(at) = prior.mean(at) = no_scatter;
            prior.information(at, at) = 1e6;
        }
    return likeliest_noise(solver, graph, start, prior);
}

/// Standard error of the track if nothing were presumed of it. Only slip that is the same at every curvature
/// tells the two apart, so the log may say next to nothing.
double track_error_by_the_log(CalibrationSolver& solver, CalibrationGraph graph,
                              const NoiseVector& log_variance) {
    graph.sigma_track = unknown_track;
    return std::sqrt(solver.scale_covariance(graph, log_variance)(track_scale, track_scale));
}

void tell_scales(const CalibrationGraph& graph, const CalibrationSolver::ScaleMatrix& covariance,
                 DriveCalibration& result) {
    for (const Regime regime : all_regimes)
        for (const Wheel wheel : both_wheels) {
            const int at = wheel_noise(regime, wheel);
            result.wheels[static_cast<std::size_t>(regime)][static_cast<std::size_t>(wheel)].slip = {
                of(graph.slip, regime, wheel), std::sqrt(covariance(at, at))};
        }
    result.track_width_m = {(1 + graph.track) * graph.track_width_m,
                            std::sqrt(covariance(track_scale, track_scale)) * graph.track_width_m};
    result.delay_s = {graph.delay_s, std::sqrt(covariance(delay_scale, delay_scale))};
}

Estimate sigma_of(const NoiseEstimate& e, int at) {
    const double value = std::exp(0.5 * e.log_variance(at));
    return {value, 0.5 * value * std::sqrt(e.covariance(at, at))};
}

/// White noise with which a stretch of `way_m` has the variance that random way and scatter of slip give it
/// together.
Estimate sigma_of_whole_stretch(const NoiseEstimate& e, int random_way, int scatter, double way_m) {
    const double by_way_m = std::exp(e.log_variance(random_way)),
                 by_scatter_m = std::exp(e.log_variance(scatter)) * way_m;
    const double variance_m = by_way_m + by_scatter_m;
    const double error2 = by_way_m * by_way_m * e.covariance(random_way, random_way) +
                          by_scatter_m * by_scatter_m * e.covariance(scatter, scatter) +
                          2 * by_way_m * by_scatter_m * e.covariance(random_way, scatter);
    return {std::sqrt(variance_m), 0.5 * std::sqrt(error2 / variance_m)};
}

/// Full: with the scatter of slip; white: without.
void tell_noise(const NoiseEstimate& full, const NoiseEstimate& white, DriveCalibration& result) {
    for (const Regime regime : all_regimes)
        for (const Wheel wheel : both_wheels) {
            WheelEstimate& e =
                result.wheels[static_cast<std::size_t>(regime)][static_cast<std::size_t>(wheel)];
            const int random_way = wheel_noise(regime, wheel), scatter = slip_scatter(regime, wheel);
            e.random_way_m = sigma_of(full, random_way);
            e.scatter = sigma_of(full, scatter);
            const RegimeAmount& amount = result.amounts[static_cast<std::size_t>(regime)];
            e.sigma_m = e.scatter_is_told() ? sigma_of_whole_stretch(full, random_way, scatter,
                                                                     of(amount.rolled_at_once_m, wheel))
                                            : sigma_of(white, random_way);
        }
    result.sigma_side_m = sigma_of(full, side_noise);
    result.sigma_rest_m = sigma_of(full, rest_noise);
}

bool has_settled(const DriveCalibration& before, const DriveCalibration& now, double part) {
    for (const Regime regime : all_regimes)
        for (const Wheel wheel : both_wheels) {
            const Estimate &a = before.wheel(regime, wheel).slip, &b = now.wheel(regime, wheel).slip;
            if (std::abs(a.value - b.value) > part * b.standard_error) return false;
        }
    return before.track_told == now.track_told;
}

/// One round: the likeliest slip and noise for the path and the pairings that `assumed` leads to, which take
/// the place of `assumed`. The noise is found for the stated track width first, since with a noise far off,
/// anything may pass for a track width.
DriveCalibration calibrate_once(const History& history, const Drive& drive, const CalibrationParameters& p,
                                const NoisePrior& prior, SmoothedPath& path, AssumedDrive& assumed) {
    DriveCalibration result;
    path = smooth(history_with(assumed, drive, history, path), p.smoother);
    if (!path.good) return result;
    CalibrationGraph graph = graph_of_drive(history, path, drive, assumed, p.graph);
    CalibrationSolver solver(graph);
    graph.sigma_track = as_stated;
    NoiseEstimate noise = likeliest_noise(solver, graph, assumed.log_variance, prior);
    if (!noise.good) return result;
    const double track_error = track_error_by_the_log(solver, graph, noise.log_variance);
    result.track_told = track_error < p.track_told * history.drive.sigma_scale;
    if (result.track_told) {
        graph.sigma_track = unknown_track;
        noise = likeliest_noise(solver, graph, noise.log_variance, prior);
        if (!noise.good) return result;
    }
    const NoiseEstimate white = likeliest_white_noise(solver, graph, noise.log_variance, prior);
    result.good = white.good;
    tell_scales(graph, solver.scale_covariance(graph, noise.log_variance), result);
    if (!result.track_told) result.track_width_m.standard_error = track_error * graph.track_width_m;
    result.amounts = amounts_of(graph.pieces);
    tell_noise(noise, white, result);
    assumed = {graph.slip, result.track_width_m.value, noise.log_variance};
    return result;
}

}  // namespace

DriveCalibration calibrate_drive(const History& history, const Drive& drive, const CalibrationParameters& p) {
    AssumedDrive assumed = presumed(history.drive, p);
    const NoisePrior prior = prior_of(assumed.log_variance, p);
    SmoothedPath path;
    DriveCalibration result;
    for (int round = 1; round <= p.rounds; ++round) {
        const bool had_track = result.track_told;
        DriveCalibration next = calibrate_once(history, drive, p, prior, path, assumed);
        next.rounds = round;
        if (!next.good) return next;
        // A better path may show that the track width was not told after all.
        if (had_track && !next.track_told) assumed.track_width_m = history.drive.track_width_m;
        const bool settled = result.good && has_settled(result, next, p.settled);
        result = next;
        if (settled) break;
    }
    return result;
}

}  // namespace loopline::line_slam
