#include "line_slam/likeliest_noise.h"

#include "api/dense_algebra.h"

namespace loopline::line_slam {

NoiseEstimate likeliest_noise(CalibrationSolver& solver, CalibrationGraph& graph, const NoiseVector& start,
                              const NoisePrior& prior) {
    constexpr int most_steps = 60, most_halvings = 8;
    constexpr double longest_step = 1, good_enough = 1e-3;
    NoiseEstimate e;
    e.log_variance = start;
    if (!solver.minimise(graph, e.log_variance)) return e;
    for (int i = 0; i < most_steps; ++i) {
        const auto now = solver.likelihood(graph, e.log_variance);
        const NoiseVector gradient = now.gradient - prior.information * (e.log_variance - prior.mean);
        e.covariance = solved(now.information + prior.information, NoiseMatrix::Identity());
        NoiseVector step = e.covariance * gradient;
        e.good = step.allFinite();
        if (!e.good || gradient.dot(step) < good_enough) return e;
        // Far from the maximum a parabola is a bad picture of the likelihood.
        step = step.cwiseMax(-longest_step).cwiseMin(longest_step);
        const double before = now.minus_two_log + prior.cost(e.log_variance);
        bool better = false;
        for (int h = 0; h < most_halvings && !better; ++h, step /= 2) {
            CalibrationGraph next = graph;
            const NoiseVector tried = e.log_variance + step;
            if (!solver.minimise(next, tried) ||
                solver.minus_two_log_likelihood(next, tried) + prior.cost(tried) >= before)
                continue;
            better = true;
            graph = std::move(next);
            e.log_variance = tried;
        }
        if (!better) return e;
    }
    return e;
}

}  // namespace loopline::line_slam
