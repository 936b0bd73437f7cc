/// Scores extracted lines against the walls that made the scan.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "api/dense_algebra.h"
#include "lines/line_segment.h"
#include "property/lines_world.h"

namespace lines_world {

struct Score {
    int visible = 0;                                  ///< walls met by at least 8 beams over at least 0.6 m
    int found = 0;                                    ///< of these, with a line on them
    int lines = 0;                                    ///< on a wall
    int repeated = 0;                                 ///< further lines on a wall that has one
    int false_lines = 0;                              ///< on no wall, or far off theirs
    double rho_sum = 0, alpha_sum = 0, nees_sum = 0;  ///< squares in units of the claimed variance
    std::vector<double> end_errors_m;

    double recall() const { return visible > 0 ? static_cast<double>(found) / visible : 1; }
    double rho_rms() const { return std::sqrt(rho_sum / lines); }
    double alpha_rms() const { return std::sqrt(alpha_sum / lines); }
    double nees_mean() const { return nees_sum / lines; }

    /// A line belongs to the wall that most of its beams met.
    void add(const World& world, const loopline::Pose2& T_world_sensor, const Sweep& sweep,
             const loopline::lines::LineSegments& segments) {
        struct Seen {
            int beams = 0;
            std::size_t first = 0, last = 0;
            bool found = false;
        };
        std::vector<Seen> seen(world.walls.size());
        for (std::size_t i = 0; i < sweep.wall.size(); ++i) {
            if (sweep.wall[i] < 0) continue;
            Seen& wall = seen[static_cast<std::size_t>(sweep.wall[i])];
            if (wall.beams++ == 0) wall.first = i;
            wall.last = i;
        }
        const auto exact_point = [&](std::size_t beam) {
            const double bearing = sweep.scan.angle_rad(beam), r = sweep.exact_range_m[beam];
            return Eigen::Vector2d(r * std::cos(bearing), r * std::sin(bearing));
        };
        for (const auto& s : segments) {
            std::vector<int> votes(world.walls.size(), 0);
            int strangers = 0;
            for (std::size_t i = s.first_beam; i <= s.last_beam && i < sweep.wall.size(); ++i) {
                if (sweep.scan.ranges_m[i] <= 0) continue;
                if (sweep.wall[i] >= 0)
                    ++votes[static_cast<std::size_t>(sweep.wall[i])];
                else
                    ++strangers;
            }
            const auto most = std::max_element(votes.begin(), votes.end());
            if (votes.empty() || *most == 0 || *most < strangers) {
                ++false_lines;
                continue;
            }
            const auto w = static_cast<std::size_t>(most - votes.begin());
            const TrueLine truth = true_line(world.walls[w], T_world_sensor);
            const Eigen::Vector2d error(s.rho_m - truth.rho_m,
                                        loopline::wrap_to_pi(s.alpha_rad - truth.alpha_rad));
            const double nees = loopline::squared_in_sigmas(error, s.covariance);
            if (nees > 25 + 2 || std::abs(error(1)) > 0.3) {
                ++false_lines;
                continue;
            }
            ++lines;
            if (seen[w].found) ++repeated;
            seen[w].found = true;
            nees_sum += nees;
            rho_sum += error(0) * error(0) / s.covariance(0, 0);
            alpha_sum += error(1) * error(1) / s.covariance(1, 1);
            end_errors_m.push_back((s.start_m - exact_point(seen[w].first)).norm());
            end_errors_m.push_back((s.end_m - exact_point(seen[w].last)).norm());
        }
        for (const Seen& wall : seen) {
            if (wall.beams < 8 || (exact_point(wall.first) - exact_point(wall.last)).norm() < 0.6) continue;
            ++visible;
            if (wall.found) ++found;
        }
    }
};

}  // namespace lines_world
