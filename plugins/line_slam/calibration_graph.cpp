#include "line_slam/calibration_graph.h"

#include <cmath>
#include <limits>

#include "line_slam/graph_terms.h"

namespace loopline::line_slam {

/// One scalar whose variance is asked for: a piece's travel of a wheel or to the side, or a stretch's
/// deviation. variance = share x exp(log_variance[component]), and exp(log_variance[rest_noise]) for travel.
struct CalibrationSolver::Row {
    double residual = 0;
    int component = 0;
    double share = 1;
    bool rests = false;
    double variance = 1;
    static constexpr int most_entries = 11;
    int entries = 0;
    std::array<Eigen::Index, most_entries> column{};
    std::array<double, most_entries> jacobian{};

    void add(Eigen::Index at, double value) {
        column[static_cast<std::size_t>(entries)] = at;
        jacobian[static_cast<std::size_t>(entries++)] = value;
    }
    double component_part(const NoiseVector& log_variance) const {
        return share * std::exp(log_variance(component));
    }
    void set_variance(const NoiseVector& log_variance) {
        variance = component_part(log_variance) + (rests ? std::exp(log_variance(rest_noise)) : 0);
    }
};

CalibrationSolver::CalibrationSolver(const CalibrationGraph& graph)
    : pose_count_(static_cast<int>(graph.poses.size())),
      line_count_(static_cast<int>(graph.lines.size())),
      stretch_count_(static_cast<int>(graph.deviations.size())) {}

std::vector<CalibrationSolver::Row> CalibrationSolver::rows(const CalibrationGraph& graph,
                                                            const NoiseVector& log_variance) const {
    std::vector<Row> rows;
    rows.reserve(3 * graph.pieces.size() + 2 * graph.deviations.size());
    for (int k = 1; k < pose_count_; ++k) {
        const auto& [drive, stretch] = graph.pieces[static_cast<std::size_t>(k)];
        const BetweenTerm between = between_term(graph.poses[static_cast<std::size_t>(k - 1)],
                                                 graph.poses[static_cast<std::size_t>(k)]);
        const ExpectedTravel seen = expected_travel(between.T_previous_pose, graph.track_width_m, {});
        const Eigen::Matrix3d to_previous = seen.motion * between.to_previous,
                              to_pose = seen.motion * between.to_pose;
        const auto add_pose_entries = [&](Row& row, int which) {
            for (int c = 0; c < 3; ++c) row.add(pose_column(k) + c, to_pose(which, c));
            for (int c = 0; c < 3 && k > 1; ++c) row.add(pose_column(k - 1) + c, to_previous(which, c));
        };
        WheelValues over_ground_m;
        for (const Wheel wheel : both_wheels)
            of(over_ground_m, wheel) = (1 - of(graph.slip, drive.regime, wheel) -
                                        of(graph.deviations[static_cast<std::size_t>(stretch)], wheel)) *
                                       of(drive.rolled, wheel);
        // The turn is that of the true track width, the travel that turns as much with the stated one is
        // compared.
        const double narrowing = 1 / (1 + graph.track);
        const double middle_m = 0.5 * (over_ground_m[0] + over_ground_m[1]);
        const double half_turn_m = 0.5 * narrowing * (over_ground_m[1] - over_ground_m[0]);
        for (const Wheel wheel : both_wheels) {
            const double side = wheel == Wheel::left ? -1 : 1;
            Row row;
            row.residual = of(seen.travel, wheel) - (middle_m + side * half_turn_m);
            row.component = wheel_noise(drive.regime, wheel);
            row.share = std::abs(of(drive.rolled, wheel));
            row.rests = true;
            add_pose_entries(row, static_cast<int>(wheel));
            row.add(track_column(), side * half_turn_m * narrowing);
            for (const Wheel other : both_wheels) {
                const double part =
                    0.5 * (1 + (other == wheel ? narrowing : -narrowing)) * of(drive.rolled, other);
                row.add(slip_column(drive.regime, other), part);
                row.add(deviation_column(stretch, other), part);
            }
            rows.push_back(row);
        }
        Row side;
        side.residual = seen.travel.side_m - drive.rolled.side_m;
        side.component = side_noise;
        side.share = mean_way_m(drive.rolled);
        side.rests = true;
        add_pose_entries(side, 2);
        rows.push_back(side);
    }
    std::vector<Regime> regime_of(graph.deviations.size());
    for (std::size_t k = 1; k < graph.pieces.size(); ++k)
        regime_of[static_cast<std::size_t>(graph.pieces[k].stretch)] = graph.pieces[k].drive.regime;
    for (int c = 0; c < stretch_count_; ++c)
        for (const Wheel wheel : both_wheels) {
            Row row;
            row.residual = of(graph.deviations[static_cast<std::size_t>(c)], wheel);
            row.component = slip_scatter(regime_of[static_cast<std::size_t>(c)], wheel);
            row.add(deviation_column(c, wheel), 1);
            rows.push_back(row);
        }
    for (Row& row : rows) row.set_variance(log_variance);
    return rows;
}

namespace {

/// Where the scan of a pose was taken.
Pose2 seen_from(const CalibrationGraph& graph, int pose) {
    const auto at = static_cast<std::size_t>(pose);
    return graph.poses[at] * exp_se2(graph.velocities[at] * graph.delay_s);
}

Eigen::Vector2d tie_residual(const CalibrationGraph& graph, const CalibrationGraph::Tie& tie) {
    return difference(graph.lines[static_cast<std::size_t>(tie.patch)],
                      graph.lines[static_cast<std::size_t>(tie.wall)]);
}

}  // namespace

double CalibrationSolver::cost(const CalibrationGraph& graph, const std::vector<Row>& rows) const {
    double cost =
        std::pow(graph.track / graph.sigma_track, 2) + std::pow(graph.delay_s / graph.sigma_delay_s, 2);
    for (const WheelValues& slip : graph.slip)
        for (const double s : slip) cost += s * s / (graph.sigma_slip * graph.sigma_slip);
    for (const Row& row : rows) cost += row.residual * row.residual / row.variance;
    for (const GraphObservation& z : graph.observations) {
        const Eigen::Vector2d r = innovation(
            z.observed_base,
            predicted_line(seen_from(graph, z.pose), graph.lines[static_cast<std::size_t>(z.line)]));
        cost += r.dot(z.information * r);
    }
    for (const CalibrationGraph::Tie& tie : graph.ties) {
        const Eigen::Vector2d r = tie_residual(graph, tie);
        cost += r.dot(tie.information * r);
    }
    return cost;
}

void CalibrationSolver::linearise(const CalibrationGraph& graph, const std::vector<Row>& rows) {
    H_.begin(columns());
    gradient_ = Eigen::VectorXd::Zero(columns());
    for (const Row& row : rows)
        for (int a = 0; a < row.entries; ++a) {
            const auto i = static_cast<std::size_t>(a);
            const double weighted = row.jacobian[i] / row.variance;
            gradient_(row.column[i]) += weighted * row.residual;
            for (std::size_t j = 0; j <= i; ++j)
                H_.add(row.column[i], row.column[j], weighted * row.jacobian[j]);
        }
    for (const GraphObservation& z : graph.observations) {
        const Pose2 T_map_seen = seen_from(graph, z.pose);
        const LineTerm t =
            line_term(T_map_seen, graph.lines[static_cast<std::size_t>(z.line)], z.observed_base);
        const Pose2& pose = graph.poses[static_cast<std::size_t>(z.pose)];
        const Twist2& v = graph.velocities[static_cast<std::size_t>(z.pose)];
        const double c = std::cos(T_map_seen.phi_rad), s = std::sin(T_map_seen.phi_rad);
        Eigen::Matrix3d seen_to_pose = Eigen::Matrix3d::Identity();
        seen_to_pose.topRightCorner<2, 1>() = turned_left(T_map_seen.translation() - pose.translation());
        Eigen::Matrix<double, 2, 6> J;
        J << t.to_pose * seen_to_pose, t.to_line,
            t.to_pose *
                Eigen::Vector3d(c * v.forward_m - s * v.left_m, s * v.forward_m + c * v.left_m, v.turn_rad);
        const Eigen::Matrix<double, 2, 6> weighted = z.information * J;
        const Eigen::Matrix<double, 6, 6> block = J.transpose() * weighted;
        const Eigen::Matrix<double, 6, 1> slope = weighted.transpose() * t.residual;
        const auto column = [&](int i) {
            return i < 3 ? pose_column(z.pose) + i : i < 5 ? line_column(z.line) + i - 3 : delay_column();
        };
        for (int i = z.pose > 0 ? 0 : 3; i < 6; ++i) {
            gradient_(column(i)) += slope(i);
            for (int j = z.pose > 0 ? 0 : 3; j <= i; ++j) H_.add(column(i), column(j), block(i, j));
        }
    }
    for (const CalibrationGraph::Tie& tie : graph.ties) {
        const Eigen::Vector2d slope = tie.information * tie_residual(graph, tie);
        for (int i = 0; i < 2; ++i) {
            gradient_(line_column(tie.patch) + i) += slope(i);
            gradient_(line_column(tie.wall) + i) -= slope(i);
            for (int j = 0; j < 2; ++j) {
                H_.add(line_column(tie.patch) + i, line_column(tie.wall) + j, -tie.information(i, j));
                if (j > i) continue;
                H_.add(line_column(tie.patch) + i, line_column(tie.patch) + j, tie.information(i, j));
                H_.add(line_column(tie.wall) + i, line_column(tie.wall) + j, tie.information(i, j));
            }
        }
    }
    // A line that nothing ties stays where it is instead of making the equations singular.
    for (int l = 0; l < line_count_; ++l)
        for (int i = 0; i < 2; ++i) H_.add(line_column(l) + i, line_column(l) + i, 1e-9);
    const double slip_information = 1 / (graph.sigma_slip * graph.sigma_slip);
    for (const Regime regime : all_regimes)
        for (const Wheel wheel : both_wheels) {
            const Eigen::Index at = slip_column(regime, wheel);
            H_.add(at, at, slip_information);
            gradient_(at) += slip_information * of(graph.slip, regime, wheel);
        }
    const double track_information = 1 / (graph.sigma_track * graph.sigma_track);
    H_.add(track_column(), track_column(), track_information);
    gradient_(track_column()) += track_information * graph.track;
    const double delay_information = 1 / (graph.sigma_delay_s * graph.sigma_delay_s);
    H_.add(delay_column(), delay_column(), delay_information);
    gradient_(delay_column()) += delay_information * graph.delay_s;
}

bool CalibrationSolver::factorise() {
    const SymmetricSum::Sparse& H = H_.finish();
    if (!analysed_) ldlt_.analyzePattern(H);
    analysed_ = true;
    ldlt_.factorize(H);
    return ldlt_.info() == Eigen::Success && (ldlt_.vectorD().array() > 0).all();
}

void CalibrationSolver::move(CalibrationGraph& graph, const Eigen::VectorXd& dx) const {
    for (int k = 1; k < pose_count_; ++k) {
        Pose2& p = graph.poses[static_cast<std::size_t>(k)];
        p = {p.x_m + dx(pose_column(k)), p.y_m + dx(pose_column(k) + 1),
             wrap_to_pi(p.phi_rad + dx(pose_column(k) + 2))};
    }
    for (int l = 0; l < line_count_; ++l) {
        PlanarLine& q = graph.lines[static_cast<std::size_t>(l)];
        q = {q.rho_m + dx(line_column(l)), wrap_to_pi(q.alpha_rad + dx(line_column(l) + 1))};
    }
    graph.track += dx(track_column());
    graph.delay_s += dx(delay_column());
    for (const Wheel wheel : both_wheels) {
        for (const Regime regime : all_regimes)
            of(graph.slip, regime, wheel) += dx(slip_column(regime, wheel));
        for (int c = 0; c < stretch_count_; ++c)
            of(graph.deviations[static_cast<std::size_t>(c)], wheel) += dx(deviation_column(c, wheel));
    }
}

bool CalibrationSolver::minimise(CalibrationGraph& graph, const NoiseVector& log_variance) {
    constexpr int most_steps = 30, most_halvings = 12;
    constexpr double small_decrease = 1e-7;
    std::vector<Row> now = rows(graph, log_variance);
    double least = cost(graph, now);
    for (int i = 0; i < most_steps; ++i) {
        linearise(graph, now);
        if (!factorise()) return false;
        const Eigen::VectorXd dx = ldlt_.solve(-gradient_);
        if (!dx.allFinite()) return false;
        double part = 1, next_cost = least;
        CalibrationGraph next = graph;
        for (int h = 0; h < most_halvings; ++h, part /= 2) {
            next = graph;
            move(next, part * dx);
            next_cost = cost(next, rows(next, log_variance));
            if (next_cost <= least) break;
        }
        if (!(next_cost <= least)) return true;  // no decrease but by rounding
        const double decrease = least - next_cost;
        graph = std::move(next);
        now = rows(graph, log_variance);
        least = next_cost;
        if (decrease < small_decrease * (1 + least)) return true;
    }
    return false;
}

double CalibrationSolver::minus_two_log_likelihood(const CalibrationGraph& graph,
                                                   const NoiseVector& log_variance) {
    const std::vector<Row> now = rows(graph, log_variance);
    linearise(graph, now);
    if (!factorise()) return std::numeric_limits<double>::infinity();
    double value = cost(graph, now) + ldlt_.vectorD().array().log().sum();
    for (const Row& row : now) value += std::log(row.variance);
    return value;
}

// With Q the rows' variances, r their residuals at the minimum, J their Jacobian, C = J H^-1 J^T:
//     d log L / d q_i = 1/2 sum over rows of (r^2 + C - Q) / Q^2 dQ/dq_i,
//     information_ij  = 1/2 f_i^T (Q^-1 - Q^-1 C Q^-1) f_j,   f_i = dQ/dq_i r / Q.
CalibrationSolver::Likelihood CalibrationSolver::likelihood(const CalibrationGraph& graph,
                                                            const NoiseVector& log_variance) {
    Likelihood result;
    result.minus_two_log = minus_two_log_likelihood(graph, log_variance);
    if (!std::isfinite(result.minus_two_log)) return result;
    const std::vector<Row> now = rows(graph, log_variance);
    const SymmetricSum::Sparse inverse = least_squares::selected_inverse(ldlt_);
    const double rest = std::exp(log_variance(rest_noise));
    Eigen::MatrixXd pulls = Eigen::MatrixXd::Zero(columns(), noise_count);  // J^T Q^-1 f
    NoiseMatrix own = NoiseMatrix::Zero();                                  // f^T Q^-1 f
    for (const Row& row : now) {
        double explained = 0;
        for (int a = 0; a < row.entries; ++a)
            for (int b = 0; b <= a; ++b) {
                const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
                explained += (a == b ? 1 : 2) * row.jacobian[i] * row.jacobian[j] *
                             least_squares::selected_entry(inverse, ldlt_, row.column[i], row.column[j]);
            }
        const double surplus =
            (row.residual * row.residual + explained - row.variance) / (row.variance * row.variance);
        const int parts = row.rests ? 2 : 1;
        const std::array<int, 2> component{row.component, rest_noise};
        const std::array<double, 2> slope{row.component_part(log_variance), rest};
        for (std::size_t p = 0; p < static_cast<std::size_t>(parts); ++p) {
            result.gradient(component[p]) += 0.5 * surplus * slope[p];
            const double f = slope[p] * row.residual / row.variance;
            for (int a = 0; a < row.entries; ++a)
                pulls(row.column[static_cast<std::size_t>(a)], component[p]) +=
                    row.jacobian[static_cast<std::size_t>(a)] * f / row.variance;
            for (std::size_t q = 0; q < static_cast<std::size_t>(parts); ++q)
                own(component[p], component[q]) +=
                    f * slope[q] * row.residual / (row.variance * row.variance);
        }
    }
    result.information = 0.5 * (own - pulls.transpose() * ldlt_.solve(pulls));
    return result;
}

CalibrationSolver::ScaleMatrix CalibrationSolver::scale_covariance(const CalibrationGraph& graph,
                                                                   const NoiseVector& log_variance) {
    linearise(graph, rows(graph, log_variance));
    if (!factorise()) return ScaleMatrix::Constant(std::numeric_limits<double>::infinity());
    const Eigen::Index first = slip_column(Regime::straight, Wheel::left);
    Eigen::MatrixXd units = Eigen::MatrixXd::Zero(columns(), scale_count);
    units.middleRows(first, scale_count).setIdentity();
    return ldlt_.solve(units).middleRows(first, scale_count);
}

}  // namespace loopline::line_slam
