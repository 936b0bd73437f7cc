/// Occupancy grids as ROS map_server, Nav2 and AMCL read them: a PGM picture and a YAML file beside it.
#pragma once

#include <mrpt/maps/COccupancyGridMap2D.h>

#include <filesystem>

namespace loopline {

enum class Cell { occupied, free, unknown };

/// The thresholds that map_server and its map_saver use; they stand in the YAML file too.
constexpr double occupied_threshold = 0.65;
constexpr double free_threshold = 0.196;

/// map_server's trinary rule: occupied above 0.65, free below 0.196, unknown between.
inline Cell classify(double occupied_probability) {
    if (occupied_probability > occupied_threshold) return Cell::occupied;
    return occupied_probability < free_threshold ? Cell::free : Cell::unknown;
}

/// Writes `yaml` and the picture of the same name with ".pgm". Pixels are 0 occupied, 254 free, 205 unknown,
/// as map_saver writes them, so that every reader finds the cells of classify(), whichever thresholds it has
/// built in; the probabilities themselves are in the .gridmap. First picture row: largest y. `origin` is the
/// lower left corner of the lower left pixel, map frame.
void write_map_server_grid(const std::filesystem::path& yaml, const mrpt::maps::COccupancyGridMap2D& grid);

/// Reads such a pair from any source, by map_server's rules: modes trinary, scale and raw, negated or not,
/// and any picture that OpenCV reads. Occupied, free and unknown cells get the log-odds -127, 127 and 0, as
/// by MRPT's own reader (which prints a call stack when a file is damaged, and so is not used). Throws
/// CommandError(exit_input_data) with one sentence.
mrpt::maps::COccupancyGridMap2D::Ptr read_map_server_grid(const std::filesystem::path& yaml);

}  // namespace loopline
