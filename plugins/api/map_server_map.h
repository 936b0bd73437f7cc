/// An occupancy grid as ROS map_server, Nav2 and AMCL know it: a picture and a YAML file beside it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "api/pose2.h"

namespace loopline {

enum class MapCell : std::uint8_t { unknown, free, occupied };

struct MapServerMap {
    std::filesystem::path image;
    std::size_t width = 0, height = 0;  ///< cells; the lowest row and the leftmost column come first
    double resolution_m = 0;            ///< edge of a cell
    /// `picture`: x to the right, y upward, from the lower left corner of the lower left cell. The YAML
    /// file's origin, with its yaw.
    Pose2 T_map_picture;
    std::vector<float> free_probability;  ///< 0 .. 1, row by row; 0.5 where nothing is known
    std::vector<MapCell> cells;           ///< the same as the file's thresholds have it

    std::size_t index(std::size_t column, std::size_t row) const { return row * width + column; }
};

/// Reads such a pair from any source, by map_server's rules: modes trinary, scale and raw, negated or not,
/// and any picture that OpenCV reads. False with `problem`, a clause, if that is not possible.
bool read_map_server_map(const std::filesystem::path& yaml, MapServerMap& map, std::string& problem);

}  // namespace loopline
