/// The text logs of CARMEN (the Carnegie Mellon robot navigation toolkit), the format of the classic 2D laser
/// logs.
///
///     FLASER n r1 .. rn  x y theta  odom_x odom_y odom_theta  ipc_time ipc_host logger_time
///     ROBOTLASER1 type start_angle fov resolution max_range accuracy remission_mode n r1 .. rn m e1 .. em
///                 laser_x laser_y laser_theta  x y theta  tv rv safety_forward safety_side turn_axis
///                 ipc_time ipc_host logger_time
///     RAWLASER1 type start_angle fov resolution max_range accuracy remission_mode n r1 .. rn m e1 .. em
///     ipc_time ipc_host logger_time ODOM x y theta tv rv acceleration  ipc_time ipc_host logger_time PARAM
///     name value  ipc_time ipc_host logger_time
///
/// Angles in radians, lengths in metres, times in seconds. Every other message is skipped and counted.
#pragma once

#include <cstddef>
#include <istream>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "api/pose2.h"
#include "api/stamp.h"

namespace loopline::carmen {

/// When a message was sent, and when the logger wrote it.
struct Times {
    StampNs ipc_ns = 0;
    StampNs logger_ns = 0;
};

struct Odometry {
    Times times;
    Pose2 T_odom_base;
    double speed_mps = 0;
    double turn_rate_radps = 0;
};

/// What the newer messages say about the sensor.
struct LaserConfiguration {
    double start_angle_rad = 0;  ///< of the first beam, against the laser's own forward direction
    double resolution_rad = 0;
    double max_range_m = 0;
};

enum class Message { flaser, robotlaser, rawlaser };
const char* name_of(Message message);

struct Scan {
    Message message = Message::flaser;
    Times times;
    std::vector<float> ranges_m;  ///< counter-clockwise; 0 where the log has no finite number
    std::optional<LaserConfiguration> configuration;
    std::optional<Pose2>
        T_odom_laser;  ///< FLASER and ROBOTLASER1; a corrected robot pose in logs that some mapper wrote
    std::optional<Pose2> T_odom_base;
};

using Record = std::variant<Odometry, Scan>;

struct Log {
    std::vector<Record> records;                    ///< in the file's order, whatever the stamps say
    std::map<std::string, std::string> parameters;  ///< PARAM lines, the last of a name
    std::map<std::string, std::size_t> skipped;     ///< other messages, by their name
    std::vector<std::string> damaged;  ///< a sentence with file:line for every line that was left out
};

/// Appends what `input` holds. A line that does not keep to the format is reported in `damaged` and left out.
void read_log(std::istream& input, const std::string& name, Log& log);

}  // namespace loopline::carmen
