/// The files of all maps of a run, by kind.
#pragma once

#include <filesystem>

#include "api/results.h"
#include "output/file_list.h"

namespace loopline {

/// Lines, grids, points and simple maps as `map.NAME.*`; NAME is "lines", "grid" or "points" (and a simple
/// map is plainly map.simplemap) where the kind has one map, the map's own name where it has several.
void write_map_files(const std::filesystem::path& folder, const Results& results, FileList& list);

}  // namespace loopline
