#include "output/map_server_grid.h"

#include <array>
#include <cmath>
#include <vector>

#include "output/output_file.h"

namespace loopline {
namespace {

using mrpt::maps::COccupancyGridMap2D;

/// The pixel of every value that a cell can have (MRPT keeps the log-odds of "free" in 8 bits).
std::array<std::uint8_t, 256> pixel_table() {
    std::array<std::uint8_t, 256> table{};
    for (int log_odds = -128; log_odds < 128; ++log_odds) {
        const double free_probability = COccupancyGridMap2D::l2p(static_cast<std::int8_t>(log_odds));
        const Cell cell = classify(1 - free_probability);
        table[static_cast<std::uint8_t>(log_odds)] = cell == Cell::occupied ? 0
                                                     : cell == Cell::free   ? 254
                                                                            : 205;
    }
    return table;
}

void write_pgm(const std::filesystem::path& pgm, const COccupancyGridMap2D& grid) {
    static_assert(sizeof(COccupancyGridMap2D::cellType) == 1, "the table has an entry for every cell value");
    const auto table = pixel_table();
    OutputFile out(pgm);
    out.text("P5\n").count(grid.getSizeX()).text(" ").count(grid.getSizeY()).text("\n255\n");
    std::vector<std::uint8_t> pixels(grid.getSizeX());
    for (auto row = static_cast<int>(grid.getSizeY()) - 1; row >= 0; --row) {
        const auto* cells = grid.getRow(row);
        for (std::size_t i = 0; i < pixels.size(); ++i)
            pixels[i] = table[static_cast<std::uint8_t>(cells[i])];
        out.bytes(pixels.data(), pixels.size());
    }
    out.commit();
}

/// -49.850002, a float's idea of -49.85, is written as -49.85.
double to_micrometre(float length_m) {
    return std::round(static_cast<double>(length_m) * 1e6) / 1e6;
}

}  // namespace

void write_map_server_grid(const std::filesystem::path& yaml, const COccupancyGridMap2D& grid) {
    std::filesystem::path pgm = yaml;
    pgm.replace_extension(".pgm");
    write_pgm(pgm, grid);
    OutputFile out(yaml);
    out.text("image: ").text(pgm.filename().string()).text("\nmode: trinary\nresolution: ");
    out.number(grid.getResolution()).text("\norigin: [");
    out.number(to_micrometre(grid.getXMin()))
        .text(", ")
        .number(to_micrometre(grid.getYMin()))
        .text(", 0]\nnegate: 0\noccupied_thresh: ");
    out.number(occupied_threshold).text("\nfree_thresh: ").number(free_threshold).text("\n");
    out.commit();
}

}  // namespace loopline
