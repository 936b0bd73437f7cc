/// Where in a window of positions and headings a scan fits the map best (rows B2, B6 and B7: "find the
/// position and heading of the largest likelihood"). The patent goes through all of them; branch and bound
/// finds the same optimum (Land and Doig 1960; on grids of likelihood: Olson 2009, Hess et al. 2016).
#pragma once

#include <cstdint>
#include <cstdlib>
#include <limits>
#include <optional>
#include <vector>

#include "grid_map/frame.h"
#include "grid_map/scan_grid.h"

namespace loopline::grid_map {

struct SearchWindow {
    Pose2 T_map_center;
    int cells_x = 10, cells_y = 10;  ///< to both sides, along the axes of the map
    int headings = 40;               ///< to both sides
    double heading_step_rad = 0.25 * M_PI / 180;
    /// Standard deviations of the centre, which draw the best place towards it; infinite: the likelihood
    /// alone.
    double sigma_x_m = std::numeric_limits<double>::infinity(),
           sigma_y_m = std::numeric_limits<double>::infinity(),
           sigma_phi_rad = std::numeric_limits<double>::infinity();
    int min_score = 0;  ///< places below it are of no interest
    /// Places around one that is known already, to look for a rival of it.
    struct Exclusion {
        int dx_cells = 0, dy_cells = 0, heading = 0;
        int cells = 0, headings = 0;  ///< to both sides
        bool holds(int heading_index, int dx, int dy) const {
            return std::abs(heading_index - heading) <= headings && std::abs(dx - dx_cells) <= cells &&
                   std::abs(dy - dy_cells) <= cells;
        }
    };
    std::optional<Exclusion> without;
    std::vector<Exclusion> also_without;  ///< more of them
    /// Positions that count at all, one byte each: those with the lowest dy first, of these those with the
    /// lowest dx. Empty: all do.
    std::vector<std::uint8_t> allowed;
    bool holds_back(int heading_index, int dx, int dy) const {
        if (!allowed.empty() &&
            !allowed[static_cast<std::size_t>((dy + cells_y) * (2 * cells_x + 1) + dx + cells_x)])
            return true;
        if (without && without->holds(heading_index, dx, dy)) return true;
        for (const Exclusion& other : also_without)
            if (other.holds(heading_index, dx, dy)) return true;
        return false;
    }
};

struct SearchResult {
    Pose2 T_map_base;
    int dx_cells = 0, dy_cells = 0, heading = 0;  ///< from the centre
    int score = 0;   ///< sum of likelihoods, less what the centre's distance costs
    double fit = 0;  ///< mean likelihood of a return, 0 .. 1
};

/// The points that are searched with: about `count`, evenly along the surfaces, so that a near wall does not
/// outweigh.
std::vector<Eigen::Vector2f> search_points(const Frame& frame, std::size_t count);

/// The best place in the window; among equals that of the lowest heading, then y, then x. None if no place
/// has min_score.
std::optional<SearchResult> branch_and_bound(const ScanGrid& grid,
                                             const std::vector<Eigen::Vector2f>& points_base_m,
                                             const SearchWindow& window);

/// The same by trying them all: what branch_and_bound() is measured by.
std::optional<SearchResult> exhaustive_search(const ScanGrid& grid,
                                              const std::vector<Eigen::Vector2f>& points_base_m,
                                              const SearchWindow& window);

}  // namespace loopline::grid_map
