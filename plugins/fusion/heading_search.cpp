#include "fusion/heading_search.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace loopline::fusion {

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
