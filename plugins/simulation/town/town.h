/// A town that grows along the way that a vehicle drives: houses in rows, side streets, kerbs, parked cars,
/// trees, bushes, lamp posts, signs, walls of gardens; and galleries over the way. The seed decides; what
/// stands in one place stands there whenever the vehicle comes back.
#pragma once

#include <cstdint>
#include <vector>

#include "simulation/ground.h"
#include "simulation/town/street.h"

namespace loopline::simulation {

struct TownSettings {
    double built = 0.85;          ///< part of the fronts along a street that is built up
    double setback_m = 8;         ///< of fronts to the right of the way; to the left it has another lane
    double setback_spread_m = 3;  ///< how much farther back they may stand
    double front_m = 14;          ///< of a house, about
    int storeys = 4;              ///< at most
    int least_storeys = 1;
    double side_street_m = 90;  ///< way from one to the next, about; 0: none
    double kerb_m = 0.12;       ///< height of pavements; 0: none
    double parked_per_km = 50, trees_per_km = 50, bushes_per_km = 40, posts_per_km = 50;  ///< of each side
    double ground_cell_m = 2;
    double reach_m = 130;                        ///< how far from the way there is ground
    std::vector<std::vector<double>> galleries;  ///< from to width height, along the way
    std::vector<std::vector<double>> tunnels;    ///< the same
};

/// What stands for years, and the cars that are parked that day.
struct TownSeeds {
    TownSeeds(std::uint64_t both) : town(both), cars(both) {}
    TownSeeds(std::uint64_t of_town, std::uint64_t of_cars) : town(of_town), cars(of_cars) {}
    std::uint64_t town, cars;
};

struct Town {
    TriangleMesh mesh;
    Lots lots;                  ///< all that stands on the ground
    std::size_t buildings = 0;  ///< the first of those
};

/// Grows along `along`, and keeps clear of all that is `driven`, which may be several laps of it; in the map
/// frame, as the ground is.
Town grow_town(const Street& along, const Street& driven, const Ground& ground, const TownSettings& settings,
               const TownSeeds& seeds);

/// Triangles between heights `side_m` apart, wherever the street is within reach; asphalt on streets, grass
/// elsewhere.
void add_ground(TriangleMesh& mesh, const Street& driven, const StreetIndex& streets, const Ground& ground,
                double side_m, double reach_m);

/// Side walls, niches between pillars, and a ceiling over the way from `from_m` to `to_m`.
void add_gallery(TriangleMesh& mesh, const Street& driven, const Ground& ground, double from_m, double to_m,
                 double width_m, double height_m, std::uint64_t seed);

/// Smooth side walls and a flat ceiling, of the same cross section wherever one is: nothing tells how far one
/// has come.
void add_tunnel(TriangleMesh& mesh, const Street& driven, const Ground& ground, double from_m, double to_m,
                double width_m, double height_m);

}  // namespace loopline::simulation
