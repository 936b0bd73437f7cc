#include "lidar_odometry/scan_to_scan.h"

#include <algorithm>
#include <cmath>

#include "api/dense_algebra.h"
#include "least_squares/held_directions.h"

namespace loopline::lidar_odometry {
namespace {

using least_squares::HeldDirections;

/// A point of this sweep and what it is drawn to.
struct Pair {
    Eigen::Vector3d p_base_m;
    double time_s = 0;
    double per_variance = 0;
    int residuals = 0;  ///< 1: a plane, 2: a line, 0: nothing
    std::array<Residual, 2> residual;
    std::array<Eigen::Vector3d, 3> turned_by;  ///< of a plane
};

class Matcher {
 public:
    Matcher(const ReferenceSweep& before, const SweepFeatures& now, const ExpectedMotion& expected,
            const MatchingSettings& settings, WorkerPool& workers)
        : before_(before),
          expected_(expected),
          settings_(settings),
          workers_(workers),
          prior_(inverse_of(expected.covariance)) {
        for (const Feature& edge : now.edges)
            if (edge.matched != 0) edges_.push_back(&edge);
        for (const Feature& planar : now.planar)
            if (planar.matched != 0) planar_.push_back(&planar);
    }

    MatchedMotion match();

 private:
    struct Sums {
        Matrix6d H = Matrix6d::Zero();
        Vector6d g = Vector6d::Zero();
        double cost = 0;
    };

    void pair_with_line(const Feature& edge, const Pose3& T_before_then, Pair& pair) const;
    void pair_with_plane(const Feature& planar, const Pose3& T_before_then, Pair& pair) const;
    void associate(const Pose3& T_before_now);
    Sums linearise(const Pose3& T_before_now) const;
    double prior_cost(const Pose3& T_before_now) const;
    /// Cauchy's: what a squared residual costs, and its weight.
    double loss(double e2) const;
    double weight(double e2) const { return 1 / (1 + e2 / (settings_.loss_scale * settings_.loss_scale)); }
    HeldDirections held(const Pose3& T_before_now, const Matrix6d& H) const;
    double descend(Pose3& T_before_now);
    void finish(MatchedMotion& result) const;

    const ReferenceSweep& before_;
    const ExpectedMotion& expected_;
    const MatchingSettings& settings_;
    WorkerPool& workers_;
    Matrix6d prior_;
    std::vector<const Feature*> edges_, planar_;
    std::vector<Pair> pairs_;
    double range_m_ = 1;  ///< mean of those that are paired
};

Vector6d vector_of(const Twist3& twist) {
    Vector6d v;
    v << twist.shift_m, twist.turn_rad;
    return v;
}

Pose3 moved(const Pose3& T, const Vector6d& step) {
    return exp_se3({step.head<3>(), step.tail<3>()}) * T;
}

/// An edge point and its line.
void Matcher::pair_with_line(const Feature& edge, const Pose3& T_before_then, Pair& pair) const {
    const auto line = find_line(before_, T_before_then * pair.p_base_m, settings_.correspondences);
    if (!line) return;
    pair.residual = to_line(*line);
    pair.residuals = 2;
    pair.per_variance = 1 / (static_cast<double>(edge.variance_m2) + line->variance_m2);
}

/// A planar point and its plane.
void Matcher::pair_with_plane(const Feature& planar, const Pose3& T_before_then, Pair& pair) const {
    const Eigen::Vector3d along = T_before_then.rotation * planar.along_base.cast<double>();
    const auto plane = find_plane(before_, T_before_then * pair.p_base_m, along, settings_.correspondences);
    if (!plane) return;
    pair.residual[0] = to_plane(*plane);
    pair.residuals = 1;
    const Eigen::Vector3d normal_base = T_before_then.rotation.conjugate() * plane->normal;
    pair.per_variance = 1 / (variance_along(planar, normal_base) + plane->variance_m2);
    pair.turned_by = plane->turned_by;
}

/// Each point by itself, so that it does not matter which thread takes it.
void Matcher::associate(const Pose3& T_before_now) {
    constexpr std::size_t parts = 16;
    const ConstantTwist motion(T_before_now, expected_.duration_s);
    const std::size_t count = edges_.size() + planar_.size();
    pairs_.assign(count, {});
    workers_.run(parts, [&](std::size_t part) {
        for (std::size_t i = part * count / parts; i < (part + 1) * count / parts; ++i) {
            const bool edge = i < edges_.size();
            const Feature& feature = edge ? *edges_[i] : *planar_[i - edges_.size()];
            Pair& pair = pairs_[i];
            pair.p_base_m = feature.p_base_m.cast<double>();
            pair.time_s = static_cast<double>(feature.time_s);
            const Pose3 T_before_then = motion.at(pair.time_s);
            edge ? pair_with_line(feature, T_before_then, pair)
                 : pair_with_plane(feature, T_before_then, pair);
        }
    });
    pairs_.erase(std::remove_if(pairs_.begin(), pairs_.end(), [](const Pair& p) { return p.residuals == 0; }),
                 pairs_.end());
    double sum_m = 0;
    for (const Pair& pair : pairs_) sum_m += pair.p_base_m.norm();
    range_m_ = std::max(1.0, sum_m / std::max<double>(1, static_cast<double>(pairs_.size())));
}

double Matcher::loss(double e2) const {
    const double scale2 = settings_.loss_scale * settings_.loss_scale;
    return scale2 * std::log1p(e2 / scale2);
}

double Matcher::prior_cost(const Pose3& T_before_now) const {
    const Vector6d off = vector_of(log_se3(T_before_now * expected_.T_before_now.inverse()));
    return off.dot(prior_ * off);
}

double squared(const Pair& pair, const Eigen::Vector3d& p_before_m) {
    double e2 = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(pair.residuals); ++k) {
        const double e = pair.residual[k].of(p_before_m);
        e2 += e * e;
    }
    return e2 * pair.per_variance;
}

Matcher::Sums Matcher::linearise(const Pose3& T_before_now) const {
    const ConstantTwist motion(T_before_now, expected_.duration_s);
    Sums sums;
    sums.cost = prior_cost(T_before_now);
    for (const Pair& pair : pairs_) {
        const Eigen::Vector3d p_before_m = motion.at(pair.time_s) * pair.p_base_m;
        const double e2 = squared(pair, p_before_m), w = weight(e2) * pair.per_variance;
        sums.cost += loss(e2);
        for (std::size_t k = 0; k < static_cast<std::size_t>(pair.residuals); ++k) {
            const Row6d j = pair.residual[k].jacobian(p_before_m, pair.time_s, motion);
            sums.H += w * j.transpose() * j;
            sums.g -= (w * pair.residual[k].of(p_before_m)) * j.transpose();
        }
    }
    return sums;
}

/// The noise of normals looks like information across to them; it is taken away.
HeldDirections Matcher::held(const Pose3& T_before_now, const Matrix6d& H) const {
    const ConstantTwist motion(T_before_now, expected_.duration_s);
    Matrix6d by_chance = Matrix6d::Zero();
    for (const Pair& pair : pairs_) {
        if (pair.residuals != 1) continue;
        const Eigen::Vector3d p_before_m = motion.at(pair.time_s) * pair.p_base_m;
        const double w = weight(squared(pair, p_before_m)) * pair.per_variance, u = motion.part(pair.time_s);
        for (const Eigen::Vector3d& turned : pair.turned_by) {
            Row6d j;
            j << turned.transpose(), p_before_m.cross(turned).transpose();
            by_chance += (w * u * u) * j.transpose() * j;
        }
    }
    return {H - by_chance, range_m_, settings_.sigma_degenerate_m};
}

/// Levenberg-Marquardt with the correspondences as they are. Free directions stay as expected. Returns how
/// far it went, relative to what is enough.
double Matcher::descend(Pose3& T_before_now) {
    const Pose3 start = T_before_now;
    double damping = 1e-6;
    Sums sums = linearise(T_before_now);
    const HeldDirections directions = held(T_before_now, sums.H);
    const Matrix6d P = directions.projection();
    for (int i = 0; i < settings_.steps; ++i) {
        const Vector6d off = vector_of(log_se3(expected_.T_before_now * T_before_now.inverse()));
        Matrix6d H = P.transpose() * sums.H * P + prior_;
        H.diagonal() *= 1 + damping;
        const Vector6d step = solved(H, P.transpose() * sums.g + prior_ * off);
        if (!step.allFinite()) break;
        const Pose3 next = moved(T_before_now, step);
        if (step.head<3>().norm() < settings_.enough_m && step.tail<3>().norm() < settings_.enough_rad) {
            T_before_now = next;
            break;
        }
        const Sums at_next = linearise(next);
        if (directions.all() && at_next.cost > sums.cost) {
            damping = std::max(1e-4, 10 * damping);
            continue;
        }
        T_before_now = next;
        damping /= 10;
        sums = at_next;
    }
    const Twist3 way = log_se3(T_before_now * start.inverse());
    return std::max(way.shift_m.norm() / settings_.enough_m, way.turn_rad.norm() / settings_.enough_rad);
}

void Matcher::finish(MatchedMotion& result) const {
    const ConstantTwist motion(result.T_before_now, expected_.duration_s);
    double squares = 0, weights = 0;
    for (const Pair& pair : pairs_) {
        const double e2 = squared(pair, motion.at(pair.time_s) * pair.p_base_m), w = weight(e2);
        squares += w * e2 / pair.residuals;
        weights += w;
        ++(pair.residuals == 2 ? result.lines : result.planes);
    }
    result.support = weights / std::max<double>(1, static_cast<double>(edges_.size() + planar_.size()));
    result.rms_sigmas = std::sqrt(squares / std::max(1.0, weights));
    const HeldDirections directions = held(result.T_before_now, linearise(result.T_before_now).H);
    result.free = {directions.free_count(), directions.weakest_sigma_m(), directions.weakest().normalized(),
                   directions.weakest_moves_m()};
    // What the model leaves unexplained counts as noise.
    const double per_scatter = 1 / std::max(1.0, result.rms_sigmas * result.rms_sigmas);
    result.covariance = inverse_of(per_scatter * directions.information() + prior_);
}

MatchedMotion Matcher::match() {
    MatchedMotion result;
    result.T_before_now = expected_.T_before_now;
    while (result.rounds < settings_.rounds && !result.converged) {
        ++result.rounds;
        associate(result.T_before_now);
        result.converged = descend(result.T_before_now) < 1;
    }
    finish(result);
    return result;
}

}  // namespace

Residual to_plane(const PlaneOfPoints& plane) {
    return {plane.normal, plane.point_m};
}

std::array<Residual, 2> to_line(const LineOfEdges& line) {
    const Eigen::Vector3d across = line.direction.unitOrthogonal();
    return {Residual{across, line.point_m}, Residual{line.direction.cross(across), line.point_m}};
}

MatchedMotion match_sweeps(const ReferenceSweep& before, const SweepFeatures& now,
                           const ExpectedMotion& expected, const MatchingSettings& settings,
                           WorkerPool& workers) {
    return Matcher(before, now, expected, settings, workers).match();
}

}  // namespace loopline::lidar_odometry
