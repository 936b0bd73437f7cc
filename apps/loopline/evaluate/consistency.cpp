#include "evaluate/consistency.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace loopline {
namespace {

/// Of chi-square with `k` degrees of freedom at the standard normal quantile `z`. Wilson and Hilferty 1931.
double chi_square_quantile(double k, double z) {
    const double v = 2 / (9 * k), root = 1 - v + z * std::sqrt(v);
    return k * root * root * root;
}

}  // namespace

std::optional<double> pose_nees(const Pose2& T_map_base_estimate, const Pose2& T_map_base_truth,
                                const Eigen::Matrix3d& covariance) {
    const Eigen::Vector3d e(T_map_base_estimate.x_m - T_map_base_truth.x_m,
                            T_map_base_estimate.y_m - T_map_base_truth.y_m,
                            wrap_to_pi(T_map_base_estimate.phi_rad - T_map_base_truth.phi_rad));
    const Eigen::LLT<Eigen::Matrix3d> cholesky(covariance);
    if (cholesky.info() != Eigen::Success || !(cholesky.rcond() > 1e-14)) return std::nullopt;
    const double nees = e.dot(cholesky.solve(e));
    return std::isfinite(nees) ? std::optional<double>(nees) : std::nullopt;
}

Band nees_band_95(int dimension, int runs) {
    const double k = static_cast<double>(dimension) * runs, z = 1.959963985;
    return {chi_square_quantile(k, -z) / runs, chi_square_quantile(k, z) / runs};
}

}  // namespace loopline
