#include "line_slam/smoother.h"

#include <Eigen/LU>
#include <algorithm>

#include "line_slam/pose_line_graph.h"

namespace loopline::line_slam {
namespace {

PoseLineGraph graph_of(const History& history, const SmoothedPath& path, const Pairings& pairings,
                       const std::vector<Wall>& walls, double robust_scale) {
    PoseLineGraph graph;
    graph.loss = CauchyLoss(robust_scale);
    graph.poses = path.poses;
    graph.calibration = path.calibration;
    graph.track_width_m = history.drive.track_width_m;
    graph.sigma_scale = history.drive.sigma_scale;
    std::vector<int> line_of_track(static_cast<std::size_t>(history.track_count), -1);
    for (const Wall& w : walls) {
        line_of_track[static_cast<std::size_t>(w.track)] = static_cast<int>(graph.lines.size());
        graph.lines.push_back(w.line);
    }
    for (std::size_t k = 0; k < history.steps.size(); ++k) {
        const HistoryStep& step = history.steps[k];
        graph.motions.push_back({step.travel, step.travel_covariance.inverse()});
        const auto first = static_cast<std::ptrdiff_t>(graph.observations.size());
        for (std::size_t i = 0; i < step.observations.size(); ++i) {
            const int track = pairings[k][i];
            const int line = track == no_track ? -1 : line_of_track[static_cast<std::size_t>(track)];
            if (line < 0) continue;
            const LineObservation& z = step.observations[i];
            graph.observations.push_back(
                {static_cast<int>(k), line, z.line, (z.covariance + z.surplus).inverse()});
        }
        std::stable_sort(graph.observations.begin() + first, graph.observations.end(),
                         [](const auto& a, const auto& b) { return a.line < b.line; });
    }
    return graph;
}

}  // namespace

SmoothedPath smooth(const History& history, const SmootherParameters& parameters) {
    SmoothedPath path;
    if (history.steps.size() < 2) return path;
    for (const HistoryStep& step : history.steps) path.poses.push_back(step.T_map_base);
    path.calibration = history.calibration;
    path.pairings = filter_pairings(history);
    Pairings& pairings = path.pairings;
    std::vector<PlanarLine> line_of_track = latest_lines(history, path.poses, pairings);

    bool last = false;
    while (!last) {
        ++path.rounds;
        std::vector<Wall> walls =
            walls_of(history, path.poses, pairings, line_of_track, parameters.min_observations);
        PoseLineGraph graph = graph_of(history, path, pairings, walls, parameters.robust_scale);
        GraphSolver solver(graph);
        last = path.rounds >= parameters.rounds;
        const auto minimise = [&](int max_iterations) {
            const GraphSolver::Outcome outcome = solver.minimise(graph, max_iterations);
            if (path.iterations == 0) path.initial_cost = outcome.initial_cost;
            path.iterations += outcome.iterations;
            path.final_cost = outcome.final_cost;
            path.poses = graph.poses;
            path.calibration = graph.calibration;
            for (std::size_t w = 0; w < walls.size(); ++w)
                line_of_track[static_cast<std::size_t>(walls[w].track)] = graph.lines[w];
            walls = walls_of(history, path.poses, pairings, line_of_track, parameters.min_observations);
        };
        if (!last) {
            minimise(parameters.early_iterations);
            const std::vector<int> merged =
                merged_tracks(walls, history.track_count, parameters.merge_distance_m);
            last = !pair_again(history, path.poses, walls, merged, parameters.pairing, pairings);
            if (!last) continue;
        }
        minimise(parameters.last_iterations);
        path.good = solver.factorise(graph);
        if (!path.good) break;
        path.covariances = solver.pose_covariances();
        const std::vector<Eigen::Matrix2d> of_lines = solver.line_covariances();
        for (std::size_t w = 0; w < walls.size(); ++w) path.walls.push_back({walls[w], of_lines[w]});
    }
    return path;
}

}  // namespace loopline::line_slam
