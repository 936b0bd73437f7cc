/// The map that a key of the .ini names.
#pragma once

#include <filesystem>
#include <string>

#include "api/map_server_map.h"

namespace loopline::grid_slam {

/// The YAML file of a map: of a run directory the one that it holds, of a picture the one beside it. With
/// `problem`, a sentence, if there is none.
std::filesystem::path yaml_of_map(const std::filesystem::path& named, std::string& problem);

/// Reads it, and sees that a vehicle can be localised in it; else false with `problem`, a sentence.
bool read_map(const std::filesystem::path& named, MapServerMap& map, std::string& problem);

}  // namespace loopline::grid_slam
