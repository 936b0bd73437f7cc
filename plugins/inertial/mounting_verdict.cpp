// Which way up the IMU is, by gravity; about which of its axes it turns, and where its x axis points, by the
// odometry.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "inertial/imu_verdict.h"
#include "inertial/rotation_vector.h"
#include "inertial/words.h"

namespace loopline::inertial {
namespace {

using Sentences = std::vector<std::string>;

double degrees(double rad) {
    return rad * 180 / M_PI;
}

double angle_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return degrees(std::atan2(a.cross(b).norm(), a.dot(b)));
}

/// The axis of the vehicle that is within a few degrees, which floors lean by as well; else the direction
/// itself.
Eigen::Vector3d nearest_axis(const Eigen::Vector3d& direction) {
    constexpr double near_deg = 5;
    Eigen::Index i = 0;
    direction.cwiseAbs().maxCoeff(&i);
    const Eigen::Vector3d axis = (direction(i) < 0 ? -1 : 1) * Eigen::Vector3d::Unit(i);
    return angle_deg(axis, direction) < near_deg ? axis : direction;
}

/// "yaw_deg = 0, pitch_deg = 0, roll_deg = 90", of Rz Ry Rx.
std::string mount_keys(const Eigen::Matrix3d& R_base_imu) {
    const auto whole = [](double rad) { return std::to_string(std::lround(degrees(rad))); };
    const double pitch_rad = std::asin(std::clamp(-R_base_imu(2, 0), -1.0, 1.0));
    return "yaw_deg = " + whole(std::atan2(R_base_imu(1, 0), R_base_imu(0, 0))) +
           ", pitch_deg = " + whole(pitch_rad) +
           ", roll_deg = " + whole(std::atan2(R_base_imu(2, 1), R_base_imu(2, 2)));
}

/// A multiple of 90 deg that is as good as the measured yaw, since mounts are mostly square; else that yaw.
double likely_yaw_rad(const MountYaw& yaw) {
    constexpr double near_rad = 15 * M_PI / 180;
    const double square_rad = std::round(yaw.yaw_rad / (M_PI / 2)) * (M_PI / 2);
    const bool square = std::abs(yaw.yaw_rad - square_rad) < std::max(near_rad, 2 * yaw.sigma_rad);
    return square ? square_rad : yaw.yaw_rad;
}

std::optional<MountYaw> well_known_yaw(const ImuCheck& check, const Eigen::Matrix3d& R_upright) {
    constexpr double well_rad = 10 * M_PI / 180;
    const auto yaw = check.travel().mount_yaw(R_upright);
    return yaw && yaw->sigma_rad < well_rad ? yaw : std::nullopt;
}

std::string mount_section(const std::string& label) {
    return "say so with [mount] sensors = " + (label.empty() ? "its label" : label) + ", ";
}

/// The whole mount, with the yaw where driving has shown it.
std::string mount_advice(const ImuCheck& check, const Eigen::Vector3d& up_base, const std::string& label) {
    const Eigen::Matrix3d R_upright = upright(nearest_axis(up_base)).toRotationMatrix();
    const auto yaw = well_known_yaw(check, R_upright);
    if (!yaw)
        return mount_section(label) + mount_keys(R_upright * check.R_base_imu()) +
               " (gravity does not tell the yaw: add what x is off from forward)";
    const Eigen::Matrix3d R_yaw =
        Eigen::AngleAxisd(likely_yaw_rad(*yaw), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    return mount_section(label) + mount_keys(R_yaw * R_upright * check.R_base_imu()) +
           " (yaw as of accelerations, +- " + digits(degrees(yaw->sigma_rad), 2) + " deg)";
}

/// Of an IMU that is upright.
Sentences yaw_complaints(const ImuCheck& check, const std::string& label) {
    constexpr double worth_a_look_rad = 25 * M_PI / 180, sure = 4;
    const auto yaw = well_known_yaw(check, Eigen::Matrix3d::Identity());
    if (!yaw || std::abs(yaw->yaw_rad) < std::max(worth_a_look_rad, sure * yaw->sigma_rad)) return {};
    return {"feels accelerations of the odometry turned: its x axis points " +
            decimals(degrees(yaw->yaw_rad), 0) + " +- " + decimals(degrees(yaw->sigma_rad), 0) +
            " deg to the left of forward, where the log has it otherwise; " +
            mount_advice(check, Eigen::Vector3d::UnitZ(), label)};
}

}  // namespace

std::string mounting_remark(const ImuCheck& check) {
    constexpr double turned_deg = 5, agrees_deg = 30;
    const Eigen::Matrix3d& R_base_imu = check.R_base_imu();
    const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
    if (degrees(Eigen::AngleAxisd(R_base_imu).angle()) < turned_deg) return {};
    if (angle_deg(check.mean_specific_force_base_mps2(), z) > agrees_deg) return {};
    return "is mounted turned, as the log has it: its " + axis_name(R_base_imu.transpose() * z) +
           " axis points up, by gravity too (" + mount_keys(R_base_imu) + ")";
}

Sentences mounting_complaints(const ImuCheck& check, const Agreement& agreement, const std::string& label) {
    constexpr double level_deg = 5, tilted_deg = 30, same_deg = 25;
    const Eigen::Vector3d force_mps2 = check.mean_specific_force_base_mps2();
    if (force_mps2.norm() < 0.5) return {};  // gravity was taken out
    const Eigen::Vector3d z = Eigen::Vector3d::UnitZ(), up = force_mps2.normalized();
    const bool turns_known = agrees(agreement);
    const Eigen::Vector3d turns = turns_known ? agreement.peak.slope.normalized() : up;
    const double tilt_deg = angle_deg(up, z);

    const std::string of_gravity =
        "feels gravity along its " + axis_name(up) + " axis, " + decimals(force_mps2, 2) + " at its mean";
    const std::string of_turns = turns_known ? ", and turns with the odometry about its " + axis_name(turns) +
                                                   " axis (correlation " +
                                                   decimals(std::abs(agreement.correlation), 2) + ")"
                                             : "";
    if (angle_deg(turns, up) <= same_deg) {
        if (tilt_deg <= level_deg) return yaw_complaints(check, label);
        if (tilt_deg <= tilted_deg)
            return {"leans by " + digits(tilt_deg, 2) + " deg, by gravity of " + decimals(force_mps2, 2) +
                    ": it is mounted tilted, or the ground slopes; if the first, " +
                    mount_advice(check, up, label)};
        return {of_gravity + of_turns + ": it is mounted turned, where the log has it upright; " +
                mount_advice(check, up, label)};
    }
    if (angle_deg(turns, -up) > same_deg)
        return {of_gravity + of_turns +
                ": axes of gyro and accelerometers are mixed up; look at how its driver orders them"};
    if (angle_deg(turns, z) <= same_deg)
        return {
            of_gravity + of_turns +
            ": its accelerations have the wrong sign; at rest +9.8 is read along the axis that points up"};
    return {of_gravity + of_turns +
            ": rates or the odometry's heading have the wrong sign; angles are counter-clockwise seen from "
            "above"};
}

}  // namespace loopline::inertial
