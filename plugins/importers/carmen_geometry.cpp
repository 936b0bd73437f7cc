#include "importers/carmen_geometry.h"

#include <cmath>

#include "api/parameters.h"

namespace loopline::carmen {
namespace {

/// Poses in these logs have six decimals; robots far from their origin and single precision cost some of
/// them.
constexpr double same_position_m = 2e-3, same_heading_rad = 1e-3;

bool are_same(const Pose2& a, const Pose2& b) {
    return std::abs(a.x_m - b.x_m) < same_position_m && std::abs(a.y_m - b.y_m) < same_position_m &&
           std::abs(wrap_to_pi(a.phi_rad - b.phi_rad)) < same_heading_rad;
}

}  // namespace

std::optional<double> aperture_of_beams_rad(std::size_t beams) {
    switch (beams) {
        case 180:
        case 181:
        case 360:
        case 361:
            return M_PI;
        case 401:
            return M_PI * 100 / 180;
        default:
            return std::nullopt;
    }
}

std::optional<double> number_parameter(const Log& log, const std::string& name) {
    const auto found = log.parameters.find(name);
    return found == log.parameters.end() ? std::nullopt : number_from_text(found->second);
}

Mounting find_mounting(const Log& log, Message message) {
    Mounting mounting;
    std::optional<Pose2> from_poses;
    for (const auto& record : log.records) {
        const auto* scan = std::get_if<Scan>(&record);
        if (!scan || scan->message != message || !scan->T_odom_laser || !scan->T_odom_base) continue;
        const Pose2 T_base_laser = scan->T_odom_base->inverse() * *scan->T_odom_laser;
        if (!from_poses) from_poses = T_base_laser;
        if (!are_same(*from_poses, T_base_laser)) mounting.corrected_poses = true;
    }
    if (from_poses && !mounting.corrected_poses && !are_same(*from_poses, Pose2{})) {
        mounting.T_base_laser = *from_poses;
        mounting.source = Mounting::Source::poses;
    } else if (const auto offset_m = number_parameter(log, "robot_frontlaser_offset")) {
        mounting.T_base_laser = {*offset_m, 0, 0};
        mounting.source = Mounting::Source::parameter;
    }
    return mounting;
}

}  // namespace loopline::carmen
