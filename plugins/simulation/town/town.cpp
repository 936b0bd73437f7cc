#include "simulation/town/town.h"

#include <algorithm>
#include <cmath>

#include "simulation/random_stream.h"
#include "simulation/town/buildings.h"
#include "simulation/town/car_shapes.h"

namespace loopline::simulation {
namespace {

// Across a street on whose right lane the way is; to the left there is one more lane.
constexpr double other_lane_m = 3.2;
constexpr double kerb_right_m = 4.3, pavement_m = 1.8, verge_m = 1.5;
constexpr double parked_right_m = 3.2;
// What must stay free of any street's middle line.
constexpr double building_clear_m = 6, car_clear_m = 2, thing_clear_m = 3.2, pavement_clear_m = 4;
constexpr double sunk_m = 0.4;
constexpr std::string_view parked_cars = "parked cars";

struct Heights {
    double lowest_m, highest_m;
};

/// Grows one thing after the other; what was there first stays.
class Grower {
 public:
    Grower(const Street& along, const Street& driven, const Ground& ground, const TownSettings& settings,
           const TownSeeds& seeds)
        : along_(along), ground_(ground), settings_(settings), seed_(seeds.town), cars_seed_(seeds.cars) {
        streets_.add(driven);
    }

    Town grow() {
        draw_side_streets();
        for (const auto& gallery : settings_.galleries)
            add_gallery(town_.mesh, along_, ground_, gallery[0], std::min(gallery[1], along_.length_m()),
                        gallery[2], gallery[3], seed_);
        for (const auto& tunnel : settings_.tunnels)
            add_tunnel(town_.mesh, along_, ground_, tunnel[0], std::min(tunnel[1], along_.length_m()),
                       tunnel[2], tunnel[3]);
        for_all_sides("houses", [this](const Street& street, double side, RandomStream& random) {
            build_row(street, side, random);
        });
        town_.buildings = town_.lots.taken().size();
        for_all_sides(parked_cars, [this](const Street& street, double side, RandomStream& random) {
            scatter(settings_.parked_per_km, street, random,
                    [&](double way_m) { park(street, side, way_m, random); });
        });
        for_all_sides("posts", [this](const Street& street, double side, RandomStream& random) {
            scatter(settings_.posts_per_km, street, random,
                    [&](double way_m) { plant_post(street, side, way_m, random); });
        });
        for_all_sides("trees", [this](const Street& street, double side, RandomStream& random) {
            scatter(settings_.trees_per_km, street, random,
                    [&](double way_m) { plant_tree(street, side, way_m, random); });
        });
        for_all_sides("bushes", [this](const Street& street, double side, RandomStream& random) {
            scatter(settings_.bushes_per_km, street, random,
                    [&](double way_m) { plant_bush(street, side, way_m, random); });
        });
        if (settings_.kerb_m > 0)
            for_all_sides("pavements", [this](const Street& street, double side, RandomStream&) {
                lay_pavement(street, side);
            });
        add_ground(town_.mesh, along_, streets_, ground_, settings_.ground_cell_m, settings_.reach_m);
        return std::move(town_);
    }

 private:
    void draw_side_streets() {
        if (settings_.side_street_m <= 0) return;
        RandomStream random(seed_, "side streets");
        for (double way_m = random.uniform(0.2, 0.7) * settings_.side_street_m; way_m < along_.length_m();
             way_m += settings_.side_street_m * random.uniform(0.7, 1.3)) {
            const Pose2 T_map_way = along_.at(way_m);
            for (const double side : {-1.0, 1.0}) {
                const double turn_rad = random.uniform(-0.25, 0.25), length_m = random.uniform(40, 90);
                if (in_gallery(way_m) || !random.chance(0.7)) continue;
                const Pose2 T_map_side = T_map_way * Pose2{0, 0, side * M_PI / 2 + turn_rad};
                // A street of its own only if it leads away from what is driven.
                if (streets_.distance_m(T_map_side * Eigen::Vector2d(30, 0), 20) < 20) continue;
                side_streets_.emplace_back(
                    std::vector<Eigen::Vector2d>{T_map_side * Eigen::Vector2d(building_clear_m, 0),
                                                 T_map_side * Eigen::Vector2d(length_m, 0)});
            }
        }
        for (const Street& street : side_streets_) streets_.add(street);
    }

    /// `visit(street, side, random)`, 1 to the left and -1 to the right; each with its own numbers, the
    /// driven street first.
    template <class Visit>
    void for_all_sides(std::string_view purpose, const Visit& visit) {
        RandomStream random(purpose == parked_cars ? cars_seed_ : seed_, purpose);
        for (const double side : {-1.0, 1.0}) visit(along_, side, random);
        for (const Street& street : side_streets_)
            for (const double side : {-1.0, 1.0}) visit(street, side, random);
    }

    bool in_gallery(double way_m) const {
        const auto over = [&](const auto& g) { return way_m > g[0] - 10 && way_m < g[1] + 10; };
        return std::any_of(settings_.galleries.begin(), settings_.galleries.end(), over) ||
               std::any_of(settings_.tunnels.begin(), settings_.tunnels.end(), over);
    }
    bool blocked(const Street& street, double way_m) const { return &street == &along_ && in_gallery(way_m); }

    /// Beside the street, `beside_m` from the edge of its lanes' middle line.
    static Pose2 beside(const Street& street, double side, double way_m, double beside_m) {
        const double more_m = side > 0 ? other_lane_m : 0;
        return street.at(way_m) * Pose2{0, side * (beside_m + more_m), 0};
    }

    /// Places at random ways, as many as `per_km` asks for.
    template <class Visit>
    void scatter(double per_km, const Street& street, RandomStream& random, const Visit& visit) {
        if (per_km <= 0) return;
        const double mean_m = 1000 / per_km;
        for (double way_m = mean_m * random.uniform(); way_m < street.length_m();
             way_m += mean_m * random.uniform(0.4, 1.6))
            if (!blocked(street, way_m)) visit(way_m);
    }

    Heights heights_below(const Footprint& footprint) const {
        Heights heights{1e9, -1e9};
        for (const double x : {-1.0, 0.0, 1.0})
            for (const double y : {-1.0, 0.0, 1.0}) {
                const double z_m = ground_.height_m(footprint.corner_m(x, y));
                heights = {std::min(heights.lowest_m, z_m), std::max(heights.highest_m, z_m)};
            }
        return heights;
    }

    bool take(const Footprint& footprint, double clearance_m) {
        if (!streets_.is_clear(footprint, clearance_m) || !town_.lots.is_free(footprint)) return false;
        town_.lots.take(footprint);
        return true;
    }

    void build_row(const Street& street, double side, RandomStream& random) {
        if (settings_.built <= 0) return;
        double way_m = random.uniform(0, 10);
        while (way_m < street.length_m()) {
            const double front_m = settings_.front_m * random.uniform(0.6, 1.5),
                         depth_m = random.uniform(8, 13);
            const double back_m = settings_.setback_m + settings_.setback_spread_m * random.uniform();
            const double gap_m = random.chance(0.5) ? 0.05 : random.uniform(1, 5);
            const double turned_rad = random.chance(0.2) ? random.uniform(-0.15, 0.15) : 0;
            const int storeys =
                settings_.least_storeys + random.index(settings_.storeys - settings_.least_storeys + 1);
            if (random.chance(settings_.built) && !blocked(street, way_m + front_m / 2)) {
                const Pose2 T_map_middle =
                    beside(street, side, way_m + front_m / 2, back_m + depth_m / 2) * Pose2{0, 0, turned_rad};
                build({T_map_middle, front_m, depth_m}, storeys, random);
            } else {
                build_garden_wall(street, side, way_m, front_m, back_m, random);
            }
            way_m += front_m + gap_m;
        }
    }

    void build(const Footprint& footprint, int storeys, RandomStream& random) {
        if (!take(footprint, building_clear_m)) return;
        const Heights heights = heights_below(footprint);
        add_building(town_.mesh, footprint, heights.lowest_m - sunk_m, heights.highest_m, storeys, random);
    }

    void build_garden_wall(const Street& street, double side, double way_m, double front_m, double back_m,
                           RandomStream& random) {
        const double height_m = random.uniform(0.8, 1.8);
        if (!random.chance(0.5) || blocked(street, way_m + front_m / 2)) return;
        const Footprint footprint{beside(street, side, way_m + front_m / 2, back_m), front_m, 0.25};
        if (!take(footprint, building_clear_m)) return;
        const Heights heights = heights_below(footprint);
        add_block(town_.mesh, footprint, heights.lowest_m - sunk_m, heights.highest_m + height_m,
                  Material::brick);
    }

    void park(const Street& street, double side, double way_m, RandomStream& random) {
        const CarShape shape = draw_car(random);
        const double turn_rad = random.normal(0.02) + (random.chance(0.5) ? M_PI : 0);
        const Pose2 T_map_car =
            beside(street, side, way_m, parked_right_m + random.uniform(-0.1, 0.15)) * Pose2{0, 0, turn_rad};
        if (take({T_map_car, shape.length_m + 0.6, shape.width_m}, car_clear_m))
            add_car(town_.mesh, on_floor(T_map_car, ground_.below(T_map_car)), shape);
    }

    void plant_post(const Street& street, double side, double way_m, RandomStream& random) {
        const bool sign = random.chance(0.4);
        const double height_m = sign ? 2.8 : random.uniform(5, 8);
        const Footprint footprint{beside(street, side, way_m, kerb_right_m + 0.5), 0.3, 0.3};
        if (!take(footprint, thing_clear_m)) return;
        const Eigen::Vector2d place_m = footprint.T_map_middle.translation();
        const double z_m = ground_.height_m(place_m);
        const double radius_m = sign ? 0.04 : 0.09;
        add_post(town_.mesh, place_m, z_m - sunk_m, z_m + height_m, radius_m, 0.7 * radius_m, 8,
                 Material::metal);
        if (!sign) return;
        const Pose2 T_map_plate = footprint.T_map_middle * Pose2{-0.06, 0, 0};
        add_block(town_.mesh, {T_map_plate, 0.03, 0.7}, z_m + 2.1, z_m + 2.8, Material::paint);
    }

    void plant_tree(const Street& street, double side, double way_m, RandomStream& random) {
        const double trunk_m = random.uniform(2.2, 3.5), radius_m = random.uniform(0.1, 0.28),
                     crown_m = random.uniform(1.2, 2.4), phase = random.uniform(0, 10),
                     beside_m = kerb_right_m + random.uniform(0.6, 2.5);
        const Footprint footprint{beside(street, side, way_m, beside_m), 2 * radius_m + 0.2,
                                  2 * radius_m + 0.2};
        if (!take(footprint, thing_clear_m)) return;
        const Eigen::Vector2d p = footprint.T_map_middle.translation();
        const double z_m = ground_.height_m(p);
        add_post(town_.mesh, p, z_m - sunk_m, z_m + trunk_m + 0.5, radius_m, 0.7 * radius_m, 8,
                 Material::bark);
        add_blob(town_.mesh, {p.x(), p.y(), z_m + trunk_m + crown_m}, crown_m, 1.2 * crown_m, 0.35, phase,
                 Material::foliage);
    }

    void plant_bush(const Street& street, double side, double way_m, RandomStream& random) {
        const double radius_m = random.uniform(0.4, 1), phase = random.uniform(0, 10),
                     beside_m = kerb_right_m + pavement_m + random.uniform(0.8, 3);
        const Footprint footprint{beside(street, side, way_m, beside_m), 2 * radius_m, 2 * radius_m};
        if (!take(footprint, thing_clear_m)) return;
        const Eigen::Vector2d p = footprint.T_map_middle.translation();
        add_blob(town_.mesh, {p.x(), p.y(), ground_.height_m(p) + 0.5 * radius_m}, radius_m, 0.9 * radius_m,
                 0.3, phase, Material::foliage);
    }

    /// Slab after slab beside the street, wherever no other street crosses; behind them the ground falls to
    /// what it was.
    void lay_pavement(const Street& street, double side) {
        constexpr double slab_m = 2;
        for (double way_m = 0; way_m + slab_m < street.length_m(); way_m += slab_m)
            if (!blocked(street, way_m)) lay_slab(street, side, way_m, way_m + slab_m);
    }

    void lay_slab(const Street& street, double side, double from_m, double to_m) {
        struct Edge {
            double beside_m, height_m;
        };
        const Edge edges[] = {{kerb_right_m, -0.1},
                              {kerb_right_m, settings_.kerb_m},
                              {kerb_right_m + pavement_m, settings_.kerb_m},
                              {kerb_right_m + pavement_m + verge_m, -0.02}};
        const auto corner_m = [&](double way_m, const Edge& edge) -> Eigen::Vector3d {
            const Eigen::Vector2d p = beside(street, side, way_m, edge.beside_m).translation();
            return {p.x(), p.y(), ground_.height_m(p) + edge.height_m};
        };
        for (const Edge& edge : edges)
            for (const double way_m : {from_m, to_m})
                if (streets_.distance_m(corner_m(way_m, edge).head<2>(), pavement_clear_m) < pavement_clear_m)
                    return;
        const Material materials[] = {Material::concrete, Material::pavement, Material::grass};
        for (std::size_t i = 0; i < 3; ++i)
            town_.mesh.add_quad(corner_m(from_m, edges[i]), corner_m(to_m, edges[i]),
                                corner_m(to_m, edges[i + 1]), corner_m(from_m, edges[i + 1]), materials[i]);
    }

    const Street& along_;
    const Ground& ground_;
    const TownSettings& settings_;
    std::uint64_t seed_, cars_seed_;
    std::vector<Street> side_streets_;
    StreetIndex streets_;
    Town town_;
};

}  // namespace

Town grow_town(const Street& along, const Street& driven, const Ground& ground, const TownSettings& settings,
               const TownSeeds& seeds) {
    return Grower(along, driven, ground, settings, seeds).grow();
}

}  // namespace loopline::simulation
