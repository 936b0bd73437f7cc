/// What a CARMEN log says, or leaves to be guessed, about the laser: its aperture, its range and where it
/// sits.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "importers/carmen_log.h"

namespace loopline::carmen {

/// From the first to the last beam. The SICK lasers of these logs have 180 or 181, 360 or 361 beams over 180
/// degrees, or 401 over 100 degrees; `nullopt` for any other number.
std::optional<double> aperture_of_beams_rad(std::size_t beams);

/// PARAM `name` as a number.
std::optional<double> number_parameter(const Log& log, const std::string& name);

/// Where the laser sits on the vehicle, and how that is known.
struct Mounting {
    enum class Source {
        poses,      ///< the laser and robot poses of all scans differ by this
        parameter,  ///< PARAM robot_frontlaser_offset
        given,      ///< by the person
        unknown     ///< nothing says so: at the origin
    };
    Pose2 T_base_laser;
    Source source = Source::unknown;
    /// The laser and robot poses do not differ by one constant motion: a mapper wrote corrected poses in the
    /// place of the laser's.
    bool corrected_poses = false;
};

/// Laser poses equal to the robot poses in every scan say nothing, since many converters write them so: then
/// the parameter counts.
Mounting find_mounting(const Log& log, Message message);

}  // namespace loopline::carmen
