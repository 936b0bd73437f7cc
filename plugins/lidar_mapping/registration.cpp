#include "lidar_mapping/registration.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

namespace loopline::lidar_mapping {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Of residuals e(x), x = (pose, velocity): a point seen s seconds after the middle of the sweep moves with
/// the velocity as s times as much with the pose, so three sums over the pose's Jacobians hold all.
struct NormalEquations {
    Matrix6d pose = Matrix6d::Zero(), both = Matrix6d::Zero(), velocity = Matrix6d::Zero();
    Vector6d to_pose = Vector6d::Zero(), to_velocity = Vector6d::Zero();
    double squares = 0;
    int used = 0;

    /// A residual `e` along `n`, at `arm` from the vehicle: de = n . shift + (arm x n) . turn.
    void add(const Eigen::Vector3d& n, const Eigen::Vector3d& arm, double s, double e, double weight) {
        Vector6d j;
        j << n, arm.cross(n);
        const Matrix6d jj = weight * j * j.transpose();
        pose += jj;
        both += s * jj;
        velocity += (s * s) * jj;
        to_pose -= (weight * e) * j;
        to_velocity -= (weight * s * e) * j;
    }
    Matrix12d information() const {
        Matrix12d I;
        I << pose, both, both, velocity;
        return I;
    }
    Vector12d gradient() const {
        Vector12d g;
        g << to_pose, to_velocity;
        return g;
    }
};

NormalEquations linearise(const SurfaceMap& map, const std::vector<SweepPoint>& points,
                          const MotionState& state, const RegistrationSettings& settings) {
    NormalEquations sums;
    const Eigen::Matrix3d R = state.T_map_base.rotation.toRotationMatrix();
    const double per_scale2 = 1 / (settings.loss_scale * settings.loss_scale);
    for (const SweepPoint& point : points) {
        const Eigen::Vector3d arm = R * undistorted(point, state.velocity);
        const SurfaceMatch match = map.find(state.T_map_base.translation_m + arm);
        if (match.kind == SurfaceKind::none) continue;
        const Eigen::Vector3d d = match.direction_map.cast<double>(), off = match.offset_m.cast<double>();
        const double per_variance = 1 / static_cast<double>(match.variance_m2), s = point.time_s;
        if (match.kind == SurfaceKind::plane) {
            const double e = d.dot(off), e2 = e * e * per_variance;
            sums.add(d, arm, s, e, per_variance / (1 + e2 * per_scale2));
            sums.squares += e2;
        } else {
            // Both directions across the edge.
            const Eigen::Vector3d across = off - d.dot(off) * d;
            const double distance = across.norm(), e2 = distance * distance * per_variance,
                         w = per_variance / (1 + e2 * per_scale2);
            const Eigen::Vector3d a =
                distance > 1e-9 ? Eigen::Vector3d(across / distance) : d.unitOrthogonal();
            sums.add(a, arm, s, distance, w);
            sums.add(d.cross(a), arm, s, 0, w);
            sums.squares += e2 / 2;
        }
        ++sums.used;
    }
    return sums;
}

}  // namespace

Registration register_sweep(const SurfaceMap& map, const std::vector<SweepPoint>& points,
                            const MotionState& predicted, const RegistrationSettings& settings) {
    Registration result;
    result.state = predicted;
    const Matrix12d prior = predicted.covariance.inverse();
    NormalEquations sums;
    Matrix12d information = prior;
    for (int i = 0; i < settings.iterations; ++i) {
        ++result.iterations;
        sums = linearise(map, points, result.state, settings);
        information = sums.information() + prior;
        const Vector12d step =
            information.ldlt().solve(sums.gradient() + prior * difference(predicted, result.state));
        if (!step.allFinite()) break;
        result.state = moved_by(result.state, step);
        if (step.head<3>().norm() < settings.enough_m && step.segment<3>(3).norm() < settings.enough_rad) {
            result.converged = true;
            break;
        }
    }
    result.state.covariance = information.inverse();
    result.information = sums.pose;
    result.used = sums.used;
    result.fit = points.empty() ? 0 : static_cast<double>(sums.used) / static_cast<double>(points.size());
    result.rms_sigmas = sums.used > 0 ? std::sqrt(sums.squares / sums.used) : 0;
    return result;
}

}  // namespace loopline::lidar_mapping
