#include "line_slam/smoother.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "line_slam/pose_line_graph.h"

namespace loopline::line_slam {
namespace {

struct Wall {
    PlanarLine line;
    Extent extent;
    int observations = 0;
    int track = 0;
};

/// Walls by the present poses and pairings.
std::vector<Wall> walls_from(const History& history, const std::vector<Pose2>& poses,
                             const std::vector<std::vector<int>>& tracks,
                             const std::vector<PlanarLine>& line_of_track, int min_observations) {
    std::vector<int> count(line_of_track.size(), 0);
    std::vector<Extent> extent(line_of_track.size());
    for (std::size_t k = 0; k < poses.size(); ++k)
        for (std::size_t i = 0; i < tracks[k].size(); ++i) {
            const int t = tracks[k][i];
            if (t == no_track) continue;
            const auto u = static_cast<std::size_t>(t);
            const LineObservation& z = history.steps[k].observations[i];
            const Extent seen = Extent::of(line_of_track[u], poses[k] * z.start_m, poses[k] * z.end_m);
            if (count[u]++ == 0)
                extent[u] = seen;
            else
                extent[u].extend(seen);
        }
    std::vector<Wall> walls;
    for (std::size_t t = 0; t < count.size(); ++t)
        if (count[t] >= min_observations)
            walls.push_back({line_of_track[t], extent[t], count[t], static_cast<int>(t)});
    return walls;
}

}  // namespace

SmoothedMap smooth(const History& history, const SmootherParameters& parameters) {
    SmoothedMap result;
    const std::size_t n = history.steps.size();
    result.calibration = history.calibration;
    std::vector<std::vector<int>> tracks(n);
    for (std::size_t k = 0; k < n; ++k) {
        result.poses.push_back(history.steps[k].T_map_base);
        tracks[k] = history.steps[k].tracks;
    }
    if (n < 2) return result;
    std::vector<int> first_of(static_cast<std::size_t>(history.track_count));
    std::iota(first_of.begin(), first_of.end(), 0);
    const auto root = [&](int t) {
        while (first_of[static_cast<std::size_t>(t)] != t) t = first_of[static_cast<std::size_t>(t)];
        return t;
    };
    for (const auto& [a, b] : history.same_wall)
        first_of[static_cast<std::size_t>(std::max(root(a), root(b)))] = std::min(root(a), root(b));
    for (auto& of_scan : tracks)
        for (int& t : of_scan)
            if (t != no_track) t = root(t);

    // First value of a track: its latest observation, by the filter's pose then.
    std::vector<PlanarLine> line_of_track(static_cast<std::size_t>(history.track_count));
    for (std::size_t k = 0; k < n; ++k)
        for (std::size_t i = 0; i < tracks[k].size(); ++i)
            if (tracks[k][i] != no_track)
                line_of_track[static_cast<std::size_t>(tracks[k][i])] =
                    transformed(result.poses[k], history.steps[k].observations[i].line);

    for (int round = 0; round < parameters.rounds; ++round) {
        std::vector<Wall> walls =
            walls_from(history, result.poses, tracks, line_of_track, parameters.min_observations);
        std::vector<int> index_of_track(line_of_track.size(), -1);
        PoseLineGraph graph;
        graph.robust_scale = parameters.robust_scale;
        graph.poses = result.poses;
        graph.track_width_m = history.drive.track_width_m;
        graph.sigma_scale = history.drive.sigma_scale;
        graph.calibration = result.calibration;
        graph.motions.resize(n);
        for (std::size_t w = 0; w < walls.size(); ++w) {
            index_of_track[static_cast<std::size_t>(walls[w].track)] = static_cast<int>(w);
            graph.lines.push_back(walls[w].line);
        }
        for (std::size_t k = 0; k < n; ++k) {
            const HistoryStep& step = history.steps[k];
            if (k > 0) {
                const Eigen::Matrix3d G =
                    motion_jacobians(step.travel, history.drive.track_width_m, result.calibration).travel;
                const Eigen::Matrix3d Q = G * travel_covariance(step.travel, history.drive) * G.transpose();
                graph.motions[k] = {step.travel, Q.inverse()};
            }
            const std::size_t first = graph.observations.size();
            for (std::size_t i = 0; i < step.observations.size(); ++i) {
                const int w =
                    tracks[k][i] == no_track ? -1 : index_of_track[static_cast<std::size_t>(tracks[k][i])];
                if (w >= 0)
                    graph.observations.push_back({static_cast<int>(k), w, step.observations[i].line,
                                                  step.observations[i].covariance.inverse()});
            }
            std::stable_sort(graph.observations.begin() + static_cast<std::ptrdiff_t>(first),
                             graph.observations.end(),
                             [](const auto& a, const auto& b) { return a.line < b.line; });
        }
        GraphSolver solver(graph);
        const GraphSolver::Outcome outcome = solver.minimise(graph, parameters.max_iterations);
        if (round == 0) result.initial_cost = outcome.initial_cost;
        result.final_cost = outcome.final_cost;
        result.iterations += outcome.iterations;
        result.rounds = round + 1;
        result.poses = graph.poses;
        result.calibration = graph.calibration;
        for (std::size_t w = 0; w < walls.size(); ++w) {
            walls[w].line = graph.lines[w];
            line_of_track[static_cast<std::size_t>(walls[w].track)] = graph.lines[w];
        }
        walls = walls_from(history, result.poses, tracks, line_of_track, parameters.min_observations);
        result.good = true;
        result.lines.clear();
        for (const Wall& w : walls)
            result.lines.push_back({w.line, Eigen::Matrix2d::Zero(), w.extent, w.observations, w.track});
        const auto set_covariances = [&] {
            if (!solver.factorise(graph)) {
                result.good = false;
                return;
            }
            result.covariances = solver.pose_covariances();
            const std::vector<Eigen::Matrix2d> of_lines = solver.line_covariances();
            for (std::size_t w = 0; w < result.lines.size(); ++w) result.lines[w].covariance = of_lines[w];
        };
        if (round + 1 == parameters.rounds) {
            set_covariances();
            break;
        }

        // Merge: the shorter-seen wall joins the other if it lies on it.
        std::vector<std::size_t> order(walls.size());
        std::iota(order.begin(), order.end(), 0u);
        std::stable_sort(order.begin(), order.end(),
                         [&](auto a, auto b) { return walls[a].observations > walls[b].observations; });
        std::vector<int> parent(line_of_track.size());
        std::iota(parent.begin(), parent.end(), 0);
        bool changed = false;
        for (std::size_t a = 0; a < order.size(); ++a)
            for (std::size_t b = 0; b < a; ++b) {
                const Wall &small = walls[order[a]], &big = walls[order[b]];
                if (parent[static_cast<std::size_t>(big.track)] != big.track) continue;
                if (std::abs(wrap_to_pi(small.line.alpha_rad - big.line.alpha_rad)) > 0.15) continue;
                const Eigen::Vector2d p = small.line.point_m(small.extent.from_m),
                                      q = small.line.point_m(small.extent.to_m);
                if (big.extent.overlap_m(Extent::of(big.line, p, q)) < 0) continue;
                if (std::abs(big.line.signed_distance_m(p)) > parameters.merge_gate_m ||
                    std::abs(big.line.signed_distance_m(q)) > parameters.merge_gate_m)
                    continue;
                parent[static_cast<std::size_t>(small.track)] = big.track;
                changed = true;
                ++result.merged;
                break;
            }
        // New pairing.
        for (std::size_t k = 0; k < n; ++k)
            for (std::size_t i = 0; i < tracks[k].size(); ++i) {
                const LineObservation& z = history.steps[k].observations[i];
                int best = no_track;
                double least = parameters.association_gate;
                const Eigen::Vector2d p = result.poses[k] * z.start_m, q = result.poses[k] * z.end_m;
                for (const Wall& w : walls) {
                    if (parent[static_cast<std::size_t>(w.track)] != w.track) continue;
                    const double da =
                        wrap_to_pi(z.line.alpha_rad + result.poses[k].phi_rad - w.line.alpha_rad);
                    if (std::abs(da) > 0.3) continue;
                    if (std::abs(w.line.signed_distance_m(p)) > 1) continue;
                    if (w.extent.overlap_m(Extent::of(w.line, p, q)) < -parameters.max_gap_m) continue;
                    const Eigen::Vector2d v = innovation(z.line, predicted_line(result.poses[k], w.line));
                    const double d2 = v.dot(z.covariance.llt().solve(v));
                    if (d2 < least) {
                        least = d2;
                        best = w.track;
                    }
                }
                int old = tracks[k][i];
                if (best == no_track && old != no_track) best = parent[static_cast<std::size_t>(old)];
                if (best != old) changed = true;
                tracks[k][i] = best;
            }
        if (!changed) {
            set_covariances();
            break;
        }
    }
    return result;
}

}  // namespace loopline::line_slam
