#include "line_slam/assumed_drive.h"

#include <Eigen/LU>
#include <cmath>

namespace loopline::line_slam {
namespace {

/// Whether a piece that follows `before` begins a new stretch, which has got `way_m` so far.
bool begins_stretch(const DrivePiece& before, const DrivePiece& piece, double way_m) {
    return piece.regime != before.regime || way_m > longest_stretch_m;
}

/// Poses at steps and where the regime changes between two, with the pieces that lead there.
void add_motion(const std::vector<DrivePiece>& pieces, const Pose2& T_map_step, const AssumedDrive& assumed,
                double& stretch_m, CalibrationGraph& graph) {
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        int stretch = 0;
        if (graph.pieces.size() > 1) {
            const bool begins = begins_stretch(graph.pieces.back().drive, pieces[i], stretch_m);
            stretch = graph.pieces.back().stretch + (begins ? 1 : 0);
            if (begins) stretch_m = 0;
        }
        stretch_m += mean_way_m(pieces[i].rolled);
        const bool last = i + 1 == pieces.size();
        graph.poses.push_back(last ? T_map_step
                                   : graph.poses.back() *
                                         moved(assumed.over_ground(pieces[i]), assumed.track_width_m));
        graph.pieces.push_back({pieces[i], stretch});
    }
}

void add_observations(const HistoryStep& step, const std::vector<int>& tracks, const Pose2& T_map_step,
                      const std::vector<int>& line_of_track, double gate, CalibrationGraph& graph) {
    for (std::size_t i = 0; i < tracks.size(); ++i) {
        const int line = tracks[i] == no_track ? -1 : line_of_track[static_cast<std::size_t>(tracks[i])];
        if (line < 0) continue;
        const LineObservation& z = step.observations[i];
        const Eigen::Matrix2d information = (z.covariance + z.surplus).inverse();
        const Eigen::Vector2d v =
            innovation(z.line, predicted_line(T_map_step, graph.lines[static_cast<std::size_t>(line)]));
        if (v.dot(information * v) > gate) continue;
        graph.observations.push_back({static_cast<int>(graph.poses.size()) - 1, line, z.line, information});
    }
}

}  // namespace

WheelTravel AssumedDrive::over_ground(const DrivePiece& piece) const {
    return {(1 - of(slip, piece.regime, Wheel::left)) * piece.rolled.left_m,
            (1 - of(slip, piece.regime, Wheel::right)) * piece.rolled.right_m, piece.rolled.side_m};
}

Eigen::Matrix3d AssumedDrive::covariance(const DrivePiece& piece) const {
    const auto variance = [this](int component, double way_m) {
        return std::exp(log_variance(component)) * std::abs(way_m) + std::exp(log_variance(rest_noise));
    };
    return Eigen::Vector3d(variance(wheel_noise(piece.regime, Wheel::left), piece.rolled.left_m),
                           variance(wheel_noise(piece.regime, Wheel::right), piece.rolled.right_m),
                           variance(side_noise, mean_way_m(piece.rolled)))
        .asDiagonal();
}

History history_with(const AssumedDrive& assumed, const Drive& drive, const History& history,
                     const SmoothedPath& path) {
    History h = history;
    h.drive.track_width_m = assumed.track_width_m;
    for (std::size_t k = 0; k < h.steps.size(); ++k) {
        HistoryStep& step = h.steps[k];
        if (!path.poses.empty()) step.T_map_base = path.poses[k];
        step.travel_covariance.setZero();
        Pose2 T_previous_base;
        for (const DrivePiece& piece : drive[k]) {
            T_previous_base = T_previous_base * moved(assumed.over_ground(piece), assumed.track_width_m);
            step.travel_covariance += assumed.covariance(piece);
        }
        step.travel = wheel_travel(T_previous_base, assumed.track_width_m);
    }
    return h;
}

CalibrationGraph calibration_graph_of(const History& history, const SmoothedPath& path, const Drive& drive,
                                      const AssumedDrive& assumed, double gate) {
    CalibrationGraph graph;
    graph.track_width_m = assumed.track_width_m;
    graph.slip = assumed.slip;
    std::vector<int> line_of_track(static_cast<std::size_t>(history.track_count), -1);
    for (const SmoothedWall& w : path.walls) {
        line_of_track[static_cast<std::size_t>(w.wall.track)] = static_cast<int>(graph.lines.size());
        graph.lines.push_back(w.wall.line);
    }
    graph.poses.push_back(path.poses[0]);
    graph.pieces.emplace_back();
    double stretch_m = 0;
    for (std::size_t k = 0; k < path.poses.size(); ++k) {
        if (k > 0) add_motion(drive[k], path.poses[k], assumed, stretch_m, graph);
        add_observations(history.steps[k], path.pairings[k], path.poses[k], line_of_track, gate, graph);
    }
    graph.deviations.resize(static_cast<std::size_t>(graph.pieces.back().stretch) + 1);
    return graph;
}

}  // namespace loopline::line_slam
