#include "line_slam/wall_map.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "line_slam/line_observation.h"

namespace loopline::line_slam {
namespace {

constexpr double same_direction_rad = 0.15;
constexpr double sight_angle_rad = 0.3, sight_distance_m = 1.0;

std::size_t index(int i) {
    return static_cast<std::size_t>(i);
}

}  // namespace

Pairings filter_pairings(const History& history) {
    std::vector<int> parent(index(history.track_count));
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](int t) {
        while (parent[index(t)] != t) t = parent[index(t)];
        return t;
    };
    for (const auto& [a, b] : history.same_wall)
        parent[index(std::max(root(a), root(b)))] = std::min(root(a), root(b));
    Pairings pairings;
    for (const HistoryStep& step : history.steps) {
        pairings.push_back(step.tracks);
        for (int& t : pairings.back())
            if (t != no_track) t = root(t);
    }
    return pairings;
}

std::vector<PlanarLine> latest_lines(const History& history, const std::vector<Pose2>& poses,
                                     const Pairings& pairings) {
    std::vector<PlanarLine> lines(index(history.track_count));
    for (std::size_t k = 0; k < poses.size(); ++k)
        for (std::size_t i = 0; i < pairings[k].size(); ++i)
            if (pairings[k][i] != no_track)
                lines[index(pairings[k][i])] = transformed(poses[k], history.steps[k].observations[i].line);
    return lines;
}

std::vector<Wall> walls_of(const History& history, const std::vector<Pose2>& poses, const Pairings& pairings,
                           const std::vector<PlanarLine>& line_of_track, int min_observations) {
    std::vector<int> count(line_of_track.size(), 0);
    std::vector<Extent> extent(line_of_track.size());
    std::vector<Eigen::Vector2d> tangent;
    for (const PlanarLine& l : line_of_track) tangent.push_back(l.tangent());
    for (std::size_t k = 0; k < poses.size(); ++k)
        for (std::size_t i = 0; i < pairings[k].size(); ++i) {
            if (pairings[k][i] == no_track) continue;
            const std::size_t t = index(pairings[k][i]);
            const LineObservation& z = history.steps[k].observations[i];
            const double a_m = tangent[t].dot(poses[k] * z.start_m), b_m = tangent[t].dot(poses[k] * z.end_m);
            const Extent seen{std::min(a_m, b_m), std::max(a_m, b_m)};
            if (count[t]++ == 0)
                extent[t] = seen;
            else
                extent[t].extend(seen);
        }
    std::vector<Wall> walls;
    for (std::size_t t = 0; t < count.size(); ++t)
        if (count[t] >= min_observations)
            walls.push_back({line_of_track[t], extent[t], count[t], static_cast<int>(t)});
    return walls;
}

std::vector<int> merged_tracks(const std::vector<Wall>& walls, int track_count, double distance_m) {
    std::vector<int> merged(index(track_count));
    std::iota(merged.begin(), merged.end(), 0);
    std::vector<const Wall*> order;
    for (const Wall& w : walls) order.push_back(&w);
    std::stable_sort(order.begin(), order.end(),
                     [](const Wall* a, const Wall* b) { return a->observations > b->observations; });
    for (std::size_t b = 1; b < order.size(); ++b) {
        const Wall& small = *order[b];
        const Eigen::Vector2d from = small.line.point_m(small.extent.from_m),
                              to = small.line.point_m(small.extent.to_m);
        for (std::size_t a = 0; a < b; ++a) {
            const Wall& big = *order[a];
            if (merged[index(big.track)] != big.track ||
                std::abs(wrap_to_pi(small.line.alpha_rad - big.line.alpha_rad)) > same_direction_rad)
                continue;
            if (std::abs(big.line.signed_distance_m(from)) > distance_m ||
                std::abs(big.line.signed_distance_m(to)) > distance_m ||
                big.extent.overlap_m(Extent::of(big.line, from, to)) < 0)
                continue;
            merged[index(small.track)] = big.track;
            break;
        }
    }
    return merged;
}

bool pair_again(const History& history, const std::vector<Pose2>& poses, const std::vector<Wall>& walls,
                const std::vector<int>& merged, const PairingParameters& parameters, Pairings& pairings) {
    struct Sight {
        const Wall* wall;
        Eigen::Vector2d normal, tangent;
    };
    std::vector<Sight> sights;
    for (const Wall& w : walls)
        if (merged[index(w.track)] == w.track) sights.push_back({&w, w.line.normal(), w.line.tangent()});

    bool changed = false;
    for (std::size_t k = 0; k < poses.size(); ++k)
        for (std::size_t i = 0; i < pairings[k].size(); ++i) {
            const LineObservation& z = history.steps[k].observations[i];
            const Eigen::Vector2d start_m = poses[k] * z.start_m, end_m = poses[k] * z.end_m;
            int best = no_track;
            double least = parameters.gate;
            for (const Sight& s : sights) {
                const double rho_m = s.wall->line.rho_m;
                if (std::abs(s.normal.dot(start_m) - rho_m) > sight_distance_m ||
                    std::abs(s.normal.dot(end_m) - rho_m) > sight_distance_m)
                    continue;
                const double a_m = s.tangent.dot(start_m), b_m = s.tangent.dot(end_m);
                if (s.wall->extent.overlap_m({std::min(a_m, b_m), std::max(a_m, b_m)}) <
                    -parameters.max_gap_m)
                    continue;
                const Eigen::Vector2d v = innovation(z.line, predicted_line(poses[k], s.wall->line));
                if (std::abs(v.y()) > sight_angle_rad) continue;
                const double distance2 = v.dot(z.covariance.llt().solve(v));
                if (distance2 < least) {
                    least = distance2;
                    best = s.wall->track;
                }
            }
            const int before = pairings[k][i];
            if (best == no_track && before != no_track) best = merged[index(before)];
            changed = changed || best != before;
            pairings[k][i] = best;
        }
    return changed;
}

}  // namespace loopline::line_slam
