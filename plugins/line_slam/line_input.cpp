#include "line_slam/line_input.h"

namespace loopline::line_slam {

LineObservation observation_in_base(const lines::LineSegment& segment, const Pose2& T_base_sensor,
                                    double sigma_wall_m) {
    LineObservation z;
    const PlanarLine in_sensor{segment.rho_m, segment.alpha_rad};
    z.line = transformed(T_base_sensor, in_sensor);
    z.start_m = T_base_sensor * segment.start_m;
    z.end_m = T_base_sensor * segment.end_m;

    // Both parts as (rho, alpha) about the base: rho_base = rho_sensor + n(alpha_base) . t_base_sensor.
    Eigen::Matrix2d to_base;
    to_base << 1, z.line.along_m(T_base_sensor.translation()), 0, 1;
    const double middle_m = z.line.along_m(z.middle_m());
    Eigen::Matrix2d about_middle;
    about_middle << 1, middle_m, 0, 1;
    const double length_m = std::max(segment.length_m(), 1e-3);
    const double variance_m2 = sigma_wall_m * sigma_wall_m;
    const Eigen::Matrix2d wall =
        Eigen::Vector2d(0.5 * variance_m2, 2 * variance_m2 / (length_m * length_m)).asDiagonal();
    z.wall_covariance = about_middle * wall * about_middle.transpose();
    z.covariance = to_base * segment.covariance * to_base.transpose() + z.wall_covariance;
    return z;
}

void deskew(const lines::LineSegment& segment, const SweepTime& sweep, const SweepMotion& motion,
            LineObservation& z) {
    const double start_s = sweep.after_stamp_s(segment.first_beam),
                 end_s = sweep.after_stamp_s(segment.last_beam);
    const Eigen::Vector2d start_m = exp_se2(motion.velocity_base * start_s) * z.start_m;
    const Eigen::Vector2d end_m = exp_se2(motion.velocity_base * end_s) * z.end_m;
    const Eigen::Vector2d before = z.end_m - z.start_m, after = end_m - start_m;
    const double turn_rad = std::atan2(before.x() * after.y() - before.y() * after.x(), before.dot(after));
    z.line.alpha_rad = wrap_to_pi(z.line.alpha_rad + turn_rad);
    z.line.rho_m = z.line.normal().dot(0.5 * (start_m + end_m));
    z.start_m = start_m;
    z.end_m = end_m;
    Eigen::Matrix<double, 2, 3> from_motion;
    from_motion << z.line.normal().transpose(), 0, 0, 0, 1;
    z.covariance += from_motion * (0.5 * (start_s + end_s) * motion.noise_per_s) * from_motion.transpose();
}

}  // namespace loopline::line_slam
