/// The line map as CSV: a wall a row.
#pragma once

#include <cstddef>
#include <filesystem>

#include "api/line_map.h"

namespace loopline {

/// Every member of MapLine is finite. Lines that are not are left out of the files and counted.
bool is_finite(const MapLine& line);

/// Header with units, then a row a line, map frame. Returns how many lines were left out because they are not
/// finite.
std::size_t write_line_map_csv(const std::filesystem::path& file, const LineMap& lines);

/// What write_line_map_csv() wrote. Throws CommandError(exit_input_data) with one sentence and file:line
/// otherwise.
LineMap read_line_map_csv(const std::filesystem::path& file);

}  // namespace loopline
