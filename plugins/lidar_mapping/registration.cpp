#include "lidar_mapping/registration.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <array>
#include <cmath>

namespace loopline::lidar_mapping {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Of residuals e(x), x = (pose, velocity): a point seen s seconds after the middle of the sweep moves with
/// the velocity s times as much as with the pose, so three sums over the pose's Jacobians hold all.
struct NormalEquations {
    Matrix6d pose = Matrix6d::Zero(), both = Matrix6d::Zero(), velocity = Matrix6d::Zero();
    Vector6d to_pose = Vector6d::Zero(), to_velocity = Vector6d::Zero();
    /// What the noise of normals adds to `pose`: it looks like information across to them.
    Matrix6d by_chance = Matrix6d::Zero();
    double squares = 0, support = 0, range_m = 0;
    int used = 0;

    static Vector6d jacobian(const Eigen::Vector3d& n, const Eigen::Vector3d& arm) {
        Vector6d j;
        j << n, arm.cross(n);
        return j;
    }
    /// A residual `e` along `n`, at `arm` from the vehicle: de = n . shift + (arm x n) . turn.
    void add(const Eigen::Vector3d& n, const Eigen::Vector3d& arm, double s, double e, double weight) {
        const Vector6d j = jacobian(n, arm);
        const Matrix6d jj = weight * j * j.transpose();
        pose += jj;
        both += s * jj;
        velocity += (s * s) * jj;
        to_pose -= (weight * e) * j;
        to_velocity -= (weight * s * e) * j;
    }
    void add_chance(const Eigen::Vector3d& direction, const Eigen::Vector3d& arm, double weight) {
        const Vector6d j = jacobian(direction, arm);
        by_chance += weight * j * j.transpose();
    }
    void operator+=(const NormalEquations& o) {
        pose += o.pose;
        both += o.both;
        velocity += o.velocity;
        to_pose += o.to_pose;
        to_velocity += o.to_velocity;
        by_chance += o.by_chance;
        squares += o.squares;
        support += o.support;
        range_m += o.range_m;
        used += o.used;
    }
};

/// What a sweep says about (shift, turn), by directions, a turn counting by what it moves at the mean range.
class HeldDirections {
 public:
    HeldDirections(const NormalEquations& sums, double sigma_limit_m)
        : least_(1 / (sigma_limit_m * sigma_limit_m)) {
        const double range_m = std::max(1.0, sums.range_m / std::max(1, sums.used));
        scale_ << 1, 1, 1, 1 / range_m, 1 / range_m, 1 / range_m;
        eigen_.compute(scale_.asDiagonal() * (sums.pose - sums.by_chance) * scale_.asDiagonal());
    }
    /// The information that is not chance, without the directions that it holds too little.
    Matrix6d information() const {
        const Vector6d kept = (eigen_.eigenvalues().array() < least_).select(0, eigen_.eigenvalues());
        const Matrix6d axes = scale_.cwiseInverse().asDiagonal() * eigen_.eigenvectors();
        return axes * kept.asDiagonal() * axes.transpose();
    }
    Degeneracy degeneracy() const {
        Degeneracy result;
        result.free_directions = static_cast<int>((eigen_.eigenvalues().array() < least_).count());
        result.weakest_sigma_m = 1 / std::sqrt(std::max(eigen_.eigenvalues()[0], 1e-6));
        result.weakest = scale_.asDiagonal() * eigen_.eigenvectors().col(0);
        return result;
    }

 private:
    double least_;
    Vector6d scale_;
    Eigen::SelfAdjointEigenSolver<Matrix6d> eigen_;
};

/// On (pose, velocity). Where the scan's own optimum is, stays; what it counts with, is what is real.
struct Evidence {
    Matrix12d information;
    Vector12d gradient;

    Evidence(const NormalEquations& sums, const Matrix6d& real) {
        // T A T' = real: T = L V sqrt(r) V' L^-1 with A = L L' and the eigenvalues r of L^-1 real L^-T.
        const Eigen::LLT<Matrix6d> llt(sums.pose + 1e-6 * Matrix6d::Identity());
        const Matrix6d L = llt.matrixL(), to_unit = L.inverse();
        const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(to_unit * real * to_unit.transpose());
        const Matrix6d& V = eigen.eigenvectors();
        const Matrix6d T =
            L * V * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() * V.transpose() * to_unit;
        const Matrix6d both = T * sums.both * T.transpose();
        information << real, both, both, T * sums.velocity * T.transpose();
        gradient << T * (T * sums.to_pose), T * (T * sums.to_velocity);
    }
};

void add_point(const SurfaceMatch& match, const Eigen::Vector3d& arm, double s, double per_scale2,
               NormalEquations& sums) {
    const Eigen::Vector3d d = match.direction_map.cast<double>(), off = match.offset_m.cast<double>();
    const double per_variance = 1 / static_cast<double>(match.variance_m2);
    double e2 = 0, loss = 1;
    if (match.kind == SurfaceKind::plane) {
        const double e = d.dot(off);
        e2 = e * e * per_variance;
        loss = 1 / (1 + e2 * per_scale2);
        const double w = per_variance * loss;
        sums.add(d, arm, s, e, w);
        sums.add_chance(match.along_map.cast<double>(), arm, w * static_cast<double>(match.turn_along));
        sums.add_chance(match.beside_map.cast<double>(), arm, w * static_cast<double>(match.turn_beside));
        sums.squares += e2;
    } else {
        // Both directions across the edge.
        const Eigen::Vector3d across = off - d.dot(off) * d;
        const double distance = across.norm();
        e2 = distance * distance * per_variance;
        loss = 1 / (1 + e2 * per_scale2);
        const double w = per_variance * loss;
        const Eigen::Vector3d a = distance > 1e-9 ? Eigen::Vector3d(across / distance) : d.unitOrthogonal();
        sums.add(a, arm, s, distance, w);
        sums.add(d.cross(a), arm, s, 0, w);
        sums.squares += e2 / 2;
    }
    ++sums.used;
    sums.support += loss;
    sums.range_m += arm.norm();
}

/// In parts that are always the same, whoever computes them, and added up in their order.
NormalEquations linearise(const SurfaceMap& map, const std::vector<SweepPoint>& points,
                          const MotionState& state, const RegistrationSettings& settings,
                          WorkerPool& workers) {
    constexpr std::size_t parts = 8;
    std::array<NormalEquations, parts> sums;
    const Eigen::Matrix3d R = state.T_map_base.rotation.toRotationMatrix();
    const double per_scale2 = 1 / (settings.loss_scale * settings.loss_scale);
    workers.run(parts, [&](std::size_t part) {
        const std::size_t end = (part + 1) * points.size() / parts;
        for (std::size_t i = part * points.size() / parts; i < end; ++i) {
            const SweepPoint& point = points[i];
            const Eigen::Vector3d arm = R * undistorted(point, state.velocity);
            const SurfaceMatch match = map.find(state.T_map_base.translation_m + arm);
            if (match.kind != SurfaceKind::none)
                add_point(match, arm, static_cast<double>(point.time_s), per_scale2, sums[part]);
        }
    });
    for (std::size_t part = 1; part < parts; ++part) sums[0] += sums[part];
    return sums[0];
}

}  // namespace

Registration register_sweep(const SurfaceMap& map, const std::vector<SweepPoint>& points,
                            const MotionState& predicted, const RegistrationSettings& settings,
                            WorkerPool& workers) {
    Registration result;
    result.state = predicted;
    const Matrix12d prior = predicted.covariance.inverse();
    NormalEquations sums;
    Matrix12d information = prior;
    for (int i = 0; i < settings.iterations && !result.converged; ++i) {
        ++result.iterations;
        sums = linearise(map, points, result.state, settings, workers);
        const HeldDirections held(sums, settings.sigma_degenerate_m);
        result.degeneracy = held.degeneracy();
        result.information = held.information();
        const Evidence scan(sums, result.information);
        information = scan.information + prior;
        const Vector12d step =
            information.ldlt().solve(scan.gradient + prior * difference(predicted, result.state));
        if (!step.allFinite()) break;
        result.state = moved_by(result.state, step);
        result.converged =
            step.head<3>().norm() < settings.enough_m && step.segment<3>(3).norm() < settings.enough_rad;
    }
    result.state.covariance = information.inverse();
    const double used = std::max(1, sums.used);
    result.used = sums.used;
    result.support = sums.support;
    result.fit = points.empty() ? 0 : sums.used / static_cast<double>(points.size());
    result.rms_sigmas = std::sqrt(sums.squares / used);
    return result;
}

}  // namespace loopline::lidar_mapping
