#include <cmath>
#include <string>

#include "api/map_server_map.h"
#include "commands/command.h"
#include "output/map_server_grid.h"

namespace loopline {

using mrpt::maps::COccupancyGridMap2D;

namespace {

[[noreturn]] void refuse(const std::filesystem::path& yaml, const std::string& why) {
    throw CommandError(exit_input_data, "can't read the grid map " + yaml.string() + ": " + why +
                                            "; give a YAML file as map_server and map_saver have it");
}

}  // namespace

COccupancyGridMap2D::Ptr read_map_server_grid(const std::filesystem::path& yaml) {
    MapServerMap map;
    std::string problem;
    if (!read_map_server_map(yaml, map, problem)) refuse(yaml, problem);
    if (std::abs(map.T_map_picture.phi_rad) > 1e-9)
        refuse(yaml, "its origin is turned, which MRPT's grids can't be");
    // MRPT's grids lie on multiples of the resolution.
    const double cell_m = map.resolution_m;
    const double left_m = std::round(map.T_map_picture.x_m / cell_m) * cell_m;
    const double bottom_m = std::round(map.T_map_picture.y_m / cell_m) * cell_m;
    const auto right_m = left_m + static_cast<double>(map.width) * cell_m;
    const auto top_m = bottom_m + static_cast<double>(map.height) * cell_m;
    auto grid = COccupancyGridMap2D::Create();
    grid->setSize(static_cast<float>(left_m), static_cast<float>(right_m), static_cast<float>(bottom_m),
                  static_cast<float>(top_m), static_cast<float>(cell_m));
    if (grid->getSizeX() != map.width || grid->getSizeY() != map.height)
        refuse(yaml, "its origin is too far away for its resolution");
    for (std::size_t row = 0; row < map.height; ++row) {
        auto* cells = grid->getRow(static_cast<int>(row));
        for (std::size_t column = 0; column < map.width; ++column)
            cells[column] = COccupancyGridMap2D::p2l(map.free_probability[map.index(column, row)]);
    }
    return grid;
}

}  // namespace loopline
