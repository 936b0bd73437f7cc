#include "lidar_mapping/given_motion.h"

#include "api/dense_algebra.h"
#include "inertial/pose_error.h"

namespace loopline::lidar_mapping {
namespace {

Twist3 with_planar(Twist3 twist, const Twist3& planar) {
    twist.shift_m.head<2>() = planar.shift_m.head<2>();
    twist.turn_rad.z() = planar.turn_rad.z();
    return twist;
}

}  // namespace

MotionState predict(const MotionState& state, const GivenMotion& given, double duration_s,
                    const MotionNoise& noise) {
    MotionState next = state;
    expect_unevenness(next, noise);
    const Vector6d accelerations = noise.sigmas();
    next.velocity = given.planar ? with_planar(state.velocity, given.velocity) : given.velocity;
    next.velocity_before = state.velocity;
    next.duration_s = duration_s;
    Pose3 T_last_now = given.T_last_now;
    // Along the vehicle's axes: of the motion, and of the velocity, which changes within it.
    Matrix6d motion = given.covariance;
    Matrix6d velocity = given.velocity_covariance;
    velocity.diagonal() += (accelerations * given.velocity_over_s).cwiseAbs2();
    // What wheels do not tell goes on with the velocity that the sweeps show: their errors belong together.
    Vector6d goes_on = Vector6d::Zero();
    Matrix6d together = Matrix6d::Zero();
    if (given.planar) {
        T_last_now = exp_se3(with_planar(state.velocity * duration_s, log_se3(given.T_last_now)));
        for (const Eigen::Index k : {2, 3, 4}) {
            const double change = accelerations[k] * duration_s, shift = change * duration_s / 2;
            goes_on[k] = 1;
            motion(k, k) = shift * shift;
            velocity(k, k) = change * change;
            together(k, k) = shift * change;
        }
    }
    next.T_map_base = state.T_map_base * T_last_now;

    const Eigen::Vector3d way_m = next.T_map_base.translation_m - state.T_map_base.translation_m;
    const Matrix6d R = inertial::turned_both(state.T_map_base.rotation),
                   kept = propagated(R, goes_on.asDiagonal().toDenseMatrix());
    Matrix12d F = Matrix12d::Zero(), Q;
    F.topLeftCorner<6, 6>() = inertial::carried_along(way_m);
    F.topRightCorner<6, 6>() = duration_s * kept;
    F.bottomRightCorner<6, 6>() = kept;
    Q << propagated(R, motion), propagated(R, together), propagated(R, together), propagated(R, velocity);
    next.covariance = propagated(F, state.covariance) + Q;
    // What a whole way is off by that nothing else tells, less what was of it before.
    const double length_m = way_m.norm(), off2 = given.sigma_scale * given.sigma_scale;
    next.way_on_trust_m += length_m;
    if (length_m > 0)
        next.covariance.topLeftCorner<3, 3>() +=
            off2 * (2 * state.way_on_trust_m + length_m) / length_m * way_m * way_m.transpose();
    return next;
}

}  // namespace loopline::lidar_mapping
