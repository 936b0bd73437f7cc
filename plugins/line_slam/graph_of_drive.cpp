#include "line_slam/graph_of_drive.h"

#include <Eigen/LU>
#include <algorithm>

namespace loopline::line_slam {
namespace {

class Builder {
 public:
    Builder(const History& history, const SmoothedPath& path, const Drive& drive, const AssumedDrive& assumed,
            const DriveGraphParameters& parameters)
        : history_(history), path_(path), drive_(drive), assumed_(assumed), parameters_(parameters) {
        graph_.track_width_m = assumed.track_width_m;
        graph_.slip = assumed.slip;
        wall_of_track_.resize(static_cast<std::size_t>(history.track_count), -1);
        for (const SmoothedWall& w : path.walls) {
            wall_of_track_[static_cast<std::size_t>(w.wall.track)] = static_cast<int>(graph_.lines.size());
            graph_.lines.push_back(w.wall.line);
        }
        patches_.resize(graph_.lines.size());
        std::vector<double> durations_s;
        for (const auto& pieces : drive) durations_s.push_back(duration_of(pieces));
        std::nth_element(durations_s.begin(), durations_s.begin() + durations_s.size() / 2,
                         durations_s.end());
        usual_duration_s_ = durations_s[durations_s.size() / 2];
    }

    CalibrationGraph build() {
        graph_.poses.push_back(path_.poses[0]);
        graph_.velocities.emplace_back();
        graph_.pieces.emplace_back();
        for (std::size_t k = 0; k < path_.poses.size(); ++k) {
            if (k > 0) add_motion(drive_[k], path_.poses[k]);
            add_observations(k);
        }
        graph_.deviations.resize(static_cast<std::size_t>(graph_.pieces.back().stretch) + 1);
        return std::move(graph_);
    }

 private:
    struct Patch {
        int line = -1;
        double from_m = 0;  ///< of the path
    };

    static double duration_of(const std::vector<DrivePiece>& pieces) {
        double duration_s = 0;
        for (const DrivePiece& piece : pieces) duration_s += piece.duration_s;
        return duration_s;
    }

    /// Poses at steps and where the regime changes between two, with the pieces that lead there.
    void add_motion(const std::vector<DrivePiece>& pieces, const Pose2& T_map_step) {
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            const int stretch = stretch_of(pieces[i]);
            path_m_ += mean_way_m(pieces[i].rolled);
            const bool last = i + 1 == pieces.size();
            graph_.poses.push_back(last ? T_map_step
                                        : graph_.poses.back() *
                                              moved(assumed_.over_ground(pieces[i]), assumed_.track_width_m));
            graph_.velocities.push_back(last ? velocity_at_end(pieces) : Twist2{});
            graph_.pieces.push_back({pieces[i], stretch});
        }
    }

    /// None where the log's times make no sense.
    Twist2 velocity_at_end(const std::vector<DrivePiece>& pieces) const {
        if (duration_of(pieces) < 0.25 * usual_duration_s_ || pieces.back().duration_s <= 0) return {};
        const DrivePiece& last = pieces.back();
        return log_se2(moved(assumed_.over_ground(last), assumed_.track_width_m)) * (1 / last.duration_s);
    }

    int stretch_of(const DrivePiece& piece) {
        if (graph_.pieces.size() == 1) return 0;
        const CalibrationGraph::Piece& before = graph_.pieces.back();
        const bool goes_on =
            piece.regime == before.drive.regime && path_m_ - stretch_from_m_ < parameters_.longest_stretch_m;
        if (goes_on) return before.stretch;
        stretch_from_m_ = path_m_;
        return before.stretch + 1;
    }

    void add_observations(std::size_t step) {
        const std::vector<int>& tracks = path_.pairings[step];
        for (std::size_t i = 0; i < tracks.size(); ++i) {
            const int wall = tracks[i] == no_track ? -1 : wall_of_track_[static_cast<std::size_t>(tracks[i])];
            if (wall < 0) continue;
            const LineObservation& z = history_.steps[step].observations[i];
            const Eigen::Vector2d v = innovation(
                z.line, predicted_line(path_.poses[step], graph_.lines[static_cast<std::size_t>(wall)]));
            if (v.dot(z.covariance.inverse() * v) > parameters_.gate) continue;
            const int pose = static_cast<int>(graph_.poses.size()) - 1;
            graph_.observations.push_back({pose, patch_of(wall, path_.poses[step], z), z.line,
                                           (z.covariance - z.wall_covariance).inverse()});
        }
    }

    /// The line that is seen of this wall here.
    int patch_of(int wall, const Pose2& T_map_base, const LineObservation& z) {
        if (z.wall_covariance.determinant() <= 0) return wall;  // perfectly straight
        Patch& patch = patches_[static_cast<std::size_t>(wall)];
        if (patch.line >= 0 && path_m_ - patch.from_m < parameters_.wall_correlation_m) return patch.line;
        const PlanarLine line = graph_.lines[static_cast<std::size_t>(wall)];
        const Eigen::Matrix2d to_map = augmentation_jacobians(T_map_base, line).observation;
        patch = {static_cast<int>(graph_.lines.size()), path_m_};
        graph_.ties.push_back(
            {wall, patch.line, (to_map * z.wall_covariance * to_map.transpose()).inverse()});
        graph_.lines.push_back(line);
        return patch.line;
    }

    const History& history_;
    const SmoothedPath& path_;
    const Drive& drive_;
    const AssumedDrive& assumed_;
    const DriveGraphParameters& parameters_;
    CalibrationGraph graph_;
    std::vector<int> wall_of_track_;
    std::vector<Patch> patches_;  ///< by wall, the latest
    double path_m_ = 0, stretch_from_m_ = 0;
    double usual_duration_s_ = 0;  ///< of a step
};

}  // namespace

CalibrationGraph graph_of_drive(const History& history, const SmoothedPath& path, const Drive& drive,
                                const AssumedDrive& assumed, const DriveGraphParameters& parameters) {
    return Builder(history, path, drive, assumed, parameters).build();
}

}  // namespace loopline::line_slam
