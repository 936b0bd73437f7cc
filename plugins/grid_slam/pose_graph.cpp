#include "grid_slam/pose_graph.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "least_squares/block_ldlt.h"

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

/// Information of all poses but the first, and what drives them.
class GraphOptimiser::NormalEquations {
 public:
    NormalEquations(std::size_t poses, const std::vector<Constraint>& constraints)
        : ldlt_(poses - 1, pairs_of(constraints)), gradient_(static_cast<Eigen::Index>(3 * (poses - 1))) {}

    double build(const std::vector<Pose2>& poses, const std::vector<Constraint>& constraints,
                 const GraphSettings& settings) {
        ldlt_.set_zero();
        gradient_.setZero();
        const double scale2 = settings.loss_scale * settings.loss_scale;
        double cost = 0;
        std::size_t pair = 0;
        for (const Constraint& c : constraints) {
            const Linearised l = linearise(c, poses[c.from], poses[c.to]);
            const double square = l.e.dot(c.information * l.e);
            const double w = !c.may_be_wrong() ? 1 : 1 / (1 + square / scale2);
            cost += !c.may_be_wrong() ? square : scale2 * std::log1p(square / scale2);
            const Eigen::Matrix3d information = w * c.information, by_from = information * l.by_from,
                                  by_to = information * l.by_to;
            if (c.from > 0) add(c.from, l.by_from.transpose() * by_from, -by_from.transpose() * l.e);
            if (c.to > 0) add(c.to, l.by_to.transpose() * by_to, -by_to.transpose() * l.e);
            if (is_between_unknowns(c)) ldlt_.add(pair++, l.by_from.transpose() * by_to);
        }
        return cost;
    }
    bool factorise() { return ldlt_.factorise(); }
    Eigen::VectorXd step() const { return ldlt_.solve(gradient_); }
    std::vector<Eigen::Matrix3d> covariances() { return ldlt_.inverse_diagonal(); }

 private:
    static bool is_between_unknowns(const Constraint& c) { return c.from > 0 && c.to > 0; }
    static std::vector<least_squares::BlockLdlt::Pair> pairs_of(const std::vector<Constraint>& constraints) {
        std::vector<least_squares::BlockLdlt::Pair> pairs;
        for (const Constraint& c : constraints)
            if (is_between_unknowns(c)) pairs.emplace_back(c.from - 1, c.to - 1);
        return pairs;
    }
    void add(std::uint32_t pose, const Eigen::Matrix3d& information, const Eigen::Vector3d& gradient) {
        ldlt_.add_diagonal(pose - 1, information);
        gradient_.segment<3>(static_cast<Eigen::Index>(3 * (pose - 1))) += gradient;
    }

    least_squares::BlockLdlt ldlt_;
    Eigen::VectorXd gradient_;
};

GraphOptimiser::GraphOptimiser(std::vector<Pose2> poses, std::vector<Constraint> constraints,
                               const GraphSettings& settings)
    : poses_(std::move(poses)),
      constraints_(std::move(constraints)),
      settings_(settings),
      equations_(std::make_unique<NormalEquations>(std::max<std::size_t>(poses_.size(), 1), constraints_)) {
    good_ = poses_.size() >= 2 && !constraints_.empty();
}
GraphOptimiser::~GraphOptimiser() = default;
GraphOptimiser::GraphOptimiser(GraphOptimiser&&) noexcept = default;
GraphOptimiser& GraphOptimiser::operator=(GraphOptimiser&&) noexcept = default;

bool GraphOptimiser::iterate() {
    if (!good_ || iterations_ >= settings_.iterations) return false;
    ++iterations_;
    cost_ = equations_->build(poses_, constraints_, settings_);
    good_ = equations_->factorise();
    if (!good_) return false;
    const Eigen::VectorXd step = equations_->step();
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
    equations_->build(poses_, constraints_, settings_);
    if (!equations_->factorise()) return all;
    all = equations_->covariances();
    all.insert(all.begin(), Eigen::Matrix3d::Zero());
    return all;
}

}  // namespace loopline::grid_slam
