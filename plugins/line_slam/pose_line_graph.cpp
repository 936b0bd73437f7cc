#include "line_slam/pose_line_graph.h"

#include <Eigen/LU>
#include <cmath>

#include "line_slam/graph_terms.h"
#include "least_squares/selected_inverse.h"

namespace loopline::line_slam {
namespace {

Eigen::Vector3d as_vector(const WheelCalibration& c) {
    return {c.left, c.right, c.track};
}

struct MotionTerm {
    Eigen::Vector3d residual;
    Eigen::Matrix3d to_previous, to_pose;  ///< Jacobians to (x, y, phi)
    Eigen::Matrix3d to_calibration;
};

/// What the wheels ought to have said minus what they said.
MotionTerm motion_term(const PoseLineGraph& graph, std::size_t k) {
    const BetweenTerm between = between_term(graph.poses[k - 1], graph.poses[k]);
    const ExpectedTravel expected =
        expected_travel(between.T_previous_pose, graph.track_width_m, graph.calibration);
    const WheelTravel& measured = graph.motions[k].travel;
    MotionTerm t;
    t.residual << expected.travel.left_m - measured.left_m, expected.travel.right_m - measured.right_m,
        expected.travel.side_m - measured.side_m;
    t.to_pose = expected.motion * between.to_pose;
    t.to_previous = expected.motion * between.to_previous;
    t.to_calibration = expected.calibration;
    return t;
}

}  // namespace

double graph_cost(const PoseLineGraph& graph) {
    double cost = as_vector(graph.calibration).squaredNorm() / (graph.sigma_scale * graph.sigma_scale);
    for (std::size_t k = 1; k < graph.poses.size(); ++k) {
        const Eigen::Vector3d r = motion_term(graph, k).residual;
        cost += r.dot(graph.motions[k].information * r);
    }
    for (const auto& z : graph.observations) {
        const Eigen::Vector2d r =
            innovation(z.observed_base, predicted_line(graph.poses[static_cast<std::size_t>(z.pose)],
                                                       graph.lines[static_cast<std::size_t>(z.line)]));
        cost += graph.loss(r.dot(z.information * r));
    }
    return cost;
}

GraphSolver::GraphSolver(const PoseLineGraph& graph)
    : pose_count_(static_cast<int>(graph.poses.size())), line_count_(static_cast<int>(graph.lines.size())) {
    lay_out(graph);
    ldlt_.analyzePattern(H_);
}

/// Lower triangle by columns: a pose's columns hold its own block, the next pose's, and those of its lines.
void GraphSolver::lay_out(const PoseLineGraph& graph) {
    std::vector<std::vector<int>> lines_of(graph.poses.size());
    for (const auto& z : graph.observations) {
        auto& lines = lines_of[static_cast<std::size_t>(z.pose)];
        if (lines.empty() || lines.back() != z.line) lines.push_back(z.line);
        line_slot_.push_back(static_cast<Eigen::Index>(lines.size()) - 1);
    }
    const Eigen::Index n = calibration_row() + 3;
    H_.resize(n, n);
    std::size_t entries = 0;
    for (int k = 1; k < pose_count_; ++k)
        entries += 6 + (k + 1 < pose_count_ ? 9 : 0) + 6 * lines_of[static_cast<std::size_t>(k)].size() + 9;
    H_.reserve(static_cast<Eigen::Index>(entries) + 3 * line_count_ + 6);
    for (int k = 1; k < pose_count_; ++k)
        for (int c = 0; c < 3; ++c) {
            const Eigen::Index column = pose_row(k) + c;
            H_.startVec(column);
            for (int r = c; r < 3; ++r) H_.insertBack(pose_row(k) + r, column) = 0;
            if (k + 1 < pose_count_)
                for (int r = 0; r < 3; ++r) H_.insertBack(pose_row(k + 1) + r, column) = 0;
            for (const int line : lines_of[static_cast<std::size_t>(k)])
                for (int r = 0; r < 2; ++r) H_.insertBack(line_row(line) + r, column) = 0;
            for (int r = 0; r < 3; ++r) H_.insertBack(calibration_row() + r, column) = 0;
        }
    for (int l = 0; l < line_count_; ++l)
        for (int c = 0; c < 2; ++c) {
            H_.startVec(line_row(l) + c);
            for (int r = c; r < 2; ++r) H_.insertBack(line_row(l) + r, line_row(l) + c) = 0;
        }
    for (int c = 0; c < 3; ++c) {
        H_.startVec(calibration_row() + c);
        for (int r = c; r < 3; ++r) H_.insertBack(calibration_row() + r, calibration_row() + c) = 0;
    }
    H_.finalize();
}

void GraphSolver::linearise(const PoseLineGraph& graph, double information_factor) {
    double* values = H_.valuePtr();
    const auto* starts = H_.outerIndexPtr();
    std::fill(values, values + H_.nonZeros(), 0.0);
    gradient_ = Eigen::VectorXd::Zero(H_.rows());
    const auto add_diagonal = [&](Eigen::Index row, const auto& block) {
        for (Eigen::Index c = 0; c < block.cols(); ++c)
            for (Eigen::Index r = c; r < block.rows(); ++r) values[starts[row + c] + r - c] += block(r, c);
    };
    const auto add_below = [&](int pose, Eigen::Index offset, const auto& block) {
        for (Eigen::Index c = 0; c < 3; ++c)
            for (Eigen::Index r = 0; r < block.rows(); ++r)
                values[starts[pose_row(pose) + c] + (3 - c) + offset + r] += block(r, c);
    };
    const auto add_calibration = [&](int pose, const Eigen::Matrix3d& block) {
        for (Eigen::Index c = 0; c < 3; ++c)
            for (Eigen::Index r = 0; r < 3; ++r)
                values[starts[pose_row(pose) + c + 1] - 3 + r] += block(r, c);
    };
    const double prior = 1 / (graph.sigma_scale * graph.sigma_scale);
    add_diagonal(calibration_row(), Eigen::Matrix3d(prior * Eigen::Matrix3d::Identity()));
    // A line that nothing ties stays where it is instead of making the equations singular.
    for (int l = 0; l < line_count_; ++l)
        add_diagonal(line_row(l), Eigen::Matrix2d(1e-9 * Eigen::Matrix2d::Identity()));
    gradient_.tail<3>() += prior * as_vector(graph.calibration);
    for (int k = 1; k < pose_count_; ++k) {
        const auto i = static_cast<std::size_t>(k);
        const MotionTerm t = motion_term(graph, i);
        const Eigen::Matrix3d weighted_calibration = graph.motions[i].information * t.to_calibration;
        add_diagonal(calibration_row(), Eigen::Matrix3d(t.to_calibration.transpose() * weighted_calibration));
        gradient_.tail<3>() += weighted_calibration.transpose() * t.residual;
        add_calibration(k, weighted_calibration.transpose() * t.to_pose);
        if (k > 1) add_calibration(k - 1, weighted_calibration.transpose() * t.to_previous);
        const Eigen::Matrix3d weighted = graph.motions[i].information * t.to_pose;
        add_diagonal(pose_row(k), Eigen::Matrix3d(t.to_pose.transpose() * weighted));
        gradient_.segment<3>(pose_row(k)) += weighted.transpose() * t.residual;
        if (k == 1) continue;
        const Eigen::Matrix3d weighted_previous = graph.motions[i].information * t.to_previous;
        add_diagonal(pose_row(k - 1), Eigen::Matrix3d(t.to_previous.transpose() * weighted_previous));
        gradient_.segment<3>(pose_row(k - 1)) += weighted_previous.transpose() * t.residual;
        add_below(k - 1, 0, Eigen::Matrix3d(t.to_pose.transpose() * weighted_previous));
    }
    for (std::size_t o = 0; o < graph.observations.size(); ++o) {
        const GraphObservation& z = graph.observations[o];
        const LineTerm t = line_term(graph.poses[static_cast<std::size_t>(z.pose)],
                                     graph.lines[static_cast<std::size_t>(z.line)], z.observed_base);
        const double weight = graph.loss.weight(t.residual.dot(z.information * t.residual));
        const Eigen::Matrix2d information = information_factor * weight * z.information;
        const Eigen::Matrix2d weighted_line = information * t.to_line;
        add_diagonal(line_row(z.line), Eigen::Matrix2d(t.to_line.transpose() * weighted_line));
        gradient_.segment<2>(line_row(z.line)) += weighted_line.transpose() * t.residual;
        if (z.pose == 0) continue;
        const Matrix23 weighted_pose = information * t.to_pose;
        add_diagonal(pose_row(z.pose), Eigen::Matrix3d(t.to_pose.transpose() * weighted_pose));
        gradient_.segment<3>(pose_row(z.pose)) += weighted_pose.transpose() * t.residual;
        const Eigen::Index next_pose = z.pose + 1 < pose_count_ ? 3 : 0;
        add_below(z.pose, next_pose + 2 * line_slot_[o], Matrix23(t.to_line.transpose() * weighted_pose));
    }
}

GraphSolver::Outcome GraphSolver::minimise(PoseLineGraph& graph, int max_iterations) {
    Outcome outcome;
    double cost = graph_cost(graph), damping = 1e-6;
    outcome.initial_cost = cost;
    while (outcome.iterations < max_iterations && !outcome.converged) {
        linearise(graph);
        const Eigen::VectorXd diagonal = H_.diagonal();
        bool better = false;
        while (!better && damping < 1e6) {
            ++outcome.iterations;
            for (Eigen::Index i = 0; i < H_.cols(); ++i)
                H_.valuePtr()[H_.outerIndexPtr()[i]] = diagonal(i) * (1 + damping);
            ldlt_.factorize(H_);
            PoseLineGraph& next = graph;
            const std::vector<Pose2> poses = graph.poses;
            const std::vector<PlanarLine> lines = graph.lines;
            const WheelCalibration calibration = graph.calibration;
            if (ldlt_.info() == Eigen::Success) {
                const Eigen::VectorXd dx = ldlt_.solve(-gradient_);
                for (int k = 1; k < pose_count_; ++k) {
                    Pose2& p = next.poses[static_cast<std::size_t>(k)];
                    p = {p.x_m + dx(pose_row(k)), p.y_m + dx(pose_row(k) + 1),
                         wrap_to_pi(p.phi_rad + dx(pose_row(k) + 2))};
                }
                next.calibration.left += dx(calibration_row());
                next.calibration.right += dx(calibration_row() + 1);
                next.calibration.track += dx(calibration_row() + 2);
                for (int l = 0; l < line_count_; ++l) {
                    PlanarLine& q = next.lines[static_cast<std::size_t>(l)];
                    q = {q.rho_m + dx(line_row(l)), wrap_to_pi(q.alpha_rad + dx(line_row(l) + 1))};
                }
            }
            const double next_cost = ldlt_.info() == Eigen::Success ? graph_cost(next) : cost;
            if (std::isfinite(next_cost) && next_cost <= cost) {
                better = true;
                outcome.converged = cost - next_cost < 1e-5 * cost;
                cost = next_cost;
                damping = std::max(damping * 0.1, 1e-9);
            } else {
                graph.poses = poses;
                graph.lines = lines;
                graph.calibration = calibration;
                damping *= 30;
            }
        }
        if (!better) break;
    }
    outcome.final_cost = cost;
    return outcome;
}

bool GraphSolver::factorise(const PoseLineGraph& graph) {
    linearise(graph, graph.loss.information_factor());
    ldlt_.factorize(H_);
    inverse_.resize(0, 0);
    return ldlt_.info() == Eigen::Success && (ldlt_.vectorD().array() > 0).all();
}

std::vector<Eigen::Matrix3d> GraphSolver::pose_covariances() const {
    if (inverse_.rows() == 0) inverse_ = least_squares::selected_inverse(ldlt_);
    std::vector<Eigen::Matrix3d> covariances(static_cast<std::size_t>(pose_count_), Eigen::Matrix3d::Zero());
    for (int k = 1; k < pose_count_; ++k)
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c)
                covariances[static_cast<std::size_t>(k)](r, c) =
                    least_squares::selected_entry(inverse_, ldlt_, pose_row(k) + r, pose_row(k) + c);
    return covariances;
}

std::vector<Eigen::Matrix2d> GraphSolver::line_covariances() const {
    if (inverse_.rows() == 0) inverse_ = least_squares::selected_inverse(ldlt_);
    std::vector<Eigen::Matrix2d> covariances(static_cast<std::size_t>(line_count_));
    for (int l = 0; l < line_count_; ++l)
        for (int r = 0; r < 2; ++r)
            for (int c = 0; c < 2; ++c)
                covariances[static_cast<std::size_t>(l)](r, c) =
                    least_squares::selected_entry(inverse_, ldlt_, line_row(l) + r, line_row(l) + c);
    return covariances;
}

Eigen::Matrix2d GraphSolver::line_difference_covariance(int a, int b) const {
    Eigen::MatrixXd difference = Eigen::MatrixXd::Zero(H_.rows(), 2);
    for (int c = 0; c < 2; ++c) {
        difference(line_row(a) + c, c) = 1;
        difference(line_row(b) + c, c) = -1;
    }
    return difference.transpose() * ldlt_.solve(difference);
}

}  // namespace loopline::line_slam
