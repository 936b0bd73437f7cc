#include "grid_slam/pose_graph.h"

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <utility>

#include "least_squares/selected_inverse.h"

namespace loopline::grid_slam {
namespace {

Eigen::Matrix2d rotation_inverse(double phi_rad) {
    const double c = std::cos(phi_rad), s = std::sin(phi_rad);
    return (Eigen::Matrix2d() << c, s, -s, c).finished();
}

/// d e / d (x, y, phi) of both poses.
struct Linearised {
    Eigen::Vector3d e;
    Eigen::Matrix3d by_from, by_to;
};

Linearised linearise(const Constraint& constraint, const Pose2& T_map_from, const Pose2& T_map_to) {
    const Eigen::Matrix2d R_from_map = rotation_inverse(T_map_from.phi_rad);
    const Eigen::Vector2d way = R_from_map * (T_map_to.translation() - T_map_from.translation());
    Linearised l;
    l.e << way - constraint.T_from_to.translation(),
        wrap_to_pi(T_map_to.phi_rad - T_map_from.phi_rad - constraint.T_from_to.phi_rad);
    l.by_to.setIdentity();
    l.by_to.topLeftCorner<2, 2>() = R_from_map;
    l.by_from = -l.by_to;
    l.by_from(0, 2) = way.y();
    l.by_from(1, 2) = -way.x();
    return l;
}

}  // namespace

Eigen::Vector3d residual(const Constraint& constraint, const Pose2& T_map_from, const Pose2& T_map_to) {
    return linearise(constraint, T_map_from, T_map_to).e;
}

/// Lower triangle of the information of all poses but the first, and what drives them.
class GraphOptimiser::NormalEquations {
 public:
    NormalEquations(std::size_t poses, const std::vector<Constraint>& constraints)
        : size_(static_cast<Eigen::Index>(3 * (poses - 1))), gradient_(size_) {
        entries_.reserve(constraints.size() * 27);
    }

    double build(const std::vector<Pose2>& poses, const std::vector<Constraint>& constraints,
                 const GraphSettings& settings) {
        entries_.clear();
        gradient_.setZero();
        const double scale2 = settings.loss_scale * settings.loss_scale;
        double cost = 0;
        for (const Constraint& c : constraints) {
            const Linearised l = linearise(c, poses[c.from], poses[c.to]);
            const double square = l.e.dot(c.information * l.e);
            const double w = !c.may_be_wrong() ? 1 : 1 / (1 + square / scale2);
            cost += !c.may_be_wrong() ? square : scale2 * std::log1p(square / scale2);
            const Eigen::Matrix3d information = w * c.information;
            add(c.from, c.from, l.by_from.transpose() * information * l.by_from);
            add(c.to, c.to, l.by_to.transpose() * information * l.by_to);
            if (c.from < c.to)
                add(c.to, c.from, l.by_to.transpose() * information * l.by_from);
            else
                add(c.from, c.to, l.by_from.transpose() * information * l.by_to);
            add(c.from, -l.by_from.transpose() * information * l.e);
            add(c.to, -l.by_to.transpose() * information * l.e);
        }
        matrix_.resize(size_, size_);
        matrix_.setFromTriplets(entries_.begin(), entries_.end());
        return cost;
    }

    /// Lower triangle.
    const Eigen::SparseMatrix<double>& matrix() const { return matrix_; }
    const Eigen::VectorXd& gradient() const { return gradient_; }

 private:
    void add(std::uint32_t row_pose, std::uint32_t column_pose, const Eigen::Matrix3d& block) {
        if (row_pose == 0 || column_pose == 0) return;
        const auto row = static_cast<int>(3 * (row_pose - 1)),
                   column = static_cast<int>(3 * (column_pose - 1));
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c)
                if (row + r >= column + c) entries_.emplace_back(row + r, column + c, block(r, c));
    }
    void add(std::uint32_t pose, const Eigen::Vector3d& part) {
        if (pose > 0) gradient_.segment<3>(static_cast<Eigen::Index>(3 * (pose - 1))) += part;
    }

    Eigen::Index size_;
    std::vector<Eigen::Triplet<double>> entries_;
    Eigen::SparseMatrix<double> matrix_;
    Eigen::VectorXd gradient_;
};

struct GraphOptimiser::Solver {
    explicit Solver(const NormalEquations& of) : equations(of) {}
    NormalEquations equations;
    least_squares::SparseLdlt ldlt;
    bool ordered = false;

    bool factorise() {
        // The pattern stays: only the first time is an order chosen for it.
        if (!ordered) ldlt.analyzePattern(equations.matrix());
        ordered = true;
        ldlt.factorize(equations.matrix());
        return ldlt.info() == Eigen::Success;
    }
};

GraphOptimiser::GraphOptimiser(std::vector<Pose2> poses, std::vector<Constraint> constraints,
                               const GraphSettings& settings)
    : poses_(std::move(poses)),
      constraints_(std::move(constraints)),
      settings_(settings),
      solver_(
          std::make_unique<Solver>(NormalEquations(std::max<std::size_t>(poses_.size(), 1), constraints_))) {
    good_ = poses_.size() >= 2 && !constraints_.empty();
}
GraphOptimiser::~GraphOptimiser() = default;
GraphOptimiser::GraphOptimiser(GraphOptimiser&&) noexcept = default;
GraphOptimiser& GraphOptimiser::operator=(GraphOptimiser&&) noexcept = default;

bool GraphOptimiser::iterate() {
    if (!good_ || iterations_ >= settings_.iterations) return false;
    ++iterations_;
    cost_ = solver_->equations.build(poses_, constraints_, settings_);
    good_ = solver_->factorise();
    if (!good_) return false;
    const Eigen::VectorXd step = solver_->ldlt.solve(solver_->equations.gradient());
    good_ = step.allFinite();
    if (!good_) return false;
    for (std::size_t k = 1; k < poses_.size(); ++k) {
        const auto d = step.segment<3>(static_cast<Eigen::Index>(3 * (k - 1)));
        poses_[k] = {poses_[k].x_m + d.x(), poses_[k].y_m + d.y(), wrap_to_pi(poses_[k].phi_rad + d.z())};
    }
    return step.cwiseAbs().maxCoeff() > settings_.enough_m;
}

std::vector<Eigen::Matrix3d> GraphOptimiser::covariances() {
    std::vector<Eigen::Matrix3d> all;
    if (!good_) return all;
    solver_->equations.build(poses_, constraints_, settings_);
    if (!solver_->factorise()) return all;
    const auto inverse = least_squares::selected_inverse(solver_->ldlt);
    all.assign(poses_.size(), Eigen::Matrix3d::Zero());
    for (std::size_t k = 1; k < poses_.size(); ++k)
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) {
                const auto at = static_cast<Eigen::Index>(3 * (k - 1));
                all[k](r, c) = least_squares::selected_entry(inverse, solver_->ldlt, at + r, at + c);
            }
    return all;
}

}  // namespace loopline::grid_slam
