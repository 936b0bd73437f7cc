#include "lidar_mapping/registration.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "inertial/rotation_vector.h"

namespace loopline::lidar_mapping {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

struct NormalEquations {
    Matrix6d information = Matrix6d::Zero();
    Vector6d gradient = Vector6d::Zero();
    double squares = 0;
    int used = 0;

    /// A residual `e` along `n`, at `arm` from the vehicle: e falls by n . shift + (arm x n) . turn.
    void add(const Eigen::Vector3d& n, const Eigen::Vector3d& arm, double e, double weight) {
        Vector6d j;
        j << n, arm.cross(n);
        information.selfadjointView<Eigen::Lower>().rankUpdate(j, weight);
        gradient -= (weight * e) * j;
    }
};

Twist3 velocity_to(const MotionPrior& prior, const Pose3& T_map_base) {
    if (!(prior.duration_s > 0)) return {};
    const Twist3 way = log_se3(prior.T_map_before.inverse() * T_map_base) * (1 / prior.duration_s);
    return {way.shift_m + 0.0 * prior.velocity_change.shift_m, way.turn_rad + 0.0 * prior.velocity_change.turn_rad};
}

NormalEquations linearise(const SurfaceMap& map, const std::vector<SweepPoint>& points, const Pose3& T_map_base,
                          const Twist3& velocity, const RegistrationSettings& settings) {
    NormalEquations sums;
    const Eigen::Matrix3d R = T_map_base.rotation.toRotationMatrix();
    const double range2 = settings.sigma_range_m * settings.sigma_range_m,
                 per_scale2 = 1 / (settings.loss_scale * settings.loss_scale);
    for (const SweepPoint& point : points) {
        const Eigen::Vector3d arm = R * undistorted(point, velocity);
        Surface::Kind kind{};
        Eigen::Vector3f direction, offset;
        float variance = 0;
        if (!map.find(T_map_base.translation_m + arm, kind, direction, offset, variance)) continue;
        const Eigen::Vector3d d = direction.cast<double>(), off = offset.cast<double>();
        const double per_variance = 1 / (range2 + static_cast<double>(variance));
        if (kind == Surface::Kind::plane) {
            const double e = d.dot(off), e2 = e * e * per_variance;
            sums.add(d, arm, e, per_variance / ((1 + e2 * per_scale2)));
            sums.squares += e2;
        } else {
            // Both directions across the edge.
            const Eigen::Vector3d across = off - d.dot(off) * d;
            const double distance = across.norm(), e2 = distance * distance * per_variance,
                         w = per_variance / (1 + e2 * per_scale2);
            const Eigen::Vector3d a = distance > 1e-9 ? Eigen::Vector3d(across / distance) : d.unitOrthogonal();
            sums.add(a, arm, distance, w);
            sums.add(d.cross(a), arm, 0, w);
            sums.squares += e2 / 2;
        }
        ++sums.used;
    }
    sums.information = Matrix6d(sums.information.selfadjointView<Eigen::Lower>());
    return sums;
}

}  // namespace

Registration register_sweep(const SurfaceMap& map, const std::vector<SweepPoint>& points,
                            const MotionPrior& prior, const RegistrationSettings& settings) {
    Registration result;
    result.T_map_base = prior.T_map_base;
    NormalEquations sums;
    for (int i = 0; i < settings.iterations; ++i) {
        ++result.iterations;
        Pose3& T = result.T_map_base;
        result.velocity = velocity_to(prior, T);
        sums = linearise(map, points, T, result.velocity, settings);
        Vector6d off;
        off << prior.T_map_base.translation_m - T.translation_m,
            inertial::log_so3(prior.T_map_base.rotation * T.rotation.conjugate());
        const Vector6d step = (sums.information + prior.information).ldlt().solve(sums.gradient + prior.information * off);
        if (!step.allFinite()) break;
        T.translation_m += step.head<3>();
        T.rotation = (inertial::exp_so3(step.tail<3>()) * T.rotation).normalized();
        if (step.head<3>().norm() < settings.enough_m && step.tail<3>().norm() < settings.enough_rad) {
            result.converged = true;
            break;
        }
    }
    result.velocity = velocity_to(prior, result.T_map_base);
    result.information = sums.information;
    result.used = sums.used;
    result.fit = points.empty() ? 0 : static_cast<double>(sums.used) / static_cast<double>(points.size());
    result.rms_sigmas = sums.used > 0 ? std::sqrt(sums.squares / sums.used) : 0;
    return result;
}

}  // namespace loopline::lidar_mapping
