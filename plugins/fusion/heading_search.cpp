#include "fusion/heading_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace loopline::fusion {
namespace {

constexpr double agrees = 16;  // squared distance

Eigen::Vector2d way_local_m(const SeenFix& a, const SeenFix& b) {
    return (b.p_local_m - a.p_local_m).head<2>();
}
Eigen::Vector2d way_enu_m(const SeenFix& a, const SeenFix& b) {
    return (b.p_enu_m - a.p_enu_m).head<2>();
}

/// Of the way between two fixes, east and north each.
double variance_m2(const SeenFix& a, const SeenFix& b) {
    const auto &s = a.sigma, &t = b.sigma;
    const double tau_s = std::max(s.correlation_s, t.correlation_s),
                 alike = std::exp(-std::abs(a.time_s - b.time_s) / tau_s), u = s.correlated_m.x(),
                 v = t.correlated_m.x();
    return s.white_m.x() * s.white_m.x() + t.white_m.x() * t.white_m.x() + u * u + v * v - 2 * alike * u * v;
}

}  // namespace

double disagreement(const SeenFix& a, const SeenFix& b, const Eigen::Rotation2Dd& heading,
                    double sigma_heading_rad) {
    const Eigen::Vector2d way_m = way_local_m(a, b);
    const double by_heading_m = sigma_heading_rad * way_m.norm();
    return (way_enu_m(a, b) - heading * way_m).squaredNorm() /
           (variance_m2(a, b) + by_heading_m * by_heading_m);
}

std::vector<SeenFix> agreeing(const std::vector<SeenFix>& fixes) {
    const std::size_t n = fixes.size();
    double farthest_m2 = 0;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < i; ++j)
            farthest_m2 = std::max(farthest_m2, way_local_m(fixes[j], fixes[i]).squaredNorm());
    std::vector<SeenFix> most;
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = i + 1; j < n; ++j) {
            const Eigen::Vector2d a_m = way_local_m(fixes[i], fixes[j]), b_m = way_enu_m(fixes[i], fixes[j]);
            if (4 * a_m.squaredNorm() < farthest_m2) continue;
            const double variance = variance_m2(fixes[i], fixes[j]), longer_m = b_m.norm() - a_m.norm();
            if (longer_m * longer_m > agrees * variance) continue;
            const double sigma_rad = std::sqrt(variance) / a_m.norm();
            const Eigen::Rotation2Dd heading(std::atan2(b_m.y(), b_m.x()) - std::atan2(a_m.y(), a_m.x()));
            std::vector<SeenFix> all;
            for (const SeenFix& fix : fixes) {
                const bool nearer_to_i =
                    std::abs(fix.time_s - fixes[i].time_s) < std::abs(fix.time_s - fixes[j].time_s);
                if (disagreement(nearer_to_i ? fixes[i] : fixes[j], fix, heading, sigma_rad) < agrees)
                    all.push_back(fix);
            }
            if (all.size() > most.size()) most = std::move(all);
        }
    }
    return most;
}

std::optional<FoundHeading> find_heading(const std::vector<SeenFix>& fixes) {
    const auto n = static_cast<Eigen::Index>(fixes.size());
    if (n < 3) return std::nullopt;
    // C(i, j) = white^2 (i = j) + correlated_i correlated_j exp(-|t_i - t_j| / tau), east and north alike.
    Eigen::MatrixXd C(n, n);
    Eigen::MatrixX3d local_m(n, 3), enu_m(n, 3);
    for (Eigen::Index i = 0; i < n; ++i) {
        const SeenFix& a = fixes[static_cast<std::size_t>(i)];
        local_m.row(i) = a.p_local_m;
        enu_m.row(i) = a.p_enu_m;
        for (Eigen::Index j = 0; j < n; ++j) {
            const SeenFix& b = fixes[static_cast<std::size_t>(j)];
            const double tau_s = std::max(a.sigma.correlation_s, b.sigma.correlation_s);
            C(i, j) = a.sigma.correlated_m.x() * b.sigma.correlated_m.x() *
                      std::exp(-std::abs(a.time_s - b.time_s) / tau_s);
        }
        C(i, i) += a.sigma.white_m.x() * a.sigma.white_m.x();
    }
    const Eigen::LLT<Eigen::MatrixXd> llt(C);
    if (llt.info() != Eigen::Success) return std::nullopt;
    const Eigen::VectorXd w = llt.solve(Eigen::VectorXd::Ones(n));
    const double all = w.sum();
    const Eigen::RowVector3d mean_local_m = w.transpose() * local_m / all,
                             mean_enu_m = w.transpose() * enu_m / all;
    const Eigen::MatrixX3d a = local_m.rowwise() - mean_local_m, b = enu_m.rowwise() - mean_enu_m;
    const Eigen::MatrixX3d Wa = llt.solve(a), Wb = llt.solve(b);

    const double dot = Wa.col(0).dot(b.col(0)) + Wa.col(1).dot(b.col(1)),
                 cross = Wa.col(0).dot(b.col(1)) - Wa.col(1).dot(b.col(0));
    const double extent = Wa.col(0).dot(a.col(0)) + Wa.col(1).dot(a.col(1));
    if (!(extent > 0)) return std::nullopt;
    FoundHeading found;
    const double heading_rad = std::atan2(cross, dot);
    found.sigma_rad = 1 / std::sqrt(extent);
    found.T_enu_local = Pose3(Pose2{0, 0, heading_rad});
    found.T_enu_local.translation_m =
        mean_enu_m.transpose() - found.T_enu_local.rotation * mean_local_m.transpose();
    const double c = std::cos(heading_rad), s = std::sin(heading_rad);
    const Eigen::VectorXd left_x = b.col(0) - c * a.col(0) + s * a.col(1),
                          left_y = b.col(1) - s * a.col(0) - c * a.col(1);
    const double squares = left_x.dot(llt.solve(left_x)) + left_y.dot(llt.solve(left_y));
    found.misfit = squares / static_cast<double>(2 * n - 3);
    return found;
}

}  // namespace loopline::fusion
