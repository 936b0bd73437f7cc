#include "simulation/campus_plan.h"

#include <cmath>

#include "simulation/random_stream.h"

namespace loopline::simulation {
namespace {

/// Depths of a front's sections: no two on one line, and neighbours a fifth of the largest step apart at
/// least.
std::vector<double> stepped_front(int sections, double step_m, RandomStream& random) {
    const double apart_m = step_m / (20 * sections);
    std::vector<double> depths_m;
    while (static_cast<int>(depths_m.size()) < sections) {
        const double depth_m = random.uniform(0, step_m);
        bool good = depths_m.empty() || std::abs(depth_m - depths_m.back()) >= 0.4 * step_m;
        for (const double other_m : depths_m) good = good && std::abs(depth_m - other_m) >= apart_m;
        if (good) depths_m.push_back(depth_m);
    }
    return depths_m;
}

/// Where sections begin and end, as parts of the front: uneven, so that no step faces one of the other front.
std::vector<double> section_ends(int sections, RandomStream& random) {
    std::vector<double> ends{0};
    for (int i = 1; i < sections; ++i) ends.push_back((i + random.uniform(-0.3, 0.3)) / sections);
    ends.push_back(1);
    return ends;
}

/// Counter-clockwise around the building, from its corner of least x and y; fronts along x.
std::vector<Eigen::Vector2d> outline(const CampusSettings& s, RandomStream& random) {
    std::vector<Eigen::Vector2d> corners;
    const double x0 = -s.building_length_m / 2, y0 = -s.building_depth_m / 2;
    const auto front = [&](double sign) {
        const auto depths_m = stepped_front(s.sections, s.step_m, random);
        const auto ends = section_ends(s.sections, random);
        for (std::size_t i = 0; i < depths_m.size(); ++i)
            for (const double end : {ends[i], ends[i + 1]})
                corners.emplace_back(sign * (x0 + end * s.building_length_m), sign * (y0 + depths_m[i]));
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
