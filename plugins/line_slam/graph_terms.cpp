#include "line_slam/graph_terms.h"

#include <cmath>

namespace loopline::line_slam {

BetweenTerm between_term(const Pose2& previous, const Pose2& pose) {
    const double c = std::cos(previous.phi_rad), s = std::sin(previous.phi_rad);
    BetweenTerm t;
    t.T_previous_pose = previous.inverse() * pose;
    t.to_pose << c, s, 0, -s, c, 0, 0, 0, 1;
    t.to_previous << -c, -s, t.T_previous_pose.y_m, s, -c, -t.T_previous_pose.x_m, 0, 0, -1;
    return t;
}

LineTerm line_term(const Pose2& pose, const PlanarLine& line, const PlanarLine& observed_base) {
    const Eigen::Vector2d n = line.normal();
    LineTerm t;
    t.residual = -innovation(observed_base, predicted_line(pose, line));
    // The observed foot point's share along the predicted normal changes as that turns.
    const double aside_m = observed_base.rho_m * std::sin(t.residual.y());
    t.to_pose << -n.x(), -n.y(), -aside_m, 0, 0, -1;
    t.to_line << 1, -line.along_m(pose.translation()) + aside_m, 0, 1;
    return t;
}

}  // namespace loopline::line_slam
