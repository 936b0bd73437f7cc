#include "lidar_mapping/registration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "api/dense_algebra.h"
#include "least_squares/held_directions.h"
#include "lidar_mapping/shared_errors.h"

namespace loopline::lidar_mapping {
namespace {

using least_squares::HeldDirections;

/// When in the sweep a point was seen: it moves with the velocity, the acceleration and the jerk as with the
/// pose, times this.
struct TimeInSweep {
    Eigen::Vector4d factors;
    Eigen::Matrix<double, 10, 1> products;  ///< of any two of them
    TimeInSweep(const SweepMotion& motion, double s)
        : factors(1, motion.by_velocity_s(s), s * s / 2, s * s * s / 6) {
        for (int a = 0, k = 0; a < 4; ++a)
            for (int b = a; b < 4; ++b, ++k) products[k] = factors[a] * factors[b];
    }
};

/// Upper triangle of a sum of w J J', row by row, and a zero.
using Triangle = Eigen::Matrix<double, 22, 1>;

void add_to(Triangle& triangle, const Vector6d& j, double weight) {
    for (int r = 0, k = 0; r < 6; ++r)
        for (int c = r; c < 6; ++c, ++k) triangle[k] += weight * j[r] * j[c];
}

/// Of residuals e(x), x = (pose, velocity, acceleration, jerk): sums over the pose's Jacobians by their times
/// hold all.
struct QuadraticForm {
    Eigen::Matrix<double, 22, 10> sums = Eigen::Matrix<double, 22, 10>::Zero();

    void add(const Triangle& jj, const TimeInSweep& time) {
        for (int k = 0; k < 10; ++k) sums.col(k) += time.products[k] * jj;
    }
    Matrix6d block(int k) const {
        Matrix6d m;
        for (int r = 0, i = 0; r < 6; ++r)
            for (int c = r; c < 6; ++c, ++i) m(r, c) = m(c, r) = sums(i, k);
        return m;
    }
    Matrix6d pose() const { return block(0); }
    SweepMatrix matrix() const {
        SweepMatrix m;
        for (int a = 0, k = 0; a < 4; ++a)
            for (int b = a; b < 4; ++b, ++k)
                m.block<6, 6>(6 * a, 6 * b) = m.block<6, 6>(6 * b, 6 * a) = block(k);
        return m;
    }
};

/// Normals have errors, which look like information across to them, sum(w J J') = real + chance, and pull
/// returns to where those were that the surface was made of, sum(w J e) = real + chance: both are known, and
/// kept beside. (Errors in variables; corrected least squares: Fuller 1987, "Measurement error models", 1.2.)
struct NormalEquations {
    QuadraticForm all, chance;
    Eigen::Matrix<double, 6, 4> gradient = Eigen::Matrix<double, 6, 4>::Zero();
    double squares = 0, support = 0, range_m = 0, sweep = 0;
    int used = 0;

    double mean_range_m() const { return std::max(1.0, range_m / std::max(1, used)); }
    void operator+=(const NormalEquations& o) {
        all.sums += o.all.sums;
        chance.sums += o.chance.sums;
        gradient += o.gradient;
        squares += o.squares;
        support += o.support;
        range_m += o.range_m;
        sweep += o.sweep;
        used += o.used;
    }
};

/// What a point at `arm_m` from the vehicle says about the pose.
class OnePoint {
 public:
    explicit OnePoint(const Eigen::Vector3d& arm_m) : arm_m_(arm_m) {}
    /// A residual `e` along `n`: de = n . shift + (arm x n) . turn. Returns the Jacobian.
    Vector6d add(const Eigen::Vector3d& n, double e_m, double weight) {
        const Vector6d j = jacobian(n);
        add_to(all_, j, weight);
        gradient_ -= weight * e_m * j;
        return j;
    }
    /// The normal errs towards `across`, `weight` holds the variance of that; `offset` is the return's from
    /// the surface.
    Vector6d add_chance(const Eigen::Vector3d& across, double offset_m, double weight) {
        const Vector6d j = jacobian(across);
        add_to(chance_, j, weight);
        gradient_ += weight * offset_m * j;
        return j;
    }
    const Vector6d& gradient() const { return gradient_; }
    void add_to_sums(const TimeInSweep& time, NormalEquations& sums) const {
        sums.all.add(all_, time);
        sums.chance.add(chance_, time);
        sums.gradient += gradient_ * time.factors.transpose();
    }

 private:
    Vector6d jacobian(const Eigen::Vector3d& n) const {
        Vector6d j;
        j << n, arm_m_.cross(n);
        return j;
    }
    Eigen::Vector3d arm_m_;
    Triangle all_ = Triangle::Zero(), chance_ = Triangle::Zero();
    Vector6d gradient_ = Vector6d::Zero();
};

/// What one point says about the pose: Jacobians by the standard deviation, an edge has two, and those of
/// what looks so by chance.
struct PointSays {
    Eigen::Matrix<double, 6, 2> all = Eigen::Matrix<double, 6, 2>::Zero(), chance = all;
    Eigen::Vector3d arm_m = Eigen::Vector3d::Zero();
    Vector6d gradient = Vector6d::Zero();
    Eigen::Vector4d factors = Eigen::Vector4d::Zero();
};

/// Chance is known in the mean; what it is in a sweep differs from that.
constexpr double uncertain_chance = 1.5;

/// What the `few` points that say most about a motion say about it.
double by_the_few(const std::vector<PointSays>& points, const Vector6d& motion, std::size_t few) {
    std::vector<double> says;
    for (const PointSays& point : points)
        says.push_back(uncertain_chance * (point.chance.transpose() * motion).squaredNorm() -
                       (point.all.transpose() * motion).squaredNorm());
    const auto end = says.begin() + static_cast<std::ptrdiff_t>(std::min(few, says.size()));
    std::partial_sort(says.begin(), end, says.end());
    return -std::accumulate(says.begin(), end, 0.0);
}

/// What a sweep says about (shift, turn). In a map that is made of the sweeps before, a few points may be of
/// a plane that is none, as one ring on the ground and a twig above make it, or of somebody who moves: others
/// must hold the direction too.
HeldDirections held_by(const NormalEquations& sums, const std::vector<PointSays>& points,
                       const RegistrationSettings& settings) {
    constexpr double in_doubt_m = 0.01, and_others = 0.25;
    HeldDirections held(sums.all.pose() - uncertain_chance * sums.chance.pose(), sums.mean_range_m(),
                        settings.sigma_degenerate_m);
    held.without(in_doubt_m, [&](const Vector6d& motion) {
        return (1 + and_others) * by_the_few(points, motion, settings.few);
    });
    return held;
}

/// Of the gradient, if each point errs by itself.
SweepMatrix noise_of(const NormalEquations& sums) {
    SweepMatrix noise = sums.all.matrix();
    noise.diagonal().array() += 1e-3;
    return noise;
}

/// On all that undistorts the sweep: its own optimum R^-1 g, R what is real, has the covariance R^-1 N R^-1,
/// N the gradient's.
struct Evidence {
    SweepMatrix information;
    SweepVector gradient;
    SweepMatrix onto_held = SweepMatrix::Zero();  ///< of a step

    Evidence(const NormalEquations& sums, const HeldDirections& held, const SweepMatrix& noise) {
        for (int at = 0; at < sweep_errors; at += 6) onto_held.block<6, 6>(at, at) = held.projection();
        const SweepMatrix onto = onto_held.transpose(),
                          real = propagated(onto, sums.all.matrix() - sums.chance.matrix());
        const Eigen::Map<const SweepVector> g(sums.gradient.data());
        const SweepMatrix by_noise = solved(noise, real).transpose();
        information = by_noise * real;
        gradient = by_noise * (onto * g);
    }
};

PointSays add_point(const SurfaceMatch& match, const Eigen::Vector3d& arm, const TimeInSweep& time,
                    double per_scale2, NormalEquations& sums) {
    PointSays says;
    OnePoint point(arm);
    const Eigen::Vector3d d = match.direction_map.cast<double>(), off = match.offset_m.cast<double>();
    const double per_variance = 1 / static_cast<double>(match.variance_m2);
    double e2 = 0, loss = 1;
    if (match.kind == SurfaceKind::plane) {
        const double e = d.dot(off);
        e2 = e * e * per_variance;
        loss = 1 / (1 + e2 * per_scale2);
        const double w = per_variance * loss;
        says.all.col(0) = std::sqrt(w) * point.add(d, e, w);
        const Eigen::Vector3d along = match.along_map.cast<double>(),
                              beside = match.beside_map.cast<double>();
        const double w_along = w * static_cast<double>(match.turn_along),
                     w_beside = w * static_cast<double>(match.turn_beside);
        says.chance.col(0) = std::sqrt(w_along) * point.add_chance(along, along.dot(off), w_along);
        says.chance.col(1) = std::sqrt(w_beside) * point.add_chance(beside, beside.dot(off), w_beside);
        sums.squares += e2;
    } else {
        // Both directions across the edge.
        const Eigen::Vector3d across = off - d.dot(off) * d;
        const double distance = across.norm();
        e2 = distance * distance * per_variance;
        loss = 1 / (1 + e2 * per_scale2);
        const double w = per_variance * loss;
        const Eigen::Vector3d a = distance > 1e-9 ? Eigen::Vector3d(across / distance) : d.unitOrthogonal();
        says.all.col(0) = std::sqrt(w) * point.add(a, distance, w);
        says.all.col(1) = std::sqrt(w) * point.add(d.cross(a), 0, w);
        sums.squares += e2 / 2;
    }
    point.add_to_sums(time, sums);
    ++sums.used;
    sums.support += loss;
    sums.sweep += loss * static_cast<double>(match.sweep);
    sums.range_m += arm.norm();
    says.arm_m = arm;
    says.gradient = point.gradient();
    says.factors = time.factors;
    return says;
}

/// In parts that are always the same, whoever computes them, and added up in their order.
NormalEquations linearise(const SurfaceMap& map, const std::vector<SweepPoint>& points,
                          const MotionState& state, const RegistrationSettings& settings, WorkerPool& workers,
                          std::vector<PointSays>& says) {
    constexpr std::size_t parts = 8;
    std::array<NormalEquations, parts> sums;
    const Eigen::Matrix3d R = state.T_map_base.rotation.toRotationMatrix();
    const Eigen::Matrix3f beams = R.cast<float>();
    const SweepMotion motion(state);
    const double per_scale2 = 1 / (settings.loss_scale * settings.loss_scale);
    says.assign(points.size(), {});
    workers.run(parts, [&](std::size_t part) {
        const std::size_t end = (part + 1) * points.size() / parts;
        std::array<Eigen::Vector3d, SurfaceMap::at_once> arms;
        std::array<MapReturn, SurfaceMap::at_once> seen;
        std::array<SurfaceMatch, SurfaceMap::at_once> matches;
        for (std::size_t i = part * points.size() / parts; i < end; i += SurfaceMap::at_once) {
            const std::size_t count = std::min(SurfaceMap::at_once, end - i);
            for (std::size_t k = 0; k < count; ++k) {
                arms[k] = R * undistorted(points[i + k], motion);
                seen[k] = {state.T_map_base.translation_m + arms[k], beams * points[i + k].beam_base};
            }
            map.find(seen.data(), count, settings.smallest_size, matches.data());
            for (std::size_t k = 0; k < count; ++k)
                if (matches[k].kind != SurfaceKind::none)
                    says[i + k] =
                        add_point(matches[k], arms[k], {motion, static_cast<double>(points[i + k].time_s)},
                                  per_scale2, sums[part]);
        }
    });
    for (std::size_t part = 1; part < parts; ++part) sums[0] += sums[part];
    return sums[0];
}

SharedErrors errors_of(const std::vector<PointSays>& says) {
    SharedErrors errors;
    for (const PointSays& point : says) {
        const Eigen::Matrix<double, 6, 4> gradient = point.gradient * point.factors.transpose();
        errors.add(point.arm_m, Eigen::Map<const SweepVector>(gradient.data()));
    }
    return errors;
}

}  // namespace

/// What the sweep leaves free is left as predicted (Schmidt 1966, consider filter). Its own zero information
/// there is not enough: which direction is free, each sweep tells with an error, and would hold by walls that
/// it knows to a millimetre what others leave free; a hundred of them would tell of a way along a tunnel that
/// none can see.
Registration register_sweep(const SurfaceMap& map, const std::vector<SweepPoint>& points,
                            const MotionState& predicted, const RegistrationSettings& settings,
                            WorkerPool& workers, const MotionState* start) {
    Registration result;
    result.state = start != nullptr ? *start : predicted;
    const SweepMatrix before = sweep_covariance(predicted), prior = inverse_of(before);
    NormalEquations sums;
    std::vector<PointSays> says;
    SweepMatrix gain = SweepMatrix::Zero(), of_scan = gain;
    const auto step_from = [&](const MotionState& at, const Evidence& scan) {
        of_scan = scan.information;
        gain = scan.onto_held * inverse_of(scan.information + prior);
        const SweepVector to_predicted = sweep_difference(predicted, at);
        return SweepVector(to_predicted + gain * (scan.gradient - scan.information * to_predicted));
    };
    for (int i = 0; i < settings.iterations && !result.converged; ++i) {
        ++result.iterations;
        const MotionState at = result.state;
        sums = linearise(map, points, at, settings, workers, says);
        const HeldDirections held = held_by(sums, says, settings);
        result.degeneracy = {held.free_count(), held.weakest_sigma_m(), held.weakest()};
        const SweepMatrix noise = noise_of(sums);
        SweepVector step = step_from(at, Evidence(sums, held, noise));
        if (!step.allFinite()) break;
        result.converged =
            step.head<3>().norm() < settings.enough_m && step.segment<3>(3).norm() < settings.enough_rad;
        if (result.converged || i + 1 == settings.iterations)
            step = step_from(at, Evidence(sums, held, errors_of(says).covariance(noise)));
        result.state = sweep_moved_by(at, step);
    }
    const SweepMatrix left = SweepMatrix::Identity() - gain * of_scan, by_scan = propagated(gain, of_scan),
                      by_prediction = propagated(left, before);
    result.state.covariance = (by_scan + by_prediction).topLeftCorner<12, 12>();
    result.predicted = predicted.covariance.topLeftCorner<6, 6>();
    result.correction = difference(result.state, predicted).head<6>();
    result.left = left.topLeftCorner<6, 6>();
    result.by_scan = by_scan.topLeftCorner<6, 6>();
    result.by_prediction = by_prediction.topLeftCorner<6, 6>();
    if (result.degeneracy.free_directions == 0) result.state.way_on_trust_m = 0;
    if (sums.support > 0) result.age_sweeps = map.sweeps() - sums.sweep / sums.support;
    const double used = std::max(1, sums.used);
    result.mean_range_m = sums.mean_range_m();
    result.used = sums.used;
    result.support = sums.support;
    result.fit = points.empty() ? 0 : sums.used / static_cast<double>(points.size());
    result.rms_sigmas = std::sqrt(sums.squares / used);
    return result;
}

}  // namespace loopline::lidar_mapping
