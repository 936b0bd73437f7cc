#include "simulation/campus_plan.h"

#include <cmath>

#include "simulation/random_stream.h"

namespace loopline::simulation {
namespace {

/// Depths of a front's sections: neighbours differ by at least a fifth of the largest step.
std::vector<double> stepped_front(int sections, double step_m, RandomStream& random) {
    std::vector<double> depths_m;
    while (static_cast<int>(depths_m.size()) < sections) {
        const double depth_m = random.uniform(0, step_m);
        if (depths_m.empty() || std::abs(depth_m - depths_m.back()) >= step_m / 5)
            depths_m.push_back(depth_m);
    }
    return depths_m;
}

/// Counter-clockwise around the building, from its corner of least x and y; fronts along x.
std::vector<Eigen::Vector2d> outline(const CampusSettings& s, RandomStream& random) {
    std::vector<Eigen::Vector2d> corners;
    const double section_m = s.building_length_m / s.sections;
    const double x0 = -s.building_length_m / 2, y0 = -s.building_depth_m / 2;
    const auto front = [&](double sign) {
        const auto depths_m = stepped_front(s.sections, s.step_m, random);
        for (int i = 0; i < s.sections; ++i) {
            const double y = sign * (y0 + depths_m[static_cast<std::size_t>(i)]);
            corners.emplace_back(sign * (x0 + i * section_m), y);
            corners.emplace_back(sign * (x0 + (i + 1) * section_m), y);
        }
    };
    front(1);
    front(-1);
    return corners;
}

void add_building(World& world, const Pose2& T_world_building, const std::vector<Eigen::Vector2d>& corners,
                  double height_m) {
    for (std::size_t i = 0; i < corners.size(); ++i)
        world.walls.push_back({T_world_building * corners[i],
                               T_world_building * corners[(i + 1) % corners.size()], 0, height_m});
}

}  // namespace

GeneratedPlan make_campus(const CampusSettings& s, std::uint64_t seed) {
    RandomStream random(seed, "campus");
    GeneratedPlan plan;
    const double column_m = s.building_length_m + s.gap_m, row_m = s.building_depth_m + s.street_m;
    int rows = 0;
    while (static_cast<int>(plan.world.walls.size()) < s.walls) {
        for (int column = 0; column < s.columns; ++column) {
            const Pose2 T_world_building{column * column_m + column_m / 2, rows * row_m + row_m / 2,
                                         random.uniform(-s.turned_rad, s.turned_rad)};
            add_building(plan.world, T_world_building, outline(s, random), s.height_m);
        }
        ++rows;
    }
    // Every street, there and back in turn: each passes the fronts on both of its sides.
    const double end_m = s.columns * column_m;
    for (int street = 0; street <= rows; ++street) {
        const double y = street * row_m;
        plan.route.emplace_back(street % 2 == 0 ? 0 : end_m, y);
        plan.route.emplace_back(street % 2 == 0 ? end_m : 0, y);
    }
    return plan;
}

}  // namespace loopline::simulation
